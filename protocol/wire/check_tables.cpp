// Validation of scene edits and of image messages.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "base/text.h"
#include "protocol/wire/check.h"

namespace fire3dv::wire {
namespace {

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

// Thin lens: none, or both numbers in their ranges. NaN is in none.
template <typename Camera>
Result<void> check_lens(const std::string& message, const Camera& camera) {
  const float n = camera.f_number, focus_m = camera.focus_distance_m;
  if (n == 0 && focus_m == 0) return {};
  const std::string lone = " is 0 beside ", both = "; a lens needs both: set both, or both to 0";
  if (n == 0)
    return Error{message + ".f_number" + lone + "focus_distance_m " + text_of(double{focus_m}) + both};
  if (focus_m == 0)
    return Error{message + ".focus_distance_m" + lone + "f_number " + text_of(double{n}) + both};
  if (!(n >= kMinFNumber && n <= kMaxFNumber))
    return Error{message + ".f_number is " + text_of(double{n}) + "; it must lie in " +
                 text_of(double{kMinFNumber}) + " to " + text_of(double{kMaxFNumber})};
  if (!(focus_m >= kMinFocusDistanceM && focus_m <= kMaxFocusDistanceM))
    return Error{message + ".focus_distance_m is " + text_of(double{focus_m}) + "; it must lie in " +
                 text_of(double{kMinFocusDistanceM}) + " to " + text_of(double{kMaxFocusDistanceM})};
  return {};
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

template <size_t count>
Result<void> check_vectors(const char* field, const std::vector<std::array<float, count>>& vectors,
                           float limit, float low) {
  for (size_t i = 0; i < vectors.size(); ++i) {
    const auto& v = vectors[i];
    bool is_good = true;
    for (size_t axis = 0; axis < count; ++axis) is_good &= v[axis] >= low && v[axis] <= limit;
    if (is_good) continue;
    const Range range{double{low}, double{limit}};
    for (size_t axis = 0; axis < count; ++axis)
      if (auto good =
              check_range(std::string(field) + "[" + std::to_string(i) + "][" + std::to_string(axis) + "]",
                          v[axis], range);
          !good)
        return good;
  }
  return {};
}

template <size_t count>
Result<void> check_vectors(const char* field, const std::vector<std::array<float, count>>& vectors,
                           float limit) {
  return check_vectors(field, vectors, limit, -limit);
}

std::string count_text(size_t count, const char* singular) {
  return std::to_string(count) + " " + singular + (count == 1 ? "" : "s");
}

// Arrays beside the positions have one element for all, or one per position.
Result<void> check_count(const char* field, size_t count, size_t positions, bool may_be_empty) {
  if (count == 1 || count == positions || (count == 0 && may_be_empty)) return {};
  return Error{std::string("SceneEdit.") + field + " has " + count_text(count, "element") + " for " +
               count_text(positions, "position") + "; " + (may_be_empty ? "none, " : "") +
               "one for all, or one per position are allowed"};
}

Result<void> check_positions(const Marker& marker) {
  const size_t count = marker.positions.size();
  const std::string begin = std::string("SceneEdit.positions of ") + marker_kind_name(marker.kind) + " has ";
  const bool is_pairs = marker.kind == MarkerKind::lines || marker.kind == MarkerKind::arrows;
  if (is_pairs && count % 2 != 0)
    return Error{begin + count_text(count, "element") + "; they are pairs of begin and end"};
  if (marker.kind == MarkerKind::line_strip && count == 1)
    return Error{begin + "1 element; a line needs two or more"};
  if (marker.kind == MarkerKind::triangles && count % 3 != 0)
    return Error{begin + count_text(count, "element") + "; they are triples of corners"};
  return {};
}

Result<void> check_rotations(const std::vector<std::array<float, 4>>& rotations) {
  constexpr float kLargest = 1e6f;  // its square is finite
  if (auto good = check_vectors("rotations", rotations, kLargest); !good) return good;
  for (size_t i = 0; i < rotations.size(); ++i) {
    const auto& q = rotations[i];
    constexpr float kLeastSquare = 1e-12f;
    if (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] >= kLeastSquare) continue;
    return Error{"SceneEdit.rotations[" + std::to_string(i) +
                 "] has length 0; the quaternion of no rotation is 0 0 0 1"};
  }
  return {};
}

Result<void> check_texts(const Marker& marker) {
  const size_t count = marker.texts.size(), positions = marker.positions.size();
  if (marker.kind != MarkerKind::texts) {
    if (count == 0) return {};
    return Error{std::string("SceneEdit.texts is given; ") + marker_kind_name(marker.kind) +
                 " have no texts"};
  }
  if (count > kMaxMarkerTexts)
    return Error{"SceneEdit.texts has more than " + std::to_string(kMaxMarkerTexts) + " elements"};
  size_t bytes = 0;
  for (const std::string& text : marker.texts) bytes += text.size();
  if (bytes > kMaxMarkerTextsBytes)
    return Error{"SceneEdit.texts has more than " + std::to_string(kMaxMarkerTextsBytes) +
                 " bytes; use several markers"};
  if (count != positions)
    return Error{"SceneEdit.texts has " + count_text(count, "element") + " for " +
                 count_text(positions, "position") + "; one per position is needed"};
  for (size_t i = 0; i < count; ++i) {
    const std::string& text = marker.texts[i];
    const std::string begin = "SceneEdit.texts[" + std::to_string(i) + "] ";
    if (text.size() > kMaxMarkerTextBytes)
      return Error{begin + "has " + std::to_string(text.size()) + " bytes; at most " +
                   std::to_string(kMaxMarkerTextBytes) + " are allowed"};
    for (size_t at = 0; at < text.size();) {
      const size_t first = at;
      const uint32_t character = next_character(text, at);
      if (character == kInvalidCharacter)
        return Error{begin + "is not valid UTF-8 at byte " + std::to_string(first)};
      if (character != '\n' && is_control(character))
        return Error{begin + "has a control character at byte " + std::to_string(first) +
                     "; line feeds alone are allowed"};
    }
  }
  return {};
}

Result<void> check_image(const Marker& marker) {
  const MarkerImage& image = marker.image;
  if (marker.kind != MarkerKind::images) {
    if (image == MarkerImage{}) return {};
    return Error{std::string("SceneEdit.image is given; ") + marker_kind_name(marker.kind) +
                 " have no image"};
  }
  const std::string size = std::to_string(image.width) + " x " + std::to_string(image.height);
  const auto is_side = [](uint32_t side) { return side >= 1 && side <= kMaxMarkerImageSide; };
  if (!is_side(image.width) || !is_side(image.height))
    return Error{"SceneEdit.image has " + size + " pixels; 1 to " + std::to_string(kMaxMarkerImageSide) +
                 " a side are allowed: scale it down"};
  if (image.channels != 1 && image.channels != 3 && image.channels != 4)
    return Error{"SceneEdit.image_channels is " + std::to_string(image.channels) +
                 "; images have 1 (grey), 3 (red, green, blue) or 4 (and alpha)"};
  const size_t bytes = size_t{image.width} * image.height * image.channels;
  if (image.pixels.size() != bytes)
    return Error{"SceneEdit.image_pixels has " + std::to_string(image.pixels.size()) + " bytes; " + size +
                 " pixels of " + count_text(image.channels, "channel") + " have " + std::to_string(bytes)};
  if (!marker.colors.empty())
    return Error{"SceneEdit.colors is given; images have the colours of their pixels"};
  return {};
}

class CheckValue {
 public:
  explicit CheckValue(const DecodeLimits& limits) : limits_(limits), max_(double{limits.max_abs_value}) {}

