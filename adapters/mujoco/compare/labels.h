// What a pixel shows, in one numbering for both renderers: MuJoCo's kind of object and its number.
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <vector>

#include "renderer/scene/scene.h"
#include "tools/convert/mjcf_names.h"

namespace fire3dv::mujoco {

constexpr uint32_t kNoLabel = 0;  // background
constexpr uint32_t label_of(int object_type, int object) {
  return static_cast<uint32_t>(object_type) << 24 | (static_cast<uint32_t>(object) + 1);
}

// Of planes that have no end.
std::vector<uint32_t> endless_planes(const mjModel& model);

// One image, rows from the top.
struct LabelledDepth {
  uint32_t width = 0, height = 0;
  std::vector<uint32_t> labels;
  std::vector<float> depths_m;  // along the camera's axis; infinite for the background
};

// Labels of instances of the scene that scene_of() makes of the model, as a renderer numbers them.
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
