#include "renderer/gpu/device/pipeline_builder.h"

#include <algorithm>
#include <atomic>
#include <system_error>
#include <utility>

#include "renderer/gpu/device/device.h"
#include "renderer/gpu/device/pipeline_count.h"

namespace fire3dv::gpu {
namespace {

std::atomic<uint64_t> begun{0};

}  // namespace

uint64_t pipelines_begun() {
  return begun;
}

VkPipeline PipelineMaking::get() {
  const std::lock_guard lock(mutex_);
  if (make_) {
    try {
      pipeline_ = std::exchange(make_, {})();
    } catch (...) {
      failure_ = std::current_exception();
    }
  }
  if (failure_) std::rethrow_exception(failure_);
  return pipeline_;
}

VkPipeline PipelineMaking::take_or_drop() {
  return stays_ ? VK_NULL_HANDLE : end();
}

VkPipeline PipelineMaking::end() {
  const std::lock_guard lock(mutex_);
  make_ = {};
  return std::exchange(pipeline_, VK_NULL_HANDLE);
}

PipelineMakers::~PipelineMakers() {
  {
    const std::lock_guard lock(mutex_);
    waiting_.clear();
  }
  for (std::jthread& thread : threads_) thread.request_stop();
}

void PipelineMakers::add(std::shared_ptr<PipelineMaking> making) {
  const std::lock_guard lock(mutex_);
  waiting_.push_back(std::move(making));
  one_more_waits();
}

void PipelineMakers::add_first(std::shared_ptr<PipelineMaking> making) {
  const std::lock_guard lock(mutex_);
  waiting_.push_front(std::move(making));
  one_more_waits();
}

void PipelineMakers::one_more_waits() {
  more_.notify_one();
  constexpr size_t kMaxThreads = 8;
  const size_t wanted = std::clamp<size_t>(std::thread::hardware_concurrency(), 1, kMaxThreads);
  if (threads_.size() >= wanted) return;
  try {
    threads_.emplace_back([this](const std::stop_token& stop) { work(stop); });
  } catch (const std::system_error&) {
    // Without a thread, the first user of the pipeline compiles it.
  }
}

void PipelineMakers::work(const std::stop_token& stop) {
  for (;;) {
    std::shared_ptr<PipelineMaking> making;
    {
      std::unique_lock lock(mutex_);
      if (!more_.wait(lock, stop, [this] { return !waiting_.empty(); })) return;
      making = std::move(waiting_.front());
      waiting_.pop_front();
    }
    try {
      making->get();
    } catch (const std::exception&) {
      // get() rethrows the exception to the pipeline's owner.
    }
  }
}

Pipeline& Pipeline::operator=(Pipeline&& other) noexcept {
  if (this != &other) {
    reset();
    device_ = other.device_;
    handle_ = std::move(other.handle_);
    making_ = std::move(other.making_);
  }
  return *this;
}

VkPipeline Pipeline::get() const {
  if (making_) {
    ++begun;
    const VkPipeline made = making_->get();
    if (making_->stays()) device_->pipeline_keeper().hold(made);
    handle_ = PipelineHandle(*device_, made);
    making_.reset();
  }
  return handle_.get();
}

void Pipeline::reset() {
  if (making_) {
    // A handle retires the pipeline after the frames that use it.
    if (const VkPipeline made = making_->take_or_drop()) handle_ = PipelineHandle(*device_, made);
    making_.reset();
  }
  handle_.reset();
}

}  // namespace fire3dv::gpu
