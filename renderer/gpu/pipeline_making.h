// Pipelines are made on threads of their own: a driver may take long for each of them, and most of what else
// a start has to do does not need them yet.
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "renderer/gpu/handle.h"

namespace fire3dv::gpu {

// One pipeline on its way, shared by its owner and a thread that may make it.
class PipelineMaking {
 public:
  // Called at most once, on any thread.
  using Make = std::function<VkPipeline()>;
  explicit PipelineMaking(Make make) : make_(std::move(make)) {}

  // Makes it here when no thread has begun, else waits for that one. Throws what Make has thrown, each time.
  VkPipeline get();
  // Null when it was not begun, and then it never will be. Waits for a thread that is at it.
  VkPipeline take_or_drop();

 private:
  std::mutex mutex_;  // held while it is made
  Make make_;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  std::exception_ptr failure_;
};

// Threads that start with the first pipeline and take them in order, but for those that are to be first.
class PipelineMakers {
 public:
  PipelineMakers() = default;
  ~PipelineMakers();
  PipelineMakers(const PipelineMakers&) = delete;
  PipelineMakers& operator=(const PipelineMakers&) = delete;

  void add(std::shared_ptr<PipelineMaking> making);
  void add_first(std::shared_ptr<PipelineMaking> making);

 private:
  void one_more_waits();  // with the mutex held
  void work(const std::stop_token& stop);

  std::mutex mutex_;
  std::condition_variable_any more_;
  std::deque<std::shared_ptr<PipelineMaking>> waiting_;
  std::vector<std::jthread> threads_;
};

// A pipeline, made or on its way. Like Handle it belongs to the device's thread.
class Pipeline {
 public:
  Pipeline() = default;
  Pipeline(Device& device, VkPipeline made) : device_(&device), handle_(device, made) {}
  Pipeline(Device& device, std::shared_ptr<PipelineMaking> making)
      : device_(&device), making_(std::move(making)) {}
  Pipeline(Pipeline&&) noexcept = default;
  Pipeline& operator=(Pipeline&& other) noexcept;
  ~Pipeline() { reset(); }

  VkPipeline get() const;  // waits until it is made; throws VulkanFailure
  explicit operator bool() const { return handle_ || making_; }

 private:
  void reset();

  Device* device_ = nullptr;
  mutable PipelineHandle handle_;
  mutable std::shared_ptr<PipelineMaking> making_;  // until it was asked for
};

}  // namespace fire3dv::gpu
