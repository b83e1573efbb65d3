// Secondary devices: render image requests of the same scene and poses, each on its own thread.
#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "renderer/gpu/device/device.h"
#include "renderer/images/following_renderer.h"
#include "renderer/images/image_batch_renderer.h"
#include "renderer/live_scene/live_scene.h"
#include "renderer/loading/disk_caches.h"

namespace fire3dv::app {

// One secondary device. Its thread works between begin_...() and finish(); otherwise the owner may access
// everything.
class SecondaryDevice {
 public:
  // Starts opening the device.
  SecondaryDevice(gpu::Instance& instance, uint32_t index, gpu::AsyncCompute async_compute,
                  const CacheLocations& caches, const settings::DrawSettings& settings);
  ~SecondaryDevice();
  SecondaryDevice(const SecondaryDevice&) = delete;
  SecondaryDevice& operator=(const SecondaryDevice&) = delete;

  // Starts one submission of the request renderer's work, with the scene of `live` and the given settings.
  void begin_drawing(const LiveScene& live, const settings::DrawSettings& settings,
                     const ImageBatchRenderer::Moment& moment, const ImageBatchRenderer::Limits& limits);
  // Waits for the started job and rethrows its exceptions.
  Result<void> finish();

  // The following require an open device.
  gpu::Device& device() { return following_->device(); }
  const passes::SceneRenderer& renderer() const { return following_->renderer(); }
  ImageBatchRenderer& batch_renderer() { return *batch_renderer_; }
  // Must be called before the displayed scene is destroyed.
  void forget_scene() { following_->forget_scene(); }

 private:
  void begin(std::function<void()> job);
  void work(const std::stop_token& stop);
  Result<void> open(gpu::Instance& instance, uint32_t index, gpu::AsyncCompute async_compute,
                    const CacheLocations& caches, const settings::DrawSettings& settings);

  std::unique_ptr<FollowingRenderer> following_;
  std::optional<gpu::FrameRing> frames_;
  std::optional<ImageBatchRenderer> batch_renderer_;

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::function<void()> job_;
  bool busy_ = false;
  Result<void> result_;
  std::exception_ptr failure_;
  std::jthread thread_;  // last: it uses the members above
};

// All secondary devices.
class SecondaryDevices {
 public:
  // Opens the devices one after the other: a driver was observed to deadlock when it compiled pipelines for
  // four devices at once. indices: as listed by the instance. Fails for a device with other image abilities
  // than the first.
  static Result<SecondaryDevices> open(gpu::Instance& instance, std::span<const uint32_t> indices,
                                       gpu::AsyncCompute async_compute, const CacheLocations& caches,
                                       const settings::DrawSettings& settings,
                                       const passes::SceneRenderer& first);
  void forget_scene();
  std::span<const std::unique_ptr<SecondaryDevice>> all() const { return devices_; }

 private:
  std::vector<std::unique_ptr<SecondaryDevice>> devices_;
};

}  // namespace fire3dv::app
