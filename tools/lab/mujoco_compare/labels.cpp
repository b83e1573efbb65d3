#include "tools/lab/mujoco_compare/labels.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>

#include "base/error.h"

namespace fire3dv::mujoco {

std::vector<uint32_t> endless_planes(const mjModel& model) {
  std::vector<uint32_t> found;
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const mjtNum* size = model.geom_size + 3 * geom;
    if (model.geom_type[geom] == mjGEOM_PLANE && (size[0] <= 0 || size[1] <= 0))
      found.push_back(label_of(mjOBJ_GEOM, geom));
  }
  return found;
}

InstanceLabels::InstanceLabels(const mjModel& model, const scene::Scene& scene) {
  const convert::MjcfNames names = convert::names_of(model);
  std::unordered_map<std::string, uint32_t> by_name;
  for (size_t i = 0; i < names.geoms.size(); ++i)
    by_name[names.geoms[i]] = label_of(mjOBJ_GEOM, static_cast<int>(i));
  for (size_t i = 0; i < names.tendon_pieces.size(); ++i) {
    for (const auto* pieces : {&names.tendon_pieces[i], &names.tendon_ends[i]})
      for (const std::string& piece : *pieces) by_name[piece] = label_of(mjOBJ_TENDON, static_cast<int>(i));
  }
  labels_.assign(scene.nodes.size() + 1, kNoLabel);
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    const auto found = by_name.find(scene.nodes[i].name);
    if (found != by_name.end()) labels_[i + 1] = found->second;
  }
}

namespace {

// Returns true when the pixel's 3x3 neighbourhood has one label.
bool is_off_edges(const LabelledDepth& image, uint32_t x, uint32_t y) {
  if (x == 0 || y == 0 || x + 1 >= image.width || y + 1 >= image.height) return false;
  const uint32_t label = image.labels[size_t{y} * image.width + x];
  for (uint32_t v = y - 1; v <= y + 1; ++v)
    for (uint32_t u = x - 1; u <= x + 1; ++u)
      if (image.labels[size_t{v} * image.width + u] != label) return false;
  return true;
}

double share_of(uint64_t part, uint64_t whole) {
  return whole ? static_cast<double>(part) / static_cast<double>(whole) : 0;
}

}  // namespace

void Agreement::add(const LabelledDepth& ours, const LabelledDepth& theirs, float far_m) {
  FIRE3DV_ASSERT(ours.width == theirs.width && ours.height == theirs.height);
  for (uint32_t y = 0; y < ours.height; ++y) {
    for (uint32_t x = 0; x < ours.width; ++x) {
      const size_t at = size_t{y} * ours.width + x;
      const uint32_t mine = ours.depths_m[at] < far_m ? ours.labels[at] : kNoLabel;
      const uint32_t other = theirs.labels[at];
      // MuJoCo's own depths of an infinite plane are right near the model only.
      constexpr float kComparedShare = 0.2f;  // of its far plane
      const bool is_far = mine == kNoLabel || ours.depths_m[at] > kComparedShare * far_m;
      if (is_far && std::find(endless_.begin(), endless_.end(), other) != endless_.end()) {
        ++beyond_floor_;
        continue;
      }
      const bool same = mine == other, off_edges = is_off_edges(theirs, x, y);
      ++pixels_;
      same_ += same;
      off_edges_ += off_edges;
      same_off_edges_ += same && off_edges;
      for (const uint32_t label : {mine, other})
        if (label != kNoLabel) seen_.push_back(label);
      if (same && mine != kNoLabel) errors_.push_back(std::abs(ours.depths_m[at] / theirs.depths_m[at] - 1));
    }
  }
  std::sort(seen_.begin(), seen_.end());
  seen_.erase(std::unique(seen_.begin(), seen_.end()), seen_.end());
}

uint64_t Agreement::objects() const {
  return seen_.size();
}

double Agreement::beyond_floor_share() const {
  return share_of(beyond_floor_, beyond_floor_ + pixels_);
}

double Agreement::same_share() const {
  return share_of(same_, pixels_);
}

double Agreement::same_share_off_edges() const {
  return share_of(same_off_edges_, off_edges_);
}

double Agreement::depth_error(double share) {
  if (errors_.empty()) return INFINITY;
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(errors_.size() - 1));
  std::nth_element(errors_.begin(), errors_.begin() + at, errors_.end());
  return static_cast<double>(errors_[static_cast<size_t>(at)]);
}

}  // namespace fire3dv::mujoco
