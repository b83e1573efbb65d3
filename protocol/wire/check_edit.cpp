// Validation of scene edits.
#include <cmath>
#include <cstdio>
#include <numbers>

#include "protocol/wire/check.h"

namespace fire3dv::wire {
namespace {

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

struct Range {
  double low, high;
  bool open = false;  // excludes the bounds
};

// NaN is outside every range.
Result<void> check_range(const std::string& field, double value, Range range) {
  const bool good =
      range.open ? value > range.low && value < range.high : value >= range.low && value <= range.high;
  if (good) return {};
  return Error{"SceneEdit." + field + " is " + text_of(value) + "; it must lie " +
               (range.open ? "between " : "in ") + text_of(range.low) + (range.open ? " and " : " to ") +
               text_of(range.high)};
}

template <size_t count>
Result<void> check_each(const char* field, const std::array<float, count>& values, Range range) {
  for (size_t i = 0; i < count; ++i)
    if (auto good = check_range(std::string(field) + "[" + std::to_string(i) + "]", values[i], range); !good)
      return good;
  return {};
}

Result<void> check_vectors(const char* field, const std::vector<std::array<float, 3>>& vectors, float limit) {
  for (size_t i = 0; i < vectors.size(); ++i) {
    const auto& v = vectors[i];
    if (std::fabs(v[0]) <= limit && std::fabs(v[1]) <= limit && std::fabs(v[2]) <= limit) continue;
    const Range range{-double{limit}, double{limit}};
    for (size_t axis = 0; axis < 3; ++axis)
      if (auto good =
              check_range(std::string(field) + "[" + std::to_string(i) + "][" + std::to_string(axis) + "]",
                          v[axis], range);
          !good)
        return good;
  }
  return {};
}

class CheckValue {
 public:
  explicit CheckValue(const DecodeLimits& limits) : limits_(limits), most_(double{limits.max_abs_value}) {}

  Result<void> operator()(const Cleared&) const { return {}; }
  Result<void> operator()(const Visible&) const { return {}; }
  Result<void> operator()(const NodeRemoved&) const { return {}; }

  Result<void> operator()(const BaseColor& value) const { return check_each("rgba", value.rgba, {0, 1}); }

  Result<void> operator()(const Light& value) const {
    if (value.kind > LightKind::spot)
      return Error{"SceneEdit.kind is " + std::to_string(static_cast<int>(value.kind)) +
                   "; lights are of kind 0 (directional), 1 (point) or 2 (spot)"};
    if (auto good = check_each("color_rgb", value.color_rgb, {0, most_}); !good) return good;
    if (auto good = check_range("intensity", value.intensity, {0, most_}); !good) return good;
    if (auto good = check_range("range_m", value.range_m, {0, most_}); !good) return good;
    // Pi / 2 rounded to float may be slightly larger.
    constexpr double kQuarter = std::numbers::pi / 2 + 1e-6;
    if (auto good = check_range("outer_cone_rad", value.outer_cone_rad, {0, kQuarter}); !good) return good;
    if (auto good = check_range("inner_cone_rad", value.inner_cone_rad, {0, kQuarter}); !good) return good;
    if (value.kind == LightKind::spot && !(value.inner_cone_rad < value.outer_cone_rad))
      return Error{"SceneEdit.inner_cone_rad is " + text_of(value.inner_cone_rad) +
                   "; of a spot light it must be less than outer_cone_rad (" + text_of(value.outer_cone_rad) +
                   ")"};
    return {};
  }

  Result<void> operator()(const Camera& value) const {
    if (auto good = check_range("vertical_fov_rad", value.vertical_fov_rad, {0, std::numbers::pi, true});
        !good)
      return good;
    if (auto good = check_range("near_m", value.near_m, {0, most_, true}); !good) return good;
    if (auto good = check_range("far_m", value.far_m, {0, most_}); !good) return good;
    if (value.far_m != 0 && !(value.far_m > value.near_m))
      return Error{"SceneEdit.far_m is " + text_of(value.far_m) +
                   "; it must be 0 (infinite) or more than near_m (" + text_of(value.near_m) + ")"};
    return check_range("exposure", value.exposure, {0, most_});
  }

  Result<void> operator()(const NodeAdded& value) const {
    if (auto good = check_text("SceneEdit.parent", value.parent, limits_.max_name_bytes); !good) return good;
    if (auto good =
            check_poses("SceneEdit.parent_from_node", {&value.parent_from_node, 1}, limits_.max_abs_value);
        !good)
      return good;
    if (auto good = check_text("SceneEdit.asset_uri", value.asset_uri, limits_.max_text_bytes); !good)
      return good;
    if (!value.asset_uri.empty() && !value.asset_glb.empty())
      return Error{"SceneEdit.asset_uri and SceneEdit.asset_glb are both given; name an asset or embed one"};
    return {};
  }

  Result<void> operator()(const Vertices& value) const {
    if (value.positions.empty()) return Error{"SceneEdit.positions is empty; clear the property instead"};
    if (!value.normals.empty() && value.normals.size() != value.positions.size())
      return Error{"SceneEdit.normals has " + std::to_string(value.normals.size()) + " vectors for " +
                   std::to_string(value.positions.size()) + " positions; none or as many are allowed"};
    if (auto good = check_vectors("positions", value.positions, limits_.max_abs_value); !good) return good;
    return check_vectors("normals", value.normals, limits_.max_abs_value);
  }

 private:
  const DecodeLimits& limits_;
  double most_;
};

}  // namespace

Result<void> check(const SceneEdit& edit, const DecodeLimits& limits) {
  if (edit.epoch == 0) return Error{"SceneEdit.epoch is 0; an epoch is a random number that is not 0"};
  if (edit.version == 0) return Error{"SceneEdit.version is 0; versions start at 1"};
  if (edit.node.empty()) return Error{"SceneEdit.node is empty; a node is found by its name"};
  if (auto good = check_text("SceneEdit.node", edit.node, limits.max_name_bytes); !good) return good;
  if (!fits(edit.property, edit.value))
    return Error{std::string("SceneEdit.value is not one that the property ") + property_name(edit.property) +
                 " takes"};
  return std::visit(CheckValue(limits), edit.value);
}

}  // namespace fire3dv::wire
