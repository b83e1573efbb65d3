// Video encoder and container file (libav). sRGB pixels become limited-range BT.709 YUV with matching tags
// (primaries and matrix BT.709, transfer sRGB); FFV1 stores RGB losslessly. Grey values of 12 bits are stored
// losslessly by H.265. The output is deterministic for one libav version.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "base/error.h"

namespace fire3dv::sinks {

struct VideoSettings {
  std::filesystem::path path;  // extension selects the container: .mp4, .mkv or .webm
  std::string codec;           // h264, h265, av1 or ffv1; empty: h264, or av1 in .webm
  // Constant rate factor: smaller is better. nullopt: visually near lossless.
  std::optional<int> crf;
  bool full_chroma = false;  // 4:4:4 instead of 4:2:0; few players support it
  bool is_gray12 = false;    // lossless grey of 12 bits, by codec h265
  // Frames from one key frame to the next, without frames that refer to later ones; nullopt: the encoder's
  // choice.
  std::optional<int> key_frame_interval;
  uint32_t width = 0, height = 0;
  int64_t fps_numerator = 30, fps_denominator = 1;
  std::string comment;  // metadata of the file; empty: none
};

// Tests the file extension for a supported container.
bool is_video_name(const std::filesystem::path& path);
// Tests the extension for an unsupported video container, so that it is not taken for a folder name.
bool is_foreign_video_name(const std::filesystem::path& path);

// Checks settings without opening a file; sizes only if they are set. The error lists the available codecs.
Result<void> check_video_settings(const VideoSettings& settings);

// Comment of an untrusted file; empty: it has none. The error names the file.
Result<std::string> read_video_comment(const std::filesystem::path& path);

class VideoFile {
 public:
  // Writes to NAME.part-XXXXXX until finish().
  static Result<std::unique_ptr<VideoFile>> open(const VideoSettings& settings);
  ~VideoFile();  // removes an unfinished file
  VideoFile(const VideoFile&) = delete;
  VideoFile& operator=(const VideoFile&) = delete;

  // rgba8: width * height * 4 bytes, top row first. Not with is_gray12.
  Result<void> add(std::span<const uint8_t> rgba8);
  // width * height values from 0 to 4095, top row first. With is_gray12.
  Result<void> add_gray12(std::span<const uint16_t> values);
  // Flushes the encoder and renames the file to its path.
  Result<void> finish();
  uint64_t frames() const;

 private:
  friend Result<void> check_video_settings(const VideoSettings& settings);  // opens an encoder
  struct Impl;
  explicit VideoFile(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace fire3dv::sinks
