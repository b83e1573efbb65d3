// How far two images of the same moment agree.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "adapters/mujoco/compare/labels.h"

namespace fire3dv::mujoco {

class Agreement {
 public:
  // endless: labels of planes without an end. MuJoCo draws them as far as it sees, fire3dv-convert makes them
  // of ten extents of the scene: what MuJoCo alone sees of them is counted apart and left out of all shares.
  explicit Agreement(std::vector<uint32_t> endless) : endless_(std::move(endless)) {}

  // What is farther than far_m counts as background.
  void add(const LabelledDepth& ours, const LabelledDepth& theirs, float far_m);

  double beyond_floor_share() const;    // of all pixels
  uint64_t objects() const;             // that are seen by either
  double same_share() const;            // of pixels whose labels agree
  double same_share_off_edges() const;  // of those around which MuJoCo sees one label alone, 3 x 3
  // Of the relative error of depth, where labels agree and something is seen: what this share of the pixels
  // keeps to.
  double depth_error(double share);

 private:
  std::vector<uint32_t> endless_;
  uint64_t pixels_ = 0, beyond_floor_ = 0, same_ = 0, off_edges_ = 0, same_off_edges_ = 0;
  std::vector<float> errors_;
  std::vector<uint32_t> seen_;
};

}  // namespace fire3dv::mujoco
