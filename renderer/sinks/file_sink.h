// Writes every frame as a PNG, from a thread of its own:
//
//   DIR/frame_000000.png, DIR/frame_000001.png ...   or DIR/CAMERA/frame_... with folder_per_camera
//   DIR/frames.jsonl   one line a frame, in the order written: which file, which camera, which pose frames it
//   shows.
//                      Epochs are hexadecimal strings: JSON readers lose digits of 64-bit numbers.
//
// Files of an earlier run in DIR are overwritten by name and otherwise left alone; frames.jsonl lists this
// run's only.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "renderer/sinks/frame.h"

namespace fire3dv::sinks {

struct FileSinkOptions {
  std::filesystem::path folder;
  bool folder_per_camera = false;  // needed when several cameras are taken in one run
  size_t queue_limit = 4;          // frames that wait for the disk before take() does
};

class FileSink final : public FrameSink {
 public:
  // Makes the folder. The error names what of the path is in the way.
  static Result<std::unique_ptr<FileSink>> open(const FileSinkOptions& options);
  ~FileSink() override;  // finishes; an error not told before is lost, so call finish()

  Result<void> take(FrameImage&& image) override;
  Result<void> finish() override;

  uint64_t frames_written() const { return frames_written_; }
  uint64_t frames_dropped() const { return frames_dropped_; }  // taken after an error

 private:
  explicit FileSink(const FileSinkOptions& options);
  void work();
  Result<void> write(const FrameImage& image);
  Result<std::filesystem::path> folder_of(const std::string& camera);
  void flush_series();
  Result<void> tell_error_once();  // with mutex_ held

  const FileSinkOptions options_;
  // The worker's own.
  std::ofstream log_;
  std::map<std::string, std::filesystem::path> folder_of_camera_;  // relative to options_.folder
  std::map<std::filesystem::path, uint64_t> last_frame_of_folder_;

  std::atomic<uint64_t> frames_written_{0}, frames_dropped_{0};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<FrameImage> queue_;
  bool closing_ = false;
  std::optional<Error> error_;
  bool error_told_ = false;
  std::thread worker_;
};

}  // namespace fire3dv::sinks
