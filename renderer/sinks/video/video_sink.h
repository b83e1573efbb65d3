// Video sink with its own encoder thread:
//
//   VIDEO         the video file
//   VIDEO.jsonl   one line per frame: camera and pose frames (output_text.h)
//
// Both files appear at finish(). A crashed run leaves only files NAME.part-XXXXXX.
#pragma once

#include <memory>
#include <optional>

#include "base/files.h"
#include "renderer/sinks/queued_sink.h"
#include "renderer/sinks/video/video_file.h"

namespace fire3dv::sinks {

class VideoSink final : public QueuedSink {
 public:
  // width and height may be 0: the first frame then sets the size. All frames have the same size. The comment
  // is the provenance of the first frame, unless settings have one.
  static Result<std::unique_ptr<VideoSink>> open(const VideoSettings& settings);
  ~VideoSink() override;  // without finish(): removes all output
  // Removes all output of an interrupted run.
  void abandon();

 private:
  static constexpr size_t kQueueLimit = 4;
  explicit VideoSink(VideoSettings settings) : QueuedSink(kQueueLimit), settings_(std::move(settings)) {}
  Result<void> write(const FrameImage& image) override;
  Result<void> complete() override;

  // Owned by the worker thread.
  VideoSettings settings_;
  std::unique_ptr<VideoFile> file_;
  std::optional<base::AtomicFile> log_;
};

}  // namespace fire3dv::sinks
