#include "adapters/gazebo/stream/assets.h"

#include <chrono>
#include <exception>
#include <new>
#include <utility>

#include "adapters/gazebo/scene/scene_model.h"
#include "convert/glb/write_glb.h"

namespace fire3dv::gazebo {

ConvertedAsset convert_items(const std::vector<TopLevel>& items,
                             const std::vector<std::filesystem::path>& resource_folders,
                             const std::string& name, bool has_default_light) {
  ConvertedAsset asset;
  asset.node = items.empty() ? "" : items.front().added_node;
  try {
    convert::Model model = scene_model(items, resource_folders, name);
    if (has_default_light) convert::add_light_if_none(model);
    asset.glb = convert::write_glb(model, &model.warnings);
    asset.warnings = std::move(model.warnings);
  } catch (const std::bad_alloc&) {
    asset.glb = Error{"the scene does not fit into memory"};
  } catch (const std::exception& fault) {
    asset.glb = Error{std::string("the scene cannot be converted: ") + fault.what()};
  }
  return asset;
}

AssetQueue::~AssetQueue() {
  waiting_.clear();
  if (running_.valid()) running_.wait();
}

void AssetQueue::start() {
  if (running_.valid() || waiting_.empty()) return;
  running_ = std::async(std::launch::async, [this, items = std::move(waiting_.front())] {
    return convert_items(items, resource_folders_, kAssetRoot, false);
  });
  waiting_.pop_front();
}

void AssetQueue::push(std::vector<TopLevel> items) {
  if (!items.empty()) waiting_.push_back(std::move(items));
  start();
}

std::optional<ConvertedAsset> AssetQueue::take() {
  if (!running_.valid() || running_.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
    return std::nullopt;
  ConvertedAsset asset = running_.get();
  start();
  return asset;
}

}  // namespace fire3dv::gazebo
