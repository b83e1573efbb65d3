#include "renderer/live_scene/peer_charges.h"

#include <algorithm>
#include <mutex>

#include "renderer/live_scene/gpu_bytes.h"
#include "renderer/scene/cache/scene_cache.h"

namespace fire3dv::app {

namespace {

constexpr uint64_t kCopiesOfPath = 4;

Result<void> take(BudgetCharge& charge, const std::shared_ptr<PeerBudget>& budget, Resource resource,
                  uint64_t amount) {
  if (amount == 0) return {};
  Result<BudgetCharge> taken = BudgetCharge::take(budget, resource, amount);
  if (!taken) return taken.error();
  charge = std::move(*taken);
  return {};
}

}  // namespace

AssetSize measure(const scene::LoadedScene& asset) {
  AssetSize size;
  size.host_bytes = scene::array_bytes(asset);
  size.gpu_bytes = estimate_gpu_bytes(asset.scene, asset.derived);
  size.nodes = asset.scene.nodes.size();
  size.deformed_corners = scene::deformed_corners(asset.scene);
  for (const scene::Node& node : asset.scene.nodes) {
    size.path_bytes += node.path.size();
    if (node.light == scene::kNone) continue;
    ++size.lights;
    if (asset.scene.lights[node.light].casts_shadow) ++size.shadow_lights;
  }
  return size;
}

Result<NodeCharges> charge_node(const std::shared_ptr<PeerBudget>& budget, const AssetSize* asset) {
  NodeCharges charges;
  if (!budget) return charges;
  if (auto done = take(charges.nodes, budget, Resource::nodes, 1 + (asset ? asset->nodes : 0)); !done)
    return done.error();
  if (!asset) return charges;
  if (auto done = take(charges.gpu, budget, Resource::gpu_bytes, asset->gpu_bytes); !done)
    return done.error();
  if (auto done = take(charges.lights, budget, Resource::lights, asset->lights); !done) return done.error();
  charges.casts_shadows =
      take(charges.shadow_lights, budget, Resource::shadow_lights, asset->shadow_lights).ok();
  return charges;
}

Result<void> charge_paths(NodeCharges& charges, const std::shared_ptr<PeerBudget>& budget,
                          uint64_t path_bytes) {
  if (!budget) return {};
  const uint64_t bytes = kCopiesOfPath * path_bytes;
  if (charges.paths.amount() > 0) return charges.paths.resize(bytes);
  return take(charges.paths, budget, Resource::asset_bytes, bytes);
}

scene::LoadLimits limits_of_asset(const std::shared_ptr<PeerBudget>& budget, BudgetCharge& charge) {
  scene::LoadLimits limits;
  limits.max_file_bytes = uint64_t{1} << 30;
  limits.max_image_pixels = uint64_t{1} << 26;  // per image
  limits.max_elements = uint64_t{1} << 26;
  if (!budget) return limits;
  // The remaining limits are enforced by the charges: their errors name the limit.
  const uint64_t bytes = budget->limit(Resource::asset_bytes);
  limits.max_elements = std::min(limits.max_elements, bytes / sizeof(uint32_t));
  limits.max_nodes = budget->limit(Resource::nodes);
  limits.max_path_bytes = std::min(limits.max_path_bytes, bytes / kCopiesOfPath);
  limits.reserve = [&charge, mutex = std::make_shared<std::mutex>()](uint64_t more) {
    const std::lock_guard lock(*mutex);
    return charge.resize(charge.amount() + more);
  };
  return limits;
}

BuildTurns::Peer BuildTurns::next(std::span<const Peer> waiting) {
  std::map<Peer, int64_t> tags;
  for (const Peer peer : waiting) {
    const auto known = tags_.find(peer);
    tags[peer] = known == tags_.end() ? now_ : known->second;
  }
  tags_ = std::move(tags);
  const Peer first = *std::min_element(waiting.begin(), waiting.end(),
                                       [&](Peer a, Peer b) { return tags_.at(a) < tags_.at(b); });
  now_ = tags_.at(first);
  return first;
}

namespace {

// Cost of a replaced scene for each peer that changed it and for each of its nodes, in ns of loads.
constexpr int64_t kWeightOfPeer = 1'000'000, kWeightOfNode = 10'000;

int64_t weight_of(const ReplacementShares::Cause& cause) {
  return cause.load_ns + kWeightOfPeer + kWeightOfNode * static_cast<int64_t>(cause.nodes);
}

}  // namespace

int64_t ReplacementShares::earliest_ns(const Peer& peer) const {
  const auto entry = entries_.find(peer.get());
  // An address may have been given to another peer.
  const bool is_known = entry != entries_.end() && entry->second.peer.lock() == peer;
  return is_known ? entry->second.earliest_ns : newcomers_ns_;
}

void ReplacementShares::add(const Replacement& replacement) {
  std::erase_if(entries_, [](const auto& entry) { return entry.first && entry.second.peer.expired(); });
  double weights = 0;
  for (const Cause& cause : replacement.causes) weights += static_cast<double>(weight_of(cause));
  for (const Cause& cause : replacement.causes) {
    const double share = static_cast<double>(weight_of(cause)) / weights;
    const auto part = [share](int64_t ns) { return static_cast<int64_t>(share * static_cast<double>(ns)); };
    int64_t rest_ns = replacement.is_alone ? kRestAlone * part(replacement.shown_ns)
                                           : kRestOfShown * part(replacement.shown_ns) +
                                                 part(replacement.merge_ns) + cause.load_ns;
    Entry& entry = entries_[cause.peer.get()];
    const bool is_calm = replacement.end_ns - entry.earliest_ns > kCalmNs;
    const int64_t streak = is_calm || replacement.is_alone ? 0 : entry.streak + 1;
    const int64_t growth = std::min(1 + streak / kStreak, kMaxGrowth);
    rest_ns = std::max(rest_ns, std::min(growth * rest_ns, kMaxGrownNs));
    entry = {cause.peer, std::max(entry.earliest_ns, replacement.end_ns + rest_ns), streak};
  }
  newcomers_ns_ = std::max(newcomers_ns_, replacement.end_ns + replacement.shown_ns);
}

}  // namespace fire3dv::app
