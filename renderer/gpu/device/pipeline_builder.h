// Background compilation of pipelines. A driver may take long for a pipeline, and most of the start-up work
// does not need one.
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "renderer/gpu/device/handle.h"

namespace fire3dv::gpu {

// One pipeline being compiled, shared by its owner and a worker thread.
class PipelineMaking {
 public:
  // Called at most once, on any thread.
  using Make = std::function<VkPipeline()>;
  explicit PipelineMaking(Make make) : make_(std::move(make)) {}

  // Compiles here when no thread has begun, or waits for the thread that has. Rethrows the exception of Make
  // at each call.
  VkPipeline get();
  // Returns null when compilation has not begun, and prevents it from then on. Waits for a thread that
  // compiles.
  VkPipeline take_or_drop();

  // The pipeline stays when an owner goes: take_or_drop() does nothing from now on. Before the making is
  // shared with a thread.
  void stay() { stays_ = true; }
  bool stays() const { return stays_; }
  // As take_or_drop(), also of a pipeline that stays.
  VkPipeline end();

 private:
  std::mutex mutex_;  // held during compilation
  bool stays_ = false;
  Make make_;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  std::exception_ptr failure_;
};

// Pool of compiler threads. They start with the first pipeline and process requests in order, after those of
// add_first().
class PipelineMakers {
 public:
  PipelineMakers() = default;
  ~PipelineMakers();
  PipelineMakers(const PipelineMakers&) = delete;
  PipelineMakers& operator=(const PipelineMakers&) = delete;

  void add(std::shared_ptr<PipelineMaking> making);
  void add_first(std::shared_ptr<PipelineMaking> making);

 private:
  void one_more_waits();  // requires the mutex
  void work(const std::stop_token& stop);

  std::mutex mutex_;
  std::condition_variable_any more_;
  std::deque<std::shared_ptr<PipelineMaking>> waiting_;
  std::vector<std::jthread> threads_;
};

// A compiled or compiling pipeline. Like Handle, it belongs to the device's thread.
class Pipeline {
 public:
  Pipeline() = default;
  Pipeline(Device& device, VkPipeline made) : device_(&device), handle_(device, made) {}
  Pipeline(Device& device, std::shared_ptr<PipelineMaking> making)
      : device_(&device), making_(std::move(making)) {}
  Pipeline(Pipeline&&) noexcept = default;
  Pipeline& operator=(Pipeline&& other) noexcept;
  ~Pipeline() { reset(); }

  VkPipeline get() const;  // waits for compilation; throws VulkanFailure
  explicit operator bool() const { return handle_ || making_; }

 private:
  void reset();

  Device* device_ = nullptr;
  mutable PipelineHandle handle_;
  mutable std::shared_ptr<PipelineMaking> making_;  // until get() was called
};

}  // namespace fire3dv::gpu
