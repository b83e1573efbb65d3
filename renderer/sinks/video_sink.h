// Encodes frames on a thread of its own:
//
//   VIDEO         the video, once it is whole
//   VIDEO.jsonl   one line a frame: which camera, which pose frames it shows (frame_line.h)
//
// Both appear at finish(); a run that does not come so far leaves files NAME.part-XXXXXX.
#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "protocol/base/atomic_file.h"
#include "renderer/sinks/frame.h"
#include "renderer/sinks/video_file.h"

namespace fire3dv::sinks {

class VideoSink final : public FrameSink {
 public:
  // settings.width and height may be 0: then the first frame says them. All frames have the same.
  static Result<std::unique_ptr<VideoSink>> open(const VideoSettings& settings);
  ~VideoSink() override;  // without finish(): nothing is left

  Result<void> take(FrameImage&& image) override;
  Result<void> finish() override;
  // Nothing is to be left: the run was interrupted.
  void abandon();

 private:
  explicit VideoSink(VideoSettings settings) : settings_(std::move(settings)) {}
  void work();
  Result<void> write(const FrameImage& image);
  Result<void> complete();
  Result<void> tell_error_once();  // with mutex_ held
  void end_thread();

  // The worker's own.
  VideoSettings settings_;
  std::unique_ptr<VideoFile> file_;
  std::optional<base::AtomicFile> log_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<FrameImage> queue_;
  bool closing_ = false, finished_ = false;
  std::optional<Error> error_;
  bool error_told_ = false;
  std::thread worker_;
};

}  // namespace fire3dv::sinks
