// PNG and .npy file sink with its own writer thread, and the .npy writer:
//
//   DIR/frame_000000.png, DIR/frame_000001.png ...   or DIR/CAMERA/frame_... with folder_per_camera
//   DIR/frames.jsonl   one line per frame in write order: files, camera, pose frames (output_text.h)
//
// Epochs in frames.jsonl are hexadecimal strings, since JSON readers lose digits of 64-bit numbers. Files of
// an earlier run are replaced by name, others stay; frames.jsonl lists this run only.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "renderer/sinks/output_text.h"
#include "renderer/sinks/queued_sink.h"

namespace fire3dv::sinks {

struct FileSinkOptions {
  std::filesystem::path folder;
  bool folder_per_camera = false;  // required if one run writes several cameras
  size_t queue_limit = 4;          // frames in the queue before consume() blocks
};

class FileSink final : public QueuedSink {
 public:
  // Creates the folder. The error names the path element in the way.
  static Result<std::unique_ptr<FileSink>> open(const FileSinkOptions& options);
  ~FileSink() override;  // calls finish(); loses an unreported error

  uint64_t frames_written() const { return frames_written_; }
  // After finish(): frames of an earlier run in the same folders, beyond the last frame of this one. They
  // stay.
  uint64_t count_stale_frames() const;

 private:
  explicit FileSink(const FileSinkOptions& options);
  Result<void> write(const FrameImage& image) override;
  Result<void> complete() override;
  Result<std::filesystem::path> folder_of(const std::string& camera);

  const FileSinkOptions options_;
  // Owned by the worker thread.
  std::ofstream log_;
  std::map<std::string, std::filesystem::path> folder_of_camera_;  // relative to options_.folder
  std::map<std::filesystem::path, uint64_t> last_frame_of_folder_;

  std::atomic<uint64_t> frames_written_{0};
};

// Encodes the files of an image: colours as PNG, then each plane and the masks in NumPy's format. begin:
// their path without ending, "front/frame_000000". Returns their names; stops at the first error.
using WriteFile = std::function<Result<void>(const std::filesystem::path& name, std::vector<uint8_t> bytes)>;
Result<FrameFiles> write_frame_files(const FrameImage& image, const std::filesystem::path& begin,
                                     const WriteFile& write);

// Encodes an array in NumPy's .npy format (version 1.0), row by row.
std::vector<uint8_t> encode_npy(std::string_view numpy_type, std::span<const uint64_t> shape,
                                std::span<const uint8_t> values);
// The shape of FrameImage::amodal's masks, of type "|u1". The image has them.
std::array<uint64_t, 3> masks_shape(const FrameImage& image);

// Encodes an image plane in NumPy's .npy format (version 1.0): an array of shape (height, width), or (height,
// width, channels) for several channels.
std::vector<uint8_t> encode_npy(const FramePlane& plane, uint32_t width, uint32_t height);

// Writes the file atomically. The error names the path.
Result<void> write_npy(const std::filesystem::path& path, const FramePlane& plane, uint32_t width,
                       uint32_t height, base::Durability durability = base::Durability::contents_and_name);

}  // namespace fire3dv::sinks
