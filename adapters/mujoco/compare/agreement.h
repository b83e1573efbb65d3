// Agreement statistics of labels and depth of two renderers at the same simulation times.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "adapters/mujoco/compare/labels.h"

namespace fire3dv::mujoco {

class Agreement {
 public:
  // endless: labels of infinite planes. MuJoCo draws them up to its far plane; fire3dv-convert exports ten
  // scene extents. Plane pixels that only MuJoCo shows are counted separately and excluded from all shares.
  explicit Agreement(std::vector<uint32_t> endless) : endless_(std::move(endless)) {}

  // Depths beyond far_m count as background.
  void add(const LabelledDepth& ours, const LabelledDepth& theirs, float far_m);

  double beyond_floor_share() const;    // of all pixels
  uint64_t objects() const;             // seen by at least one renderer
  double same_share() const;            // pixels with equal labels
  double same_share_off_edges() const;  // same, over pixels whose 3x3 neighbourhood has one label in MuJoCo's
                                        // image
  // Returns the quantile `share` of the relative depth error over foreground pixels with equal labels.
  double depth_error(double share);

 private:
  std::vector<uint32_t> endless_;
  uint64_t pixels_ = 0, beyond_floor_ = 0, same_ = 0, off_edges_ = 0, same_off_edges_ = 0;
  std::vector<float> errors_;
  std::vector<uint32_t> seen_;
};

}  // namespace fire3dv::mujoco
