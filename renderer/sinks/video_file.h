// A video, encoded frame by frame. sRGB pixels become BT.709 YUV of limited range and are tagged as what they
// are (primaries and matrix BT.709, transfer sRGB); FFV1 keeps the RGB bytes. The same frames give the same
// bytes with the same libav.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocol/error.h"

namespace fire3dv::sinks {

struct VideoSettings {
  std::filesystem::path path;  // its ending says the container: .mp4, .mkv or .webm
  std::string codec;           // h264, h265, av1 or ffv1; empty: h264, and av1 in .webm
  std::optional<int> crf;  // quality: smaller is better; nothing: one that is hard to tell from the original
  bool full_chroma = false;  // 4:4:4 instead of 4:2:0, which few players show
  uint32_t width = 0, height = 0;
  int64_t fps_numerator = 30, fps_denominator = 1;
};

// By its name's ending.
bool is_video_name(const std::filesystem::path& path);
// An ending of a video that is not written here: nobody means a folder by it.
bool is_foreign_video_name(const std::filesystem::path& path);

// Without opening anything: what can be told of settings at once. Sizes are checked when they are given. The
// error lists the codecs that there are.
Result<void> check_video_settings(const VideoSettings& settings);

class VideoFile {
 public:
  // Written as NAME.part-XXXXXX until it is complete.
  static Result<std::unique_ptr<VideoFile>> open(const VideoSettings& settings);
  ~VideoFile();  // what is not finished is removed
  VideoFile(const VideoFile&) = delete;
  VideoFile& operator=(const VideoFile&) = delete;

  // width * height * 4 bytes of RGBA, rows from the top.
  Result<void> add(std::span<const uint8_t> rgba8);
  // Writes what the encoder still holds, and gives the file its name.
  Result<void> finish();
  uint64_t frames() const;

 private:
  struct Impl;
  explicit VideoFile(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace fire3dv::sinks
