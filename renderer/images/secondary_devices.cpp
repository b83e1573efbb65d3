#include "renderer/images/secondary_devices.h"

#include <algorithm>

#include "base/process/start_thread.h"
#include "renderer/passes/texture_capacity.h"

namespace fire3dv::app {

SecondaryDevice::SecondaryDevice(gpu::Instance& instance, uint32_t index, gpu::AsyncCompute async_compute,
                                 const CacheLocations& caches, const settings::DrawSettings& settings)
    : thread_(start_thread<std::jthread>("secondary device's",
                                         [this](const std::stop_token& stop) { work(stop); })) {
  begin([this, &instance, index, async_compute, &caches, settings] {
    result_ = open(instance, index, async_compute, caches, settings);
  });
}

// Completes the job in progress.
SecondaryDevice::~SecondaryDevice() {
  thread_.request_stop();
  changed_.notify_all();
  thread_.join();
}

void SecondaryDevice::work(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, stop, [&] { return job_ != nullptr; });
    if (!job_) return;
    const std::function<void()> job = std::exchange(job_, nullptr);
    lock.unlock();
    try {
      job();
    } catch (...) {
      failure_ = std::current_exception();
    }
    lock.lock();
    busy_ = false;
    changed_.notify_all();
  }
}

void SecondaryDevice::begin(std::function<void()> job) {
  const std::scoped_lock lock(mutex_);
  FIRE3DV_ASSERT(!busy_);
  job_ = std::move(job);
  busy_ = true;
  changed_.notify_all();
}

Result<void> SecondaryDevice::finish() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return !busy_; });
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  return std::exchange(result_, Result<void>());
}

Result<void> SecondaryDevice::open(gpu::Instance& instance, uint32_t index, gpu::AsyncCompute async_compute,
                                   const CacheLocations& caches, const settings::DrawSettings& settings) {
  Result<std::unique_ptr<gpu::Device>> device =
      gpu::Device::create(instance, index, /*present=*/false, async_compute);
  if (!device) return device.error();
  device_ = std::move(*device);
  // The first device stores the compiled pipelines if it is of the same kind.
  const PipelineCacheFile pipelines(*device_, caches.pipelines);
  renderer_.emplace(*device_, settings);
  frames_.emplace(*device_);
  batch_renderer_.emplace(*device_, *renderer_);
  return {};
}

void SecondaryDevice::begin_drawing(const LiveScene& live, const settings::DrawSettings& settings,
                                    const ImageBatchRenderer::Moment& moment,
                                    const ImageBatchRenderer::Limits& limits) {
  begin([this, &live, &settings, &moment, limits] {
    result_ = show(live, settings);
    if (result_) batch_renderer_->draw(*frames_, moment, limits);
    (void)frames_->take_finished();
  });
}

// A scene that does not fit refuses the current image requests; the next requests retry.
Result<void> SecondaryDevice::show(const LiveScene& live, settings::DrawSettings settings) {
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

void SecondaryDevice::make_renderer(const settings::DrawSettings& settings) {
  device_->wait(device_->last_submitted());
  renderer_.reset();
  device_->retire_all_now();
  renderer_.emplace(*device_, settings);
}

void SecondaryDevice::forget_scene() {
  shown_scene_.reset();
  batch_renderer_->clear_histories();
}

Result<SecondaryDevices> SecondaryDevices::open(gpu::Instance& instance, std::span<const uint32_t> indices,
                                                gpu::AsyncCompute async_compute, const CacheLocations& caches,
                                                const settings::DrawSettings& settings,
                                                const passes::SceneRenderer& first) {
  SecondaryDevices all;
  for (const uint32_t index : indices) {
    SecondaryDevice& each = *all.devices_.emplace_back(
        std::make_unique<SecondaryDevice>(instance, index, async_compute, caches, settings));
    if (Result<void> opened = each.finish(); !opened) return opened.error();
    const passes::SceneRenderer& renderer = each.renderer();
    const bool alike = renderer.settings().raster_path() == first.settings().raster_path() &&
                       renderer.settings().samples() == first.settings().samples() &&
                       renderer.settings().shadow_technique() == first.settings().shadow_technique() &&
                       renderer.ray_effect_back_end() == first.ray_effect_back_end() &&
                       static_cast<bool>(renderer.can_blur()) == static_cast<bool>(first.can_blur()) &&
                       image_abilities(renderer).outputs == image_abilities(first).outputs;
    if (!alike)
      return Error{
          "--devices: " + each.device().report().name +
          " draws by other means than the first device, so that its images would differ: name devices "
          "of one kind, or set --raster, --samples and --shadows to what all of them have"};
  }
  return all;
}

void SecondaryDevices::forget_scene() {
  for (const std::unique_ptr<SecondaryDevice>& each : devices_) each->forget_scene();
}

}  // namespace fire3dv::app
