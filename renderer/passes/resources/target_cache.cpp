#include "renderer/passes/resources/target_cache.h"

#include <algorithm>
#include <utility>

namespace fire3dv::passes {
namespace {

// Limits of cached targets of other sizes.
constexpr VkDeviceSize kMaxCacheBytes = VkDeviceSize{256} << 20;
constexpr size_t kMaxCachedSizes = 8;

bool has_size(const Targets& targets, VkExtent2D extent, uint32_t views) {
  return targets.extent.width == extent.width && targets.extent.height == extent.height &&
         targets.views == views;
}

}  // namespace

void TargetCache::select(VkExtent2D extent, uint32_t views, const std::function<void(Targets&)>& create,
                         const std::function<void(Targets&)>& use) {
  if (current_ && has_size(*current_, extent, views)) return;
  current_ = nullptr;  // after an allocation failure only some passes have the new targets
  find_or_create(extent, views, create);
  try {
    use(*cache_.front());
  } catch (const gpu::VulkanFailure&) {
    cache_.erase(cache_.begin());
    throw;
  }
  current_ = cache_.front().get();
  drop_old();
}

void TargetCache::find_or_create(VkExtent2D extent, uint32_t views,
                                 const std::function<void(Targets&)>& create) {
  const auto known = std::find_if(cache_.begin(), cache_.end(), [&](const std::unique_ptr<Targets>& targets) {
    return has_size(*targets, extent, views);
  });
  if (known != cache_.end()) {
    std::rotate(cache_.begin(), known, known + 1);
    return;
  }
  auto created = std::make_unique<Targets>(device_, extent, views, samples_);
  create(*created);
  cache_.insert(cache_.begin(), std::move(created));
}

void TargetCache::drop_old() {
  VkDeviceSize bytes = 0;
  for (size_t i = 1; i < cache_.size(); ++i) {
    bytes += bytes_of(*cache_[i]);
    if (i < kMaxCachedSizes && bytes <= kMaxCacheBytes) continue;
    cache_.resize(i);
    return;
  }
}

void TargetCache::invalidate_ids() {
  for (const std::unique_ptr<Targets>& targets : cache_) targets->visibility.invalidate();
}

}  // namespace fire3dv::passes
