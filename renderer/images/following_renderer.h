// Renderer of a secondary device: it draws the scene that the first device shows, and loads it by itself.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "base/error.h"
#include "renderer/gpu/device/device.h"
#include "renderer/live_scene/live_scene.h"
#include "renderer/loading/disk_caches.h"
#include "renderer/passes/scene_renderer.h"

namespace fire3dv::app {

// Not thread-safe: one thread at a time uses it.
class FollowingRenderer {
 public:
  // index: as listed by the instance.
  static Result<std::unique_ptr<FollowingRenderer>> open(gpu::Instance& instance, uint32_t index,
                                                         gpu::AsyncCompute async_compute,
                                                         const CacheLocations& caches,
                                                         const settings::DrawSettings& settings);
  // Before the renderer gives up its scene: frees what others hold of it.
  void on_forget(std::function<void()> forget) { on_forget_ = std::move(forget); }

  // Loads the scene of `live`, with its edits, if it shows another, and applies the settings. Error: there is
  // no room for the scene; the next call tries again.
  Result<void> show(const LiveScene& live, settings::DrawSettings settings);
  // Must be called before the displayed scene is destroyed.
  void forget_scene();

  gpu::Device& device() { return *device_; }
  // The same object all the time.
  passes::SceneRenderer& renderer() { return *renderer_; }

 private:
  FollowingRenderer() = default;
  void make_renderer(const settings::DrawSettings& settings);

  std::unique_ptr<gpu::Device> device_;
  std::optional<passes::SceneRenderer> renderer_;
  std::optional<uint64_t> shown_scene_;  // its LiveScene::replaced()
  std::function<void()> on_forget_;
};

// Error for a renderer on another device that draws by other means than the first, so that its images would
// differ.
Result<void> check_alike(const passes::SceneRenderer& first, const passes::SceneRenderer& other);

}  // namespace fire3dv::app
