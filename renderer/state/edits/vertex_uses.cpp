#include "renderer/state/edits/vertex_uses.h"

namespace fire3dv::state {

void VertexUses::add(uint32_t node, const std::string& name, uint64_t age,
                     std::shared_ptr<PeerBudget> budget) {
  names_.insert(name);
  budgets_[name][{age, node}] = std::move(budget);
  uses_[node].push_back({name, age});
}

void VertexUses::remove(uint32_t node) {
  const auto uses = uses_.find(node);
  if (uses == uses_.end()) return;
  for (const Use& use : uses->second) {
    const auto budgets = budgets_.find(use.name);
    budgets->second.erase({use.age, node});
    if (!budgets->second.empty()) continue;
    budgets_.erase(budgets);
    names_.erase(use.name);
  }
  uses_.erase(uses);
}

void VertexUses::clear() {
  names_.clear();
  uses_.clear();
  budgets_.clear();
}

std::vector<uint32_t> VertexUses::nodes() const {
  std::vector<uint32_t> nodes;
  for (const auto& [node, uses] : uses_) nodes.push_back(node);
  return nodes;
}

// The youngest of several streams that use the name pays.
std::shared_ptr<PeerBudget> VertexUses::budget(const std::string& name) const {
  const auto found = budgets_.find(name);
  return found == budgets_.end() ? nullptr : found->second.rbegin()->second;
}

const PeerBudget* VertexUses::peer(uint32_t node) const {
  const auto uses = uses_.find(node);
  if (uses == uses_.end() || uses->second.empty()) return nullptr;
  const Use& use = uses->second.back();
  const auto budgets = budgets_.find(use.name);
  if (budgets == budgets_.end()) return nullptr;
  const auto budget = budgets->second.find({use.age, node});
  return budget == budgets->second.end() ? nullptr : budget->second.get();
}

void VertexUses::set_built(const std::vector<std::string>& names,
                           std::map<std::string, std::string> reasons) {
  built_ = {names.begin(), names.end()};
  refusals_ = std::move(reasons);
}

const std::string* VertexUses::refusal(const std::string& name) const {
  const auto found = refusals_.find(name);
  return found == refusals_.end() ? nullptr : &found->second;
}

}  // namespace fire3dv::state
