// Frame sink with a writer thread and a bounded queue before it.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>

#include "base/error.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::sinks {

// The first error ends the thread, drops the queue and is reported once, by the next call. A frame that comes
// after finish() is dropped: the program ends. A subclass ends the thread in its destructor.
class QueuedSink : public FrameSink {
 public:
  // Waits for space in the queue.
  Result<void> consume(FrameImage&& image) final;
  // Writes the queue, then completes the output.
  Result<void> finish() final;

 protected:
  explicit QueuedSink(size_t queue_limit) : queue_limit_(queue_limit) {}
  void start();
  // Drops the queue and ends the thread, without complete(). False: the output is complete.
  bool abandon_queue();

  // On the thread, in the order of the frames.
  virtual Result<void> write(const FrameImage& image) = 0;
  // After the last frame, if none failed. Not again after success.
  virtual Result<void> complete() = 0;

 private:
  void end_thread();
  void work();
  Result<void> report_error();  // requires mutex_

  const size_t queue_limit_;
  bool is_complete_ = true;  // or not started, or abandoned
  std::mutex ending_mutex_;  // of the end of the thread, which several threads may want
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<FrameImage> queue_;
  bool is_closing_ = false, is_error_reported_ = false;
  std::optional<Error> error_;
  std::thread worker_;
};

}  // namespace fire3dv::sinks
