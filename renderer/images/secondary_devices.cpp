#include "renderer/images/secondary_devices.h"

#include "base/process/start_thread.h"

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
  auto following = FollowingRenderer::open(instance, index, async_compute, caches, settings);
  if (!following) return following.error();
  following_ = std::move(*following);
  frames_.emplace(following_->device());
  batch_renderer_.emplace(following_->device(), following_->renderer());
  following_->on_forget([this] { batch_renderer_->clear_histories(); });
  return {};
}

void SecondaryDevice::begin_drawing(const LiveScene& live, const settings::DrawSettings& settings,
                                    const ImageBatchRenderer::Moment& moment,
                                    const ImageBatchRenderer::Limits& limits) {
  begin([this, &live, &settings, &moment, limits] {
    // A scene that does not fit refuses the current image requests; the next requests try again.
    result_ = following_->show(live, settings);
    if (result_) batch_renderer_->draw(*frames_, moment, limits);
    (void)frames_->take_finished();
  });
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
    if (Result<void> alike = check_alike(first, each.renderer()); !alike) return alike.error();
  }
  return all;
}

void SecondaryDevices::forget_scene() {
  for (const std::unique_ptr<SecondaryDevice>& each : devices_) each->forget_scene();
}

}  // namespace fire3dv::app
