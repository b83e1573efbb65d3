// Thread that converts, encodes and writes a camera's images, so that the thread of the poses never does.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <fire3dv/client.hpp>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "base/error.h"

namespace fire3dv::ros2 {

// Takes one image at a time. While it is busy the next images stay with the client library, where the newest
// replaces older ones: no queue, no stale images.
class ImageWorker {
 public:
  using Publish = std::function<Result<void>(const fire3dv_image&)>;

  explicit ImageWorker(Publish publish);  // called on the thread
  ~ImageWorker();                         // waits for the image at hand
  ImageWorker(const ImageWorker&) = delete;
  ImageWorker& operator=(const ImageWorker&) = delete;

  bool is_idle() const { return !busy_; }
  // The worker is idle and the image not null.
  void submit(Image image);

  uint64_t published() const { return published_; }
  uint64_t failed() const { return failed_; }
  // Message of the last failure, once.
  std::string take_failure();

 private:
  void run();

  Publish publish_;
  std::mutex mutex_;
  std::condition_variable wake_;
  Image image_;
  std::string failure_;
  bool stop_ = false;
  std::atomic<bool> busy_{false};
  std::atomic<uint64_t> published_{0}, failed_{0};
  std::thread thread_;
};

}  // namespace fire3dv::ros2
