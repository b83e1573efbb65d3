// Nodes whose vertices streams replace, the peers that pay for them, and the nodes that have vertices of
// their own in the displayed scene.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/peer_budget.h"

namespace fire3dv::state {

class VertexUses {
 public:
  // The stream of this age replaces the vertices of the node by this name.
  void add(uint32_t node, const std::string& name, uint64_t age, std::shared_ptr<PeerBudget> budget);
  void remove(uint32_t node);
  // The scene was replaced. What set_built() has reported stays.
  void clear();

  // Names of nodes with replaced vertices.
  const std::set<std::string>& names() const { return names_; }
  std::vector<uint32_t> nodes() const;
  // Budget of the peer that replaces the vertices of this node; null: no limits.
  std::shared_ptr<PeerBudget> budget(const std::string& name) const;
  // Identity of the peer that replaces the vertices of this node of the scene; null: nobody, or no budget.
  const PeerBudget* peer(uint32_t node) const;

  // A scene with own vertices for these nodes is shown. reasons: why some of them share theirs, by name.
  void set_built(const std::vector<std::string>& names, std::map<std::string, std::string> reasons);
  bool is_built(const std::string& name) const { return built_.contains(name); }
  // Null: none is known.
  const std::string* refusal(const std::string& name) const;

 private:
  struct Use {
    std::string name;
    uint64_t age = 0;
  };

  std::set<std::string> names_, built_;
  std::map<uint32_t, std::vector<Use>> uses_;  // by node
  std::map<std::string, std::map<std::pair<uint64_t, uint32_t>, std::shared_ptr<PeerBudget>>>
      budgets_;  // by name, age and node
  std::map<std::string, std::string> refusals_;
};

}  // namespace fire3dv::state
