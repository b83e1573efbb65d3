#include "adapters/ros2/images/image_worker.h"

#include <new>
#include <utility>

namespace fire3dv::ros2 {

ImageWorker::ImageWorker(Publish publish) : publish_(std::move(publish)), thread_([this] { run(); }) {}

ImageWorker::~ImageWorker() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void ImageWorker::submit(Image image) {
  FIRE3DV_ASSERT(image && !busy_);
  busy_ = true;
  {
    const std::lock_guard lock(mutex_);
    image_ = std::move(image);
  }
  wake_.notify_one();
}

std::string ImageWorker::take_failure() {
  const std::lock_guard lock(mutex_);
  return std::exchange(failure_, {});
}

void ImageWorker::run() {
  while (true) {
    Image image;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return stop_ || image_; });
      if (stop_) return;
      image = std::move(image_);
    }
    Result<void> done;
    try {
      done = publish_(*image);
    } catch (const std::bad_alloc&) {
      done = Error{"memory is short"};
    }
    image.reset();  // before the next one is taken: the slot is free again
    if (done) {
      ++published_;
    } else {
      ++failed_;
      const std::lock_guard lock(mutex_);
      failure_ = done.error().message;
    }
    busy_ = false;
  }
}

}  // namespace fire3dv::ros2
