// Pixel labels common to both renderers (MuJoCo's object type and object id), and the agreement of two
// labelled images.
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "adapters/mujoco/compiled/compiled_scene.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::mujoco {

constexpr uint32_t kNoLabel = 0;  // background
constexpr uint32_t label_of(int object_type, int object) {
  return static_cast<uint32_t>(object_type) << 24 | (static_cast<uint32_t>(object) + 1);
}

// Returns the labels of infinite planes.
std::vector<uint32_t> endless_planes(const mjModel& model);

// Label and depth image, rows from the top.
struct LabelledDepth {
  uint32_t width = 0, height = 0;
  std::vector<uint32_t> labels;
  std::vector<float> depths_m;  // planar depth along the camera axis; infinite for background
};

// Map from scene instances, as the renderer numbers them, to labels. The scene must be that of scene_of().
class InstanceLabels {
 public:
  InstanceLabels(const mjModel& model, const scene::Scene& scene);
  uint32_t operator[](uint32_t instance) const {
    return instance < labels_.size() ? labels_[instance] : kNoLabel;
  }

 private:
  std::vector<uint32_t> labels_;
};

// Agreement statistics of labels and depth of two renderers at the same simulation times.
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
