#include "renderer/sinks/queued_sink.h"

#include <utility>

#include "base/process/start_thread.h"

namespace fire3dv::sinks {

void QueuedSink::start() {
  is_complete_ = false;
  worker_ = start_thread("image or video file", [this] { work(); });
}

bool QueuedSink::abandon_queue() {
  const std::lock_guard ending(ending_mutex_);
  if (is_complete_) return false;
  {
    const std::lock_guard lock(mutex_);
    queue_.clear();
  }
  end_thread();
  return is_complete_ = true;
}

void QueuedSink::end_thread() {
  {
    const std::lock_guard lock(mutex_);
    is_closing_ = true;
    changed_.notify_all();
  }
  if (worker_.joinable()) worker_.join();
}

Result<void> QueuedSink::consume(FrameImage&& image) {
  FIRE3DV_ASSERT(is_consistent(image));
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return queue_.size() < queue_limit_ || error_ || is_closing_; });
  if (is_closing_) return {};
  if (error_) return report_error();
  queue_.push_back(std::move(image));
  changed_.notify_all();
  return {};
}

Result<void> QueuedSink::finish() {
  const std::lock_guard ending(ending_mutex_);
  end_thread();
  const std::lock_guard lock(mutex_);
  if (!error_ && !is_complete_) {
    if (Result<void> completed = complete(); !completed) error_ = completed.error();
    is_complete_ = !error_;
  }
  return report_error();
}

Result<void> QueuedSink::report_error() {
  if (!error_ || std::exchange(is_error_reported_, true)) return {};
  return *error_;
}

void QueuedSink::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return !queue_.empty() || is_closing_; });
    if (queue_.empty()) return;
    const FrameImage image = std::move(queue_.front());
    queue_.pop_front();
    changed_.notify_all();  // the next frame may queue while this one is written
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

}  // namespace fire3dv::sinks
