#include "renderer/dataset/labels/labels.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "base/text.h"

namespace fire3dv::dataset {
namespace {

using nlohmann::ordered_json;

Rectangle box_of(const Runs& runs, uint32_t height) {
  int64_t left = INT64_MAX, top = INT64_MAX, right = -1, bottom = -1;
  for (const auto& [first, end] : runs) {
    const int64_t x0 = first / height, x1 = (end - 1) / height;
    left = std::min(left, x0);
    right = std::max(right, x1);
    // A run over the end of a column covers all rows.
    top = std::min(top, x0 == x1 ? int64_t{first % height} : 0);
    bottom = std::max(bottom, x0 == x1 ? int64_t{(end - 1) % height} : int64_t{height} - 1);
  }
  if (right < 0) return {-1, -1, -1, -1};
  return {left, top, right - left + 1, bottom - top + 1};
}

Runs runs_of_mask(const sinks::FrameImage& image, size_t index) {
  const wire::AmodalRecord& record = image.amodal->records[index];
  const size_t row_bytes = (image.width + 7) / 8;
  const uint8_t* const mask = image.amodal->masks.data() + index * row_bytes * image.height;
  Runs runs;
  for (uint32_t x = record.min_x; x < record.max_x; ++x) {
    for (uint32_t y = record.min_y; y < record.max_y; ++y) {
      if (!(mask[y * row_bytes + x / 8] & (0x80u >> (x % 8)))) continue;
      const uint32_t pixel = x * image.height + y;
      if (!runs.empty() && runs.back().second == pixel)
        ++runs.back().second;
      else
        runs.emplace_back(pixel, pixel + 1);
    }
  }
  return runs;
}

// has_depth: of a pixel, rows from the top.
template <typename HasDepth>
Silhouette read_silhouette(const sinks::FrameImage& image, size_t index, HasDepth&& has_depth) {
  const wire::AmodalRecord& record = image.amodal->records[index];
  Silhouette silhouette;
  silhouette.pixels = runs_of_mask(image, index);
  silhouette.box = box_of(silhouette.pixels, image.height);
  silhouette.px = record.pixels;
  for (const auto& [first, end] : silhouette.pixels) {
    for (uint32_t i = first; i < end; ++i)
      silhouette.valid_px += has_depth(size_t{i % image.height} * image.width + i / image.height);
  }
  silhouette.visibility = static_cast<double>(record.visible_pixels) / static_cast<double>(record.pixels);
  silhouette.is_truncated = record.is_truncated != 0;
  return silhouette;
}

void set_pose(const glm::dmat4& camera_from_world, const glm::dmat4& world_from_node,
              const Instance& instance, InstanceLabel& label) {
  const glm::dmat4 camera_from_node = camera_from_world * world_from_node;
  for (int column = 0; column < 3; ++column) {
    const glm::dvec3 axis(camera_from_node[column]);
    const double size = glm::length(axis), wanted = instance.scale[column];
    constexpr double kMaxError = 1e-3;
    if (!(std::abs(size - std::abs(wanted)) <= kMaxError * std::abs(wanted))) label.is_rescaled = true;
    const glm::dvec3 unit = size > 0 ? axis / size : glm::dvec3(0);
    for (int row = 0; row < 3; ++row)
      label.camera_from_model[static_cast<size_t>(3 * row + column)] = wanted < 0 ? -unit[row] : unit[row];
  }
  for (int row = 0; row < 3; ++row)
    label.camera_from_model_mm[static_cast<size_t>(row)] = camera_from_node[3][row] * kMillimetres;
}

KeypointLabel find_keypoint(uint32_t index, const Keypoint& point, const glm::dmat4& camera_from_world,
                            const glm::dmat4& world_from_node, const passes::Intrinsics& k,
                            const std::vector<float>& depth_m) {
  const glm::dvec3 at(
      camera_from_world * world_from_node *
      glm::dvec4(point.node_from_point_m[0], point.node_from_point_m[1], point.node_from_point_m[2], 1));
  KeypointLabel label{index, 0, 0, at.z, KeypointState::outside};
  if (!(at.z > 0)) return label;
  label.x_px = double{k.fx_px} * at.x / at.z + double{k.cx_px};
  label.y_px = double{k.fy_px} * at.y / at.z + double{k.cy_px};
  const double x = std::round(label.x_px), y = std::round(label.y_px);
  if (!(x >= 0 && y >= 0 && x < k.image_px.x && y < k.image_px.y)) return label;
  // A surface farther than a hundredth of the distance in front of the point hides it: points on curved
  // surfaces are a little behind the surface at the pixel's centre.
  constexpr double kTolerance = 0.01;
  const double surface_m = depth_m[static_cast<size_t>(y) * k.image_px.x + static_cast<size_t>(x)];
  label.state = at.z * (1 - kTolerance) <= surface_m ? KeypointState::visible : KeypointState::hidden;
  return label;
}

void quantise_depth(const std::vector<float>& depth_m, double unit_mm, ImageLabels& labels) {
  labels.depth_units.resize(depth_m.size());
  labels.beyond_range_px = 0;
  const double units_per_m = kMillimetres / unit_mm;
  for (size_t i = 0; i < depth_m.size(); ++i) {
    const double units = std::round(double{depth_m[i]} * units_per_m);
    const bool fits = units >= 0 && units <= UINT16_MAX;
    labels.depth_units[i] = fits ? static_cast<uint16_t>(units) : uint16_t{0};
    if (!fits && std::isfinite(depth_m[i])) ++*labels.beyond_range_px;
  }
}

double mean_of(const std::vector<uint8_t>& rgba8) {
  uint64_t sum = 0;
  for (size_t i = 0; i + 3 < rgba8.size(); i += 4)
    sum += uint64_t{rgba8[i]} + uint64_t{rgba8[i + 1]} + uint64_t{rgba8[i + 2]};
  return rgba8.empty() ? 0 : static_cast<double>(sum) / (3.0 * static_cast<double>(rgba8.size() / 4));
}

ordered_json json_of(const Rectangle& box) {
  return {box.left, box.top, box.width, box.height};
}

}  // namespace

glm::dmat4 opencv_pose(const glm::mat4& world_from_camera) {
  glm::dmat4 pose(world_from_camera);
  for (int axis = 0; axis < 3; ++axis) {
    const glm::dvec3 direction = glm::normalize(glm::dvec3(pose[axis]));
    pose[axis] = glm::dvec4(axis == 0 ? direction : -direction, 0);
  }
  return pose;
}

Result<double> find_baseline(const passes::Intrinsics& first, const glm::dmat4& world_from_first,
                             const passes::Intrinsics& second, const glm::dmat4& world_from_second) {
  // Poses are single precision.
  constexpr double kMaxAngleRad = 1e-5, kMaxAside = 1e-4, kPosePrecision = 1e-6;
  if (first.fx_px != second.fx_px || first.fy_px != second.fy_px || first.cx_px != second.cx_px ||
      first.cy_px != second.cy_px)
    return Error{"their intrinsics differ"};
  const glm::dmat4 first_from_second = glm::inverse(world_from_first) * world_from_second;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec4 wanted(0);
    wanted[axis] = 1;
    if (!(glm::distance(first_from_second[axis], wanted) <= kMaxAngleRad)) return Error{"they are turned"};
  }
  const glm::dvec3 offset(first_from_second[3]);
  const double aside_m =
      std::max(kMaxAside * std::abs(offset.x), kPosePrecision * glm::length(glm::dvec3(world_from_first[3])));
  if (!(std::max(std::abs(offset.y), std::abs(offset.z)) <= aside_m))
    return Error{"they are not side by side"};
  if (!(std::abs(offset.x) > aside_m)) return Error{"they are in one place"};
  if (offset.x < 0) return Error{"the first one is on the right: name the left one first"};
  return offset.x;
}

