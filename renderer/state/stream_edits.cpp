#include "renderer/state/stream_edits.h"

namespace fire3dv::state {
namespace {

// Overhead of containers and of the edit itself, here and in the EditRegistry.
constexpr size_t kBytesPerEdit = 512, kBytesPerKey = 96;

size_t key_bytes(const std::string& node) {
  return kBytesPerKey + node.size();
}

size_t bytes_of(const wire::Marker& marker) {
  size_t bytes = marker.parent.size() + marker.positions.size() * sizeof marker.positions[0] +
                 marker.rotations.size() * sizeof marker.rotations[0] +
                 marker.sizes.size() * sizeof marker.sizes[0] +
                 marker.colors.size() * sizeof marker.colors[0] + marker.image.pixels.size();
  for (const std::string& text : marker.texts) bytes += sizeof text + text.size();
  return bytes;
}

size_t value_bytes(const wire::SceneEdit& edit) {
  if (std::holds_alternative<wire::Cleared>(edit.value)) return 0;  // ends an edit, so it is never refused
  size_t bytes = kBytesPerEdit + 2 * edit.node.size();
  if (const auto* node = std::get_if<wire::NodeAdded>(&edit.value))
    bytes += node->parent.size() + node->asset_uri.size() + node->asset_glb.size();
  if (const auto* vertices = std::get_if<wire::Vertices>(&edit.value))
    bytes += (vertices->positions.size() + vertices->normals.size()) * sizeof vertices->positions[0];
  if (const auto* marker = std::get_if<wire::Marker>(&edit.value)) bytes += bytes_of(*marker);
  return bytes;
}

// Added nodes and own vertices need a new merged scene.
bool needs_scene_build(const wire::SceneEdit& edit) {
  return std::holds_alternative<wire::NodeAdded>(edit.value) ||
         std::holds_alternative<wire::Vertices>(edit.value);
}

BudgetCharge empty_charge(const std::shared_ptr<PeerBudget>& budget, Resource resource) {
  return std::move(*BudgetCharge::take(budget, resource, 0));
}

}  // namespace

StreamEdits::StreamEdits(std::shared_ptr<PeerBudget> budget)
    : budget_(std::move(budget)),
      key_count_(empty_charge(budget_, Resource::edits)),
      key_bytes_(empty_charge(budget_, Resource::edit_bytes)) {}

StreamEdits::Outcome StreamEdits::refuse(Resource resource, std::string message) {
  refused_resource_ = resource;
  refusal_ = std::move(message);
  return Outcome::refused;
}

Result<void> StreamEdits::charge_key(const Key& key) {
  if (Result<void> count = key_count_.resize(key_count_.amount() + 1); !count) {
    refused_resource_ = Resource::edits;
    return count;
  }
  Result<void> bytes = key_bytes_.resize(key_bytes_.amount() + key_bytes(key.first));
  if (!bytes) {
    refused_resource_ = Resource::edit_bytes;
    (void)key_count_.resize(key_count_.amount() - 1);
  }
  return bytes;
}

void StreamEdits::drop_key(const Key& key) {
  if (keys_.erase(key) == 0) return;
  (void)key_count_.resize(key_count_.amount() - 1);
  (void)key_bytes_.resize(key_bytes_.amount() - key_bytes(key.first));
}

StreamEdits::Outcome StreamEdits::add(wire::SceneEdit&& edit) {
  if (edit.version <= received_) return Outcome::stale;
  received_ = edit.version;
  Key key(edit.node, edit.property);
  const bool is_new = !keys_.contains(key);
  const auto replaced = pending_.find(key);
  BudgetCharge charge = replaced == pending_.end() ? empty_charge(budget_, Resource::edit_bytes)
                                                   : std::move(replaced->second.charge);
  if (const Result<void> fits = charge.resize(value_bytes(edit)); !fits) {
    if (replaced != pending_.end()) replaced->second.charge = std::move(charge);
    return refuse(Resource::edit_bytes, fits.error().message);
  }
  if (is_new) {
    if (const Result<void> fits = charge_key(key); !fits) {
      if (std::holds_alternative<wire::Cleared>(edit.value))
        return Outcome::accepted;  // there is nothing to clear
      return refuse(refused_resource_, fits.error().message);
    }
    keys_.insert(key);
  }
  // An edit that is replaced before take() never loads.
  if (replaced != pending_.end()) loading_.erase(replaced->second.edit.version);
  if (loads_asynchronously_ && needs_scene_build(edit)) loading_.insert(edit.version);
  pending_.insert_or_assign(std::move(key), Pending{std::move(edit), std::move(charge)});
  return Outcome::accepted;
}

StreamEdits::Outcome StreamEdits::skip(uint64_t version) {
  if (version <= received_) return Outcome::stale;
  received_ = version;
  return Outcome::accepted;
}

StreamEdits::Batch StreamEdits::take() {
  std::vector<Pending> pending;
  pending.reserve(pending_.size());
  for (auto& [key, value] : pending_) {
    if (std::holds_alternative<wire::Cleared>(value.edit.value)) drop_key(key);
    pending.push_back(std::move(value));
  }
  pending_.clear();
  std::sort(pending.begin(), pending.end(),
            [](const Pending& a, const Pending& b) { return a.edit.version < b.edit.version; });
  Batch batch;
  batch.edits.reserve(pending.size());
  batch.charges.reserve(pending.size());
  for (Pending& each : pending) {
    batch.edits.push_back(std::move(each.edit));
    batch.charges.push_back(std::move(each.charge));
  }
  has_applied_ = has_applied_ || !batch.edits.empty();
  return batch;
}

}  // namespace fire3dv::state
