// Materials of one scene in the next one, whose materials may have other numbers: added files come and go in
// the order of their names. A material is found at the first of its primitives that both scenes have, else by
// its name.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "renderer/state/editing/target_index.h"

namespace fire3dv::state {

class MaterialTransfer {
 public:
  // The targets outlive this object.
  MaterialTransfer(const EditTargets& before, const EditTargets& after);

  // Number in the next scene of a material of the one before; scene::kNone: it has none. Several materials of
  // one name are told apart by their users; unnamed ones need a user.
  uint32_t find(uint32_t material);

 private:
  // Primitive that has a material.
  struct User {
    uint32_t material, node;
    uint32_t slot;  // primitive of the node's mesh
  };
  struct Side {
    explicit Side(const EditTargets& of) : targets(of), index(of) {}
    const EditTargets& targets;
    TargetIndex index;
    std::optional<std::vector<User>> users;  // by material, then in the order of the nodes
  };
  static std::span<const User> users_of(Side& side, uint32_t material);
  static uint32_t same_node(uint32_t node, Side& from, Side& to);
  static uint32_t material_at_users_of(uint32_t material, Side& from, Side& to);
  bool has_same_materials() const;

  Side before_, after_;
  std::optional<bool> is_same_;  // only the material variant differs
};

}  // namespace fire3dv::state
