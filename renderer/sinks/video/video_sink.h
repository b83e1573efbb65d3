// Video sink with its own encoder thread:
//
//   VIDEO         the video file
//   VIDEO.jsonl   one line per frame: camera and pose frames (output_text.h)
//
// Both files appear at finish(). A crashed run leaves only files NAME.part-XXXXXX.
#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "base/files.h"
#include "renderer/sinks/frame.h"
#include "renderer/sinks/video/video_file.h"

namespace fire3dv::sinks {

class VideoSink final : public FrameSink {
 public:
  // width and height may be 0: the first frame then sets the size. All frames have the same size.
  static Result<std::unique_ptr<VideoSink>> open(const VideoSettings& settings);
  ~VideoSink() override;  // without finish(): removes all output

  Result<void> consume(FrameImage&& image) override;
  Result<void> finish() override;
  // Removes all output of an interrupted run.
  void abandon();

 private:
  explicit VideoSink(VideoSettings settings) : settings_(std::move(settings)) {}
  void work();
  Result<void> write(const FrameImage& image);
  Result<void> complete();
  Result<void> report_error();  // requires mutex_
  void end_thread();

  // Owned by the worker thread.
  VideoSettings settings_;
  std::unique_ptr<VideoFile> file_;
  std::optional<base::AtomicFile> log_;

  std::mutex ending_mutex_;  // of finish(), which several threads may call
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<FrameImage> queue_;
  bool closing_ = false, finished_ = false;
  std::optional<Error> error_;
  bool error_reported_ = false;
  std::thread worker_;
};

}  // namespace fire3dv::sinks
