#include "adapters/mujoco/compare/agreement.h"

#include <algorithm>
#include <cmath>

#include "protocol/base/error.h"

namespace fire3dv::mujoco {
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
      if (mine == kNoLabel && std::find(endless_.begin(), endless_.end(), other) != endless_.end()) {
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
