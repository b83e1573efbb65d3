#include "renderer/live_scene/user_additions.h"

#include <chrono>
#include <thread>
#include <variant>

#include "base/log.h"
#include "base/text.h"
#include "renderer/live_scene/live_scene.h"
#include "renderer/scene/model/math.h"

namespace fire3dv::app {

std::vector<std::pair<uint64_t, uint64_t>> UserAdditions::set(const state::Additions& additions) {
  std::vector<std::pair<uint64_t, uint64_t>> ended;
  const uint64_t before = last_version_;
  std::erase_if(entries_, [&](const auto& known) {
    const auto next = additions.find(known.first);
    if (next != additions.end() && next->second == *known.second.addition) return false;
    ended.emplace_back(kAge, known.second.version);
    return true;
  });
  for (const auto& [name, addition] : additions) {
    Entry& entry = entries_[name];
    if (entry.addition) continue;
    entry.version = ++last_version_;
    entry.addition = std::make_shared<const state::Addition>(addition);
    auto added = std::make_shared<wire::NodeAdded>();
    added->parent = addition.parent;
    added->parent_from_node = scene::to_affine(state::parent_from_node(addition.transform));
    if (const auto* asset = std::get_if<state::AddedAsset>(&addition.content)) added->asset_uri = asset->uri;
    entry.added = std::move(added);
  }
  if (ended.empty() && last_version_ == before) return ended;
  ++revision_;
  // Names, parents and memory have changed; more additions leave no more memory.
  for (auto& [name, entry] : entries_) entry.is_refused &= ended.empty() && entry.is_for_memory;
  return ended;
}

std::vector<state::RequestedNode> UserAdditions::requests() const {
  std::vector<state::RequestedNode> requests;
  for (const auto& [name, entry] : entries_) {
    if (!entry.is_refused)
      requests.push_back({kAge, entry.version, name, entry.added, nullptr, entry.addition});
  }
  return requests;
}

bool UserAdditions::is_requested(const state::RequestedNode& node) const {
  const auto entry = entries_.find(node.name);
  return entry != entries_.end() && entry->second.version == node.version && !entry->second.is_refused;
}

bool UserAdditions::may_be_large(const state::RequestedNode& node) {
  return node.addition && (std::holds_alternative<state::AddedAsset>(node.addition->content) ||
                           std::holds_alternative<state::CopiedNode>(node.addition->content));
}

bool UserAdditions::refuse(const state::RequestedNode& node, const std::string& reason, bool is_for_memory) {
  const auto entry = entries_.find(node.name);
  if (entry == entries_.end() || entry->second.version != node.version) return false;
  entry->second.is_for_memory = is_for_memory;
  if (!std::exchange(entry->second.is_refused, true)) ++revision_;
  return std::exchange(entry->second.reason, reason) != reason;
}

std::vector<std::pair<std::string, std::string>> UserAdditions::refused(size_t most) const {
  std::vector<std::pair<std::string, std::string>> refused;
  for (auto entry = entries_.begin(); entry != entries_.end() && refused.size() < most; ++entry) {
    if (entry->second.is_refused) refused.emplace_back(entry->first, entry->second.reason);
  }
  return refused;
}

bool UserAdditions::try_again() {
  bool any = false;
  for (auto& [name, entry] : entries_) any |= std::exchange(entry.is_refused, false);
  if (any) ++revision_;
  return any;
}

// --- use by the displayed scene ---

// Ended additions are hidden at once; the next scene lacks them.
void LiveScene::set_additions(const state::Additions& additions) {
  for (const auto& key : additions_.set(additions)) {
    const auto root = root_of_added_.find(key);
    if (root == root_of_added_.end()) continue;
    withdrawn_.insert(root->second);
    user_changed_ = true;
  }
  pending_.insert(nullptr);
}

void LiveScene::refuse(const state::RequestedNode& node, const std::string& reason, bool is_for_memory) {
  if (!UserAdditions::are_of_user(node)) return registry_.refuse_node(node, reason);
  if (additions_.refuse(node, reason, is_for_memory))
    log_messages_.push_back(
        warning(file_of_additions_ + "the node " + quote(node.name) + " is not added: " + reason));
  pending_.insert(nullptr);  // a shorter list of requests
}

// Returns true if the node of the displayed scene is still requested.
bool LiveScene::confirm(const state::RequestedNode& node) {
  return UserAdditions::are_of_user(node) ? additions_.is_requested(node) : registry_.confirm_node(node);
}

bool LiveScene::await_additions(const std::function<bool()>& should_stop) {
  if (user_.additions.empty()) return true;
  follow();
  while (!settled()) {
    if (should_stop && should_stop()) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    follow();
  }
  return true;
}

}  // namespace fire3dv::app