  Result<void> operator()(const Cleared&) const { return {}; }
  Result<void> operator()(const Visible&) const { return {}; }
  Result<void> operator()(const NodeRemoved&) const { return {}; }

  Result<void> operator()(const Scalars& value) const { return check(value, limits_); }
  Result<void> operator()(const ScalarValues& value) const { return check(value); }
  Result<void> operator()(const Input& value) const { return check(value); }

  Result<void> operator()(const BaseColor& value) const { return check_each("rgba", value.rgba, {0, 1}); }

  Result<void> operator()(const Light& value) const {
    if (value.kind > LightKind::spot)
      return Error{"SceneEdit.kind is " + std::to_string(static_cast<int>(value.kind)) +
                   "; lights are of kind 0 (directional), 1 (point) or 2 (spot)"};
    if (auto good = check_each("color_rgb", value.color_rgb, {0, max_}); !good) return good;
    if (auto good = check_range("intensity", value.intensity, {0, max_}); !good) return good;
    if (auto good = check_range("range_m", value.range_m, {0, max_}); !good) return good;
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
    if (auto good = check_range("near_m", value.near_m, {0, max_, true}); !good) return good;
    if (auto good = check_range("far_m", value.far_m, {0, max_}); !good) return good;
    if (value.far_m != 0 && !(value.far_m > value.near_m))
      return Error{"SceneEdit.far_m is " + text_of(value.far_m) +
                   "; it must be 0 (infinite) or more than near_m (" + text_of(value.near_m) + ")"};
    if (auto good = check_range("exposure", value.exposure, {0, max_}); !good) return good;
    return check_lens("SceneEdit", value);
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
    if (auto good = check_text("SceneEdit.variant", value.variant, limits_.max_name_bytes); !good)
      return good;
    if (!value.variant.empty() && value.asset_uri.empty() && value.asset_glb.empty())
      return Error{"SceneEdit.variant is given without an asset; variants are those of an asset"};
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

  // Of a kind of a later version: only what holds for all kinds.
  Result<void> operator()(const Marker& value) const {
    const bool is_known = static_cast<size_t>(value.kind) < kMarkerKindCount;
    if (value.width_unit > MarkerUnit::lengths)
      return Error{"SceneEdit.width_unit is " + std::to_string(static_cast<int>(value.width_unit)) +
                   "; widths are in 0 (pixels) or 1 (lengths of the marker's frame)"};
    if (auto good = check_range("width", value.width, {0, max_}); !good) return good;
    if (auto good = check_text("SceneEdit.parent", value.parent, limits_.max_name_bytes); !good) return good;
    if (auto good = check_poses("SceneEdit.parent_from_marker", {&value.parent_from_marker, 1},
                                limits_.max_abs_value);
        !good)
      return good;
    if (auto good = check_vectors("positions", value.positions, limits_.max_abs_value); !good) return good;
    if (auto good = check_rotations(value.rotations); !good) return good;
    if (auto good = check_vectors("sizes", value.sizes, limits_.max_abs_value, 0.0f); !good) return good;
    if (!is_known) return {};
    if (auto good = check_positions(value); !good) return good;
    const size_t count = value.positions.size();
    if (auto good = check_texts(value); !good) return good;
    if (auto good = check_image(value); !good) return good;
    if (auto good = check_count("colors", value.colors.size(), count, true); !good) return good;
    if (!has_sizes(value.kind)) {
      if (value.rotations.empty() && value.sizes.empty()) return {};
      return Error{std::string("SceneEdit.") + (value.rotations.empty() ? "sizes" : "rotations") +
                   " is given; " + marker_kind_name(value.kind) + " have neither rotations nor sizes"};
    }
    if (auto good = check_count("rotations", value.rotations.size(), count, true); !good) return good;
    return check_count("sizes", value.sizes.size(), count, false);
  }

 private:
  const DecodeLimits& limits_;
  double max_;
};

}  // namespace

Result<void> check(const SceneEdit& edit, const DecodeLimits& limits) {
  if (edit.epoch == 0) return Error{"SceneEdit.epoch is 0; an epoch is a random number that is not 0"};
  if (edit.version == 0) return Error{"SceneEdit.version is 0; versions start at 1"};
  if (edit.node.empty()) {
    if (edit.property == Property::marker) return Error{"SceneEdit.node is empty; it is the marker's name"};
    if (is_scalar(edit.property))
      return Error{"SceneEdit.node is empty; it is the name of the group of scalars"};
    if (edit.property == Property::input) return Error{"SceneEdit.node is empty; it is the input's name"};
    return Error{"SceneEdit.node is empty; a node is found by its name"};
  }
  const size_t most = edit.property == Property::input ? kMaxInputNameBytes : limits.max_name_bytes;
  if (auto good = check_text("SceneEdit.node", edit.node, most); !good) return good;
  if (!fits(edit.property, edit.value))
    return Error{std::string("SceneEdit.value is not one that the property ") + property_name(edit.property) +
                 " takes"};
  return std::visit(CheckValue(limits), edit.value);
}

// --- image messages. Values that a later minor version may add (outputs, lenses, times) pass: the
// renderer replies that it does not support them.

namespace {

Error wrong(const char* message, const char* field, double value, const std::string& rule) {
  return Error{std::string(message) + "." + field + " is " + text_of(value) + "; " + rule};
}

Result<void> check_finite(const char* message, const char* field, double value, double most) {
  if (std::fabs(value) <= most) return {};
  return wrong(message, field, value, "finite numbers of magnitude up to " + text_of(most) + " are allowed");
}

Result<void> check_size(const char* message, const Intrinsics& camera) {
  const std::string rule = "images have 1 to " + std::to_string(kMaxRequestedImageSide) + " pixels a side";
  if (camera.width == 0 || camera.width > kMaxRequestedImageSide)
    return wrong(message, "width", camera.width, rule);
  if (camera.height == 0 || camera.height > kMaxRequestedImageSide)
    return wrong(message, "height", camera.height, rule);
  return {};
}

// NaN fails every comparison.
Result<void> check_projection(const char* message, const Intrinsics& camera, double most) {
  const std::string positive = "it must be above 0, and finite";
  if (!(camera.fx > 0 && camera.fx <= most)) return wrong(message, "fx", camera.fx, positive);
  if (!(camera.fy > 0 && camera.fy <= most)) return wrong(message, "fy", camera.fy, positive);
  if (auto good = check_finite(message, "cx", camera.cx, most); !good) return good;
  if (auto good = check_finite(message, "cy", camera.cy, most); !good) return good;
  if (!(camera.near_m > 0 && camera.near_m <= most)) return wrong(message, "near_m", camera.near_m, positive);
  if (!(camera.far_m == 0 || (camera.far_m > camera.near_m && camera.far_m <= most)))
    return wrong(message, "far_m", camera.far_m, "it must be 0 (infinite) or more than near_m");
  for (const float coefficient : camera.lens.coefficients)
    if (auto good = check_finite(message, "lens_coefficients", coefficient, most); !good) return good;
  return {};
}

Result<void> check_plane(const ImageFrame& frame, size_t index) {
  const ImagePlane& plane = frame.planes[index];
  const std::string field = "ImageFrame.planes[" + std::to_string(index) + "]";
  if (plane.output_bit >= kImageOutputCount) return Error{field + ".output is of no known output"};
  if (index > 0 && plane.output_bit <= frame.planes[index - 1].output_bit)
    return Error{field + ".output is " + std::to_string(plane.output_bit) + " after " +
                 std::to_string(frame.planes[index - 1].output_bit) + "; outputs must rise"};
  const ImageOutputInfo& info = info_at(plane.output_bit);
  if (plane.format != info.format)
    return Error{field + ".format is " + std::to_string(static_cast<int>(plane.format)) + "; " +
                 std::string(info.api_name) + " comes in another"};
  const bool fits = info.is_boxes ? plane.height == 1
                                  : plane.width == frame.intrinsics.width &&
                                        plane.height == uint64_t{frame.intrinsics.height} * frame.views;
  if (!fits) return Error{field + " is not of the image's size"};
  const uint64_t row_bytes = uint64_t{plane.width} * info.element_bytes;
  if (frame.views > 1 && plane.row_stride != row_bytes)
    return Error{field + ".row_stride is " + std::to_string(plane.row_stride) +
                 "; images of batches have rows of " + std::to_string(row_bytes) + " bytes"};
  if (plane.row_stride < row_bytes || plane.row_stride % 4 != 0 ||
      plane.bytes != uint64_t{plane.row_stride} * plane.height)
    return Error{field + " has " + std::to_string(plane.bytes) + " bytes in rows of " +
                 std::to_string(plane.row_stride) + ", which is not " + std::to_string(plane.height) +
                 " rows of at least " + std::to_string(row_bytes) + ", a multiple of 4"};
  if (plane.offset % 64 != 0 || plane.offset > frame.pixel_bytes ||
      plane.bytes > frame.pixel_bytes - plane.offset)
    return Error{field + ".offset is " + std::to_string(plane.offset) + ", from where " +
                 std::to_string(plane.bytes) + " bytes do not lie in the image's " +
                 std::to_string(frame.pixel_bytes)};
  return {};
}

Error wrong_count(const char* field, size_t is, const std::string& wanted) {
  return Error{std::string("ImageRequest.batch.") + field + " has " + std::to_string(is) +
               (is == 1 ? " entry" : " entries") + "; " + wanted};
}

Result<void> check_views(const ImageBatch& batch, const DecodeLimits& limits) {
  const size_t views = batch.world_of_view.empty() ? batch.worlds : batch.world_of_view.size();
  if (views > kMaxBatchViews)
    return wrong_count("world_of_view", views, "at most " + std::to_string(kMaxBatchViews) + " are allowed");
  for (size_t view = 0; view < batch.world_of_view.size(); ++view) {
    if (batch.world_of_view[view] < batch.worlds) continue;
    return Error{"ImageRequest.batch.world_of_view[" + std::to_string(view) + "] is " +
                 std::to_string(batch.world_of_view[view]) + "; there are worlds 0 to " +
                 std::to_string(batch.worlds - 1)};
  }
  const std::string one_each = "none, or one for each of " + std::to_string(views) + " views is needed";
  if (!batch.view_poses.empty() && batch.view_poses.size() != views)
    return wrong_count("view_poses", batch.view_poses.size(), one_each);
  if (auto good = check_poses("ImageRequest.batch.view_poses", batch.view_poses, limits.max_abs_value); !good)
    return good;
  if (!batch.view_projections.empty() && batch.view_projections.size() != views)
    return wrong_count("view_projections", batch.view_projections.size(), one_each);
  const auto is_good = [most = limits.max_abs_value](const Projection& p) {
    return p.fx > 0 && p.fx <= most && p.fy > 0 && p.fy <= most && std::fabs(p.cx) <= most &&
           std::fabs(p.cy) <= most;
  };
  const auto bad = std::ranges::find_if_not(batch.view_projections, is_good);
  if (bad != batch.view_projections.end())
    return Error{"ImageRequest.batch.view_projections[" +
                 std::to_string(bad - batch.view_projections.begin()) +
                 "] is invalid; fx and fy must be above 0, and all four finite"};
  return {};
}

Result<void> check_batch(const ImageRequest& request, const DecodeLimits& limits) {
  const bool is_batch = request.when == ImageWhen::batch;
  if (!is_batch && !request.batch) return {};
  if (!is_batch || !request.batch)
    return Error{"ImageRequest.batch is " + std::string(is_batch ? "missing" : "given") +
                 "; it belongs to requests of batches, and only to these"};
  const ImageBatch& batch = *request.batch;
  if (batch.worlds == 0 || batch.worlds > kMaxBatchWorlds)
    return wrong("ImageRequest.batch", "worlds", batch.worlds,
                 "1 to " + std::to_string(kMaxBatchWorlds) + " worlds are allowed");
  const size_t nodes = batch.node_indices.size();
  if (nodes == 0 || nodes > limits.max_nodes)
    return wrong_count("node_indices", nodes, "1 to " + std::to_string(limits.max_nodes) + " are allowed");
  std::vector<uint32_t> sorted = batch.node_indices;
  std::ranges::sort(sorted);
  if (const auto twice = std::ranges::adjacent_find(sorted); twice != sorted.end())
    return Error{"ImageRequest.batch.node_indices has " + std::to_string(*twice) +
                 " twice; each node has one pose in a world"};
  if (batch.poses.size() != nodes && batch.poses.size() != nodes * batch.worlds)
    return wrong_count("poses", batch.poses.size(),
                       std::to_string(nodes) + " (shared by all worlds) or " +
                           std::to_string(nodes * batch.worlds) + " are needed: one for each node and world");
  if (auto good = check_poses("ImageRequest.batch.poses", batch.poses, limits.max_abs_value); !good)
    return good;
  if (!batch.active.empty() && batch.active.size() != batch.worlds)
    return wrong_count("active", batch.active.size(),
                       "none, or one for each of " + std::to_string(batch.worlds) + " worlds is needed");
  if (std::ranges::any_of(batch.active, [](uint8_t flag) { return flag > 1; }))
    return Error{"ImageRequest.batch.active has a number other than 0 and 1"};
  if (request.intrinsics.fx == 0 && !batch.view_projections.empty())
    return Error{"ImageRequest.batch.view_projections is given without fx and fy, which they replace"};
  return check_views(batch, limits);
}

}  // namespace

Result<void> check(const ImageRequest& request, const DecodeLimits& limits) {
  constexpr const char* kName = "ImageRequest";
  if (request.epoch == 0) return Error{"ImageRequest.epoch is 0; an epoch is a random number that is not 0"};
  if (request.id == 0) return Error{"ImageRequest.id is 0; choose another number"};
  if (request.place >= kMaxImageRequests)
    return wrong(kName, "place", request.place,
                 "there are places 0 to " + std::to_string(kMaxImageRequests - 1));
  if (auto good = check_text("ImageRequest.node", request.node, limits.max_name_bytes); !good) return good;
  if (request.when == ImageWhen::never) return {};
  if (auto good = check_poses("ImageRequest.parent_from_camera", {&request.parent_from_camera, 1},
                              limits.max_abs_value);
      !good)
    return good;
  const Intrinsics& camera = request.intrinsics;
  if (auto good = check_size(kName, camera); !good) return good;
  const bool is_own = camera.fx == 0 && camera.fy == 0;
  if (is_own && request.node.empty())
    return Error{
        "ImageRequest.fx is 0, and ImageRequest.node names no camera whose projection could be taken"};
  if (is_own && camera.lens != Lens{})
    return Error{"ImageRequest.lens is given without fx and fy; a lens belongs to a camera's own numbers"};
  if (!is_own)
    if (auto good = check_projection(kName, camera, double{limits.max_abs_value}); !good) return good;
  if (auto good = check_lens(kName, camera); !good) return good;
  if (request.outputs == 0) return Error{"ImageRequest.outputs is empty; request at least one"};
  if (request.markers && ((request.outputs & kColorSrgb8) == 0 || (request.outputs & kColorLinearF16) != 0))
    return Error{
        "ImageRequest.markers is set; it needs the output color_srgb8, which alone shows markers, and not "
        "color_linear_f16"};
  if (request.when == ImageWhen::every_nth && request.every == 0)
    return Error{"ImageRequest.every is 0; it must be 1 or more"};
  constexpr double kMaxRateHz = 1e6;
  if (request.when == ImageWhen::rate && !(request.rate_hz > 0 && request.rate_hz <= kMaxRateHz))
    return wrong(kName, "rate_hz", request.rate_hz, "it must be above 0, and at most 1e+06");
  if (request.when == ImageWhen::exactly && request.sequence == 0)
    return Error{"ImageRequest.sequence is 0; sequences start at 1"};
  return check_batch(request, limits);
}

Result<void> check(const ImageFrame& frame, const DecodeLimits& limits) {
  constexpr const char* kName = "ImageFrame";
  if (frame.epoch == 0) return Error{"ImageFrame.epoch is 0; an epoch is a random number that is not 0"};
  if (frame.request == 0) return Error{"ImageFrame.request is 0; requests have numbers that are not 0"};
  if (frame.number == 0) return Error{"ImageFrame.number is 0; images count from 1"};
  if (frame.views > kMaxBatchViews)
    return wrong(kName, "views", frame.views, "at most " + std::to_string(kMaxBatchViews) + " are allowed");
  if (auto good =
          check_poses("ImageFrame.world_from_camera", {&frame.world_from_camera, 1}, limits.max_abs_value);
      !good)
    return good;
  if (auto good = check_size(kName, frame.intrinsics); !good) return good;
  if (auto good = check_projection(kName, frame.intrinsics, double{limits.max_abs_value}); !good) return good;
  if (auto good = check_lens(kName, frame.intrinsics); !good) return good;
  if (frame.pixel_bytes > kMaxPixelBytes)
    return Error{"ImageFrame.pixel_bytes is " + std::to_string(frame.pixel_bytes) + "; at most " +
                 std::to_string(kMaxPixelBytes) + " are allowed"};
  for (size_t i = 0; i < frame.planes.size(); ++i)
    if (auto good = check_plane(frame, i); !good) return good;
  return {};
}

Result<void> check(const ImageRefused& refused, const DecodeLimits& limits) {
  if (refused.request == 0) return Error{"ImageRefused.request is 0; requests have numbers that are not 0"};
  return check_text("ImageRefused.message", refused.message, limits.max_text_bytes);
}

}  // namespace fire3dv::wire
