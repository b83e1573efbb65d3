// Pixel labels common to both renderers: MuJoCo's object type and object id.
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <vector>

#include "renderer/scene/model/scene.h"
#include "tools/convert/mjcf/mjcf_names.h"

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

}  // namespace fire3dv::mujoco