const sinks::FramePlane* find_plane(const sinks::FrameImage& image, wire::ImageOutput output) {
  for (const sinks::FramePlane& plane : image.planes) {
    if (plane.output == output) return &plane;
  }
  return nullptr;
}

template <typename T>
std::vector<T> plane_values(const sinks::FrameImage& image, wire::ImageOutput output) {
  static_assert(sizeof(T) == 4);
  const sinks::FramePlane* const plane = find_plane(image, output);
  FIRE3DV_ASSERT(plane && plane->bytes.size() == size_t{4} * image.width * image.height);
  std::vector<T> values(plane->bytes.size() / sizeof(T));
  std::memcpy(values.data(), plane->bytes.data(), plane->bytes.size());
  return values;
}
template std::vector<float> plane_values(const sinks::FrameImage&, wire::ImageOutput);
template std::vector<uint32_t> plane_values(const sinks::FrameImage&, wire::ImageOutput);

ImageLabels find_labels(const sinks::FrameImage& image, ImagePoses poses, const Description& description,
                        const std::optional<double>& depth_unit_mm) {
  ImageLabels labels;
  labels.poses = std::move(poses);
  const auto depth_m = plane_values<float>(image, wire::kDepthF32);
  if (depth_unit_mm) quantise_depth(depth_m, *depth_unit_mm, labels);
  const auto has_depth = [&](size_t pixel) {
    return depth_unit_mm ? labels.depth_units[pixel] != 0 : std::isfinite(depth_m[pixel]);
  };
  labels.brightness = mean_of(image.rgba8);
  const glm::dmat4 camera_from_world = glm::inverse(labels.poses.world_from_camera);
  std::map<uint32_t, Runs> masks =
      masks_of_instances(plane_values<uint32_t>(image, wire::kInstanceU32), image.width, image.height);
  const auto add = [&](uint32_t number, Runs visible, std::optional<Silhouette> silhouette) {
    const Instance* const instance = description.find_instance(number);
    if (!instance) return;
    InstanceLabel label;
    label.number = number;
    label.index = static_cast<uint32_t>(instance - description.instances.data());
    set_pose(camera_from_world, labels.poses.world_from_instance[label.index], *instance, label);
    label.visible_px = count_pixels(visible);
    label.visible_box = box_of(visible, image.height);
    label.visible = std::move(visible);
    label.silhouette = std::move(silhouette);
    labels.instances.push_back(std::move(label));
  };
  if (image.amodal) {
    for (size_t i = 0; i < image.amodal->records.size(); ++i) {
      const uint32_t number = image.amodal->records[i].instance;
      if (description.find_instance(number))
        add(number, std::move(masks[number]), read_silhouette(image, i, has_depth));
    }
  } else {
    for (auto& [number, visible] : masks) add(number, std::move(visible), {});
  }
  for (uint32_t i = 0; i < description.keypoints.size(); ++i)
    labels.keypoints.push_back(find_keypoint(i, description.keypoints[i], camera_from_world,
                                             labels.poses.world_from_keypoint_node[i],
                                             labels.poses.intrinsics, depth_m));
  return labels;
}

