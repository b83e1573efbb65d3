#include "renderer/serve/encoder.h"

#include <algorithm>
#include <new>
#include <optional>
#include <utility>

#include "renderer/serve/jpeg.h"

namespace fire3dv::serve {

Encoder::~Encoder() {
  {
    const std::scoped_lock lock(mutex_);
    is_ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Encoder::add(ViewerId viewer, Image&& image) {
  {
    const std::scoped_lock lock(mutex_);
    const auto waiting = std::ranges::find(jobs_, viewer, &Job::viewer);
    if (waiting != jobs_.end())
      waiting->image = std::move(image);
    else
      jobs_.push_back({viewer, std::move(image)});
  }
  changed_.notify_one();
}

void Encoder::run() {
  for (;;) {
    std::optional<Job> job;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return is_ending_ || !jobs_.empty(); });
      if (is_ending_) return;
      job.emplace(std::move(jobs_.front()));
      jobs_.pop_front();
    }
    try {
      std::vector<uint8_t> message;
      append_header(job->image.header, message);
      const ImageHeader& header = job->image.header;
      if (append_jpeg(job->image.rgba8, header.width, header.height, job->image.quality, message))
        take_(job->viewer, std::move(message));
    } catch (const std::bad_alloc&) {  // the image is lost; the viewer gets none until it connects again
    }
  }
}

}  // namespace fire3dv::serve
