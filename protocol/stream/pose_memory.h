// Budget charge for pose vectors of one peer. The charge lasts as long as this object, which is a member next
// to the vectors.
#pragma once

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "protocol/base/peer_budget.h"
#include "protocol/wire/affine.h"

namespace fire3dv::stream {

class PoseMemory {
 public:
  PoseMemory() = default;
  explicit PoseMemory(std::shared_ptr<PeerBudget> budget) {
    charge_ = std::move(*BudgetCharge::take(std::move(budget), Resource::pose_bytes, 0));
  }

  // Charges memory before its allocation. Returns false if it exceeds the budget.
  bool take(size_t pose_count) { return charge_.resize(charge_.amount() + bytes(pose_count)).ok(); }
  void give_back(size_t pose_count) { (void)charge_.resize(charge_.amount() - bytes(pose_count)); }

  // Reserves capacity for `count` poses; the contents are lost. Returns false, with the vector unchanged, if
  // it exceeds the budget.
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

}  // namespace fire3dv::stream