void add_json(const ImageLabels& labels, const Description& description, ordered_json& line) {
  const passes::Intrinsics& k = labels.poses.intrinsics;
  line["cam_K"] = {k.fx_px, 0, k.cx_px, 0, k.fy_px, k.cy_px, 0, 0, 1};
  const glm::dmat4 camera_from_world = glm::inverse(labels.poses.world_from_camera);
  ordered_json rotation = ordered_json::array(), translation_mm = ordered_json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) rotation.push_back(camera_from_world[column][row]);
    translation_mm.push_back(camera_from_world[3][row] * kMillimetres);
  }
  line["cam_R_w2c"] = rotation;
  line["cam_t_w2c"] = translation_mm;
  if (labels.poses.baseline_m) line["baseline_m"] = *labels.poses.baseline_m;
  if (!labels.poses.drawn.empty()) {
    ordered_json& drawn = line["drawn"] = ordered_json::object();
    for (const auto& [name, value] : labels.poses.drawn)
      drawn[name] = value.numbers.empty()       ? ordered_json(printable_text(value.text, value.text.size()))
                    : value.numbers.size() == 1 ? ordered_json(value.numbers.front())
                                                : ordered_json(value.numbers);
  }
  if (!description.episode.state_names.empty()) line["state"] = labels.poses.state;
  if (!description.episode.environment_names.empty()) line["environment_state"] = labels.poses.environment;
  line["brightness"] = std::round(labels.brightness * 100) / 100;
  if (labels.beyond_range_px) line["beyond_range_px"] = *labels.beyond_range_px;
  const uint64_t pixels = uint64_t{k.image_px.x} * k.image_px.y;
  ordered_json& instances = line["instances"] = ordered_json::array();
  for (const InstanceLabel& label : labels.instances) {
    const Instance& instance = description.instances[label.index];
    ordered_json each;
    each["instance"] = label.number;
    each["obj_id"] = description.objects[instance.object].id;
    each["class"] = instance.semantic;
    each["cam_R_m2c"] = label.camera_from_model;
    each["cam_t_m2c"] = label.camera_from_model_mm;
    each["bbox_visib"] = json_of(label.visible_box);
    each["px_count_visib"] = label.visible_px;
    if (label.silhouette) {
      each["bbox_obj"] = json_of(label.silhouette->box);
      each["px_count_all"] = label.silhouette->px;
      each["px_count_valid"] = label.silhouette->valid_px;
      each["visib_fract"] = label.silhouette->visibility;
      each["truncated"] = label.silhouette->is_truncated;
    }
    if (label.is_rescaled) each["rescaled"] = true;
    each["counts"] = encode_counts(label.visible, pixels);
    instances.push_back(std::move(each));
  }
  constexpr const char* kStates[] = {"outside", "hidden", "visible"};
  ordered_json& keypoints = line["keypoints"] = ordered_json::array();
  for (const KeypointLabel& label : labels.keypoints)
    keypoints.push_back({{"name", description.keypoints[label.index].name},
                         {"instance", description.keypoints[label.index].instance},
                         {"pixel", {label.x_px, label.y_px}},
                         {"depth_m", label.depth_m},
                         {"state", kStates[static_cast<size_t>(label.state)]}});
}

}  // namespace fire3dv::dataset
