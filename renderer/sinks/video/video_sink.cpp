#include "renderer/sinks/video/video_sink.h"

#include <span>
#include <string>

#include "renderer/sinks/output_text.h"

namespace fire3dv::sinks {

Result<std::unique_ptr<VideoSink>> VideoSink::open(const VideoSettings& settings) {
  if (auto good = check_video_settings(settings); !good) return good.error();
  std::unique_ptr<VideoSink> sink(new VideoSink(settings));
  if (settings.width != 0) {  // reports errors before a frame is drawn; write() opens it with the provenance
    auto file = VideoFile::open(settings);
    if (!file) return file.error();
  }
  auto log = base::AtomicFile::create(settings.path.string() + ".jsonl");
  if (!log) return log.error();
  sink->log_.emplace(std::move(*log));
  sink->start();
  return sink;
}

VideoSink::~VideoSink() {
  abandon();
}

void VideoSink::abandon() {
  if (!abandon_queue()) return;
  file_.reset();
  log_.reset();
}

Result<void> VideoSink::write(const FrameImage& image) {
  if (!file_) {
    if (settings_.width == 0) {
      settings_.width = image.width;
      settings_.height = image.height;
    }
    if (image.run_provenance && settings_.comment.empty()) settings_.comment = *image.run_provenance;
    auto file = VideoFile::open(settings_);
    if (!file) return file.error();
    file_ = std::move(*file);
  }
  if (image.width != settings_.width || image.height != settings_.height)
    return Error{"frame " + std::to_string(image.frame_index) +
                 " has another size than the frames before it; a video has one"};
  if (auto added = file_->add(image.rgba8); !added) return added;
  const std::string line = frame_line({settings_.path.filename(), {}}, image);
  return log_->append(std::as_bytes(std::span(line)));
}

Result<void> VideoSink::complete() {
  if (!file_) return Error{"no frame was given for " + settings_.path.string()};
  if (auto finished = file_->finish(); !finished) return finished;
  return log_->commit();
}

}  // namespace fire3dv::sinks
