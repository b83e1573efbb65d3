// Memory of pose vectors, charged to the budget of the peer whose poses they hold. The charge lasts as long
// as this object, which stands beside the vectors.
#pragma once

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "protocol/base/peer_budget.h"
#include "protocol/wire/affine.h"

namespace fire3dv::state {

class PoseMemory {
 public:
  PoseMemory() = default;
  explicit PoseMemory(std::shared_ptr<PeerBudget> budget) {
    charge_ = std::move(*BudgetCharge::take(std::move(budget), Resource::pose_bytes, 0));
  }

  // Charges memory that is allocated next. False: the budget has no room for it.
  bool take(size_t pose_count) { return charge_.resize(charge_.amount() + bytes(pose_count)).ok(); }
  void give_back(size_t pose_count) { (void)charge_.resize(charge_.amount() - bytes(pose_count)); }

  // Makes room for so many poses, of which none is kept. False: the budget has no room for it, and the vector
  // is as it was.
  bool reserve(std::vector<wire::Affine3x4>& poses, size_t count) {
    if (poses.capacity() >= count) return true;
    if (!take(count - poses.capacity())) return false;
    poses.clear();
    poses.reserve(count);
    return true;
  }

  size_t amount() const { return charge_.amount(); }

 private:
  static size_t bytes(size_t pose_count) { return pose_count * sizeof(wire::Affine3x4); }

  BudgetCharge charge_;
};

}  // namespace fire3dv::state
