#include "renderer/sinks/video/video_sink.h"

#include <span>
#include <string>

#include "renderer/sinks/output_text.h"

namespace fire3dv::sinks {
namespace {

constexpr size_t kQueueLimit = 4;  // frames in the queue before consume() blocks

}  // namespace

Result<std::unique_ptr<VideoSink>> VideoSink::open(const VideoSettings& settings) {
  if (auto good = check_video_settings(settings); !good) return good.error();
  std::unique_ptr<VideoSink> sink(new VideoSink(settings));
  if (settings.width != 0) {
    auto file = VideoFile::open(settings);
    if (!file) return file.error();
    sink->file_ = std::move(*file);
  }
  auto log = base::AtomicFile::create(settings.path.string() + ".jsonl");
  if (!log) return log.error();
  sink->log_.emplace(std::move(*log));
  sink->worker_ = std::thread([raw = sink.get()] { raw->work(); });
  return sink;
}

VideoSink::~VideoSink() {
  abandon();
}

void VideoSink::end_thread() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
    changed_.notify_all();
  }
  if (worker_.joinable()) worker_.join();
}

void VideoSink::abandon() {
  const std::lock_guard ending(ending_mutex_);
  if (finished_) return;
  {
    const std::lock_guard lock(mutex_);
    queue_.clear();
  }
  end_thread();
  file_.reset();
  log_.reset();
  finished_ = true;
}

Result<void> VideoSink::consume(FrameImage&& image) {
  FIRE3DV_ASSERT(is_consistent(image));
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return queue_.size() < kQueueLimit || error_ || closing_; });
  if (closing_) return {};  // the program ends
  if (error_) return report_error();
  queue_.push_back(std::move(image));
  changed_.notify_all();
  return {};
}

Result<void> VideoSink::finish() {
  const std::lock_guard ending(ending_mutex_);
  end_thread();
  const std::lock_guard lock(mutex_);
  if (!error_ && !finished_) {
    if (Result<void> completed = complete(); !completed) error_ = completed.error();
  }
  finished_ = finished_ || !error_;
  return report_error();
}

Result<void> VideoSink::report_error() {
  if (!error_ || error_reported_) return {};
  error_reported_ = true;
  return *error_;
}

void VideoSink::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return !queue_.empty() || closing_; });
    if (queue_.empty()) return;
    const FrameImage image = std::move(queue_.front());
    queue_.pop_front();
    changed_.notify_all();
    lock.unlock();
    Result<void> written = write(image);
    lock.lock();
    if (written) continue;
    error_ = written.error();
    queue_.clear();
    changed_.notify_all();
    return;
  }
}

Result<void> VideoSink::write(const FrameImage& image) {
  if (!file_) {
    settings_.width = image.width;
    settings_.height = image.height;
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
