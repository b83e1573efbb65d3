#include "renderer/images/following_renderer.h"

#include <algorithm>
#include <utility>

#include "renderer/images/image_batch_renderer.h"
#include "renderer/passes/texture_capacity.h"

namespace fire3dv::app {

Result<std::unique_ptr<FollowingRenderer>> FollowingRenderer::open(gpu::Instance& instance, uint32_t index,
                                                                   gpu::AsyncCompute async_compute,
                                                                   const CacheLocations& caches,
                                                                   const settings::DrawSettings& settings) {
  Result<std::unique_ptr<gpu::Device>> device =
      gpu::Device::create(instance, index, /*present=*/false, async_compute);
  if (!device) return device.error();
  std::unique_ptr<FollowingRenderer> following(new FollowingRenderer);
  following->device_ = std::move(*device);
  // The first device stores the compiled pipelines if it is of the same kind.
  const PipelineCacheFile pipelines(*following->device_, caches.pipelines);
  following->renderer_.emplace(*following->device_, settings);
  return following;
}

Result<void> FollowingRenderer::show(const LiveScene& live, settings::DrawSettings settings) {
  // Keeps a larger texture limit.
  settings.max_textures = std::max(settings.max_textures, renderer_->settings().draw().max_textures);
  const bool other_renderer = renderer_->needs_new_renderer(settings);
  if (shown_scene_ == live.replaced() && !other_renderer) {
    renderer_->apply(settings);
    return {};
  }
  forget_scene();
  try {
    if (other_renderer) make_renderer(settings);
    if (Result<void> room = passes::ensure_texture_capacity(*device_, settings, live.scene(), renderer_);
        !room)
      return room;
    renderer_->apply(settings);
    renderer_->set_edits(live.edits());
    renderer_->set_scene(live.scene(), live.loaded().derived);
    shown_scene_ = live.replaced();
    return {};
  } catch (const gpu::VulkanFailure& failure) {
    if (!gpu::is_out_of_memory(failure)) throw;
  }
  make_renderer(settings);
  return Error{device_->report().name + " has no memory for the scene"};
}

void FollowingRenderer::make_renderer(const settings::DrawSettings& settings) {
  device_->wait(device_->last_submitted());
  renderer_.reset();
  device_->retire_all_now();
  renderer_.emplace(*device_, settings);
}

void FollowingRenderer::forget_scene() {
  shown_scene_.reset();
  if (on_forget_) on_forget_();
}

Result<void> check_alike(const passes::SceneRenderer& first, const passes::SceneRenderer& other) {
  const bool is_alike = other.settings().raster_path() == first.settings().raster_path() &&
                        other.settings().samples() == first.settings().samples() &&
                        other.settings().shadow_technique() == first.settings().shadow_technique() &&
                        other.ray_effect_back_end() == first.ray_effect_back_end() &&
                        static_cast<bool>(other.can_blur()) == static_cast<bool>(first.can_blur()) &&
                        image_abilities(other).outputs == image_abilities(first).outputs;
  if (is_alike) return {};
  return Error{"--devices: " + other.device().report().name +
               " draws by other means than the first device, so that its images would differ: name devices "
               "of one kind, or set --raster, --samples and --shadows to what all of them have"};
}

}  // namespace fire3dv::app
