// Devices beside the one that draws the window and the frames that nobody asked for: they draw images for
// simulators, each on a thread of its own, all of the same scene and poses.
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

#include "renderer/app/cache_places.h"
#include "renderer/app/image_maker.h"
#include "renderer/app/live_scene.h"
#include "renderer/gpu/device.h"

namespace fire3dv::app {

// Its thread works between begin_...() and finish(); the rest of the time all of it is its owner's.
class FurtherDevice {
 public:
  // Begins to open the device.
  FurtherDevice(gpu::Instance& instance, uint32_t index, gpu::AsyncCompute async_compute,
                const CachePlaces& places, const passes::DrawSettings& settings);
  ~FurtherDevice();
  FurtherDevice(const FurtherDevice&) = delete;
  FurtherDevice& operator=(const FurtherDevice&) = delete;

  // One submission of the maker's work. Shows what `live` shows, drawn as the settings say.
  void begin_drawing(const LiveScene& live, const passes::DrawSettings& settings,
                     const ImageMaker::Moment& moment, uint64_t most_bytes);
  // Waits for what was begun, and throws what it has thrown.
  Result<void> finish();

  // The rest after the device is open.
  gpu::Device& device() { return *device_; }
  const passes::SceneRenderer& renderer() const { return *renderer_; }
  ImageMaker& maker() { return *maker_; }
  // The scene that was shown is about to go.
  void forget_scene();

 private:
  void begin(std::function<void()> job);
  void work(const std::stop_token& stop);
  Result<void> open(gpu::Instance& instance, uint32_t index, gpu::AsyncCompute async_compute,
                    const CachePlaces& places, const passes::DrawSettings& settings);
  Result<void> show(const LiveScene& live, passes::DrawSettings settings);
  void make_renderer(const passes::DrawSettings& settings);

  std::unique_ptr<gpu::Device> device_;
  std::optional<passes::SceneRenderer> renderer_;
  std::optional<gpu::FrameRing> frames_;
  std::optional<ImageMaker> maker_;
  std::optional<uint64_t> shown_scene_;  // LiveScene::replaced() of it

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::function<void()> job_;
  bool busy_ = false;
  Result<void> result_;
  std::exception_ptr failure_;
  std::jthread thread_;  // last: it uses the above
};

// All of them.
class FurtherDevices {
 public:
  // Opens these, one after the other: a driver has been seen to stand still for ever when it made pipelines
  // for four devices at once. indices: as the instance lists them. They have to make of requests what the
  // first device makes.
  static Result<FurtherDevices> open(gpu::Instance& instance, std::span<const uint32_t> indices,
                                     gpu::AsyncCompute async_compute, const CachePlaces& places,
                                     const passes::DrawSettings& settings,
                                     const passes::SceneRenderer& first);
  void forget_scene();
  std::span<const std::unique_ptr<FurtherDevice>> all() const { return devices_; }

 private:
  std::vector<std::unique_ptr<FurtherDevice>> devices_;
};

}  // namespace fire3dv::app
