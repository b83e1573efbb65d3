#include "renderer/dataset/labels/line_check.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

namespace fire3dv::dataset {
namespace {

using nlohmann::json;

constexpr double kMaxNumber = 1e15;  // of any value

bool is_number(const json& value) {
  return value.is_number() && std::abs(value.get<double>()) <= kMaxNumber;
}

bool has_number(const json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && is_number(*found);
}

bool has_numbers(const json& object, const char* name, size_t count) {
  const auto found = object.find(name);
  return found != object.end() && found->is_array() && found->size() == count &&
         std::all_of(found->begin(), found->end(), is_number);
}

bool has_count(const json& object, const char* name, uint64_t most) {
  const auto found = object.find(name);
  return found != object.end() && found->is_number_unsigned() && found->get<uint64_t>() <= most;
}

bool has_text(const json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string();
}

bool has_flag(const json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_boolean();
}

bool is_instance(const json& label, const Description& description) {
  const uint64_t pixels = uint64_t{description.width} * description.height;
  if (!label.is_object() || !has_count(label, "instance", UINT32_MAX)) return false;
  const Instance* const instance = description.find_instance(label["instance"].get<uint32_t>());
  if (!instance || !has_count(label, "obj_id", UINT32_MAX) ||
      label["obj_id"] != description.objects[instance->object].id || !has_count(label, "class", UINT32_MAX))
    return false;
  if (!has_numbers(label, "cam_R_m2c", 9) || !has_numbers(label, "cam_t_m2c", 3) ||
      !has_numbers(label, "bbox_visib", 4) || !has_count(label, "px_count_visib", pixels) ||
      !has_text(label, "counts"))
    return false;
  if (label.contains("rescaled") && !has_flag(label, "rescaled")) return false;
  return !label.contains("visib_fract") ||
         (has_numbers(label, "bbox_obj", 4) && has_count(label, "px_count_all", pixels) &&
          has_count(label, "px_count_valid", pixels) && has_number(label, "visib_fract") &&
          has_flag(label, "truncated"));
}

bool is_keypoint(const json& point) {
  if (!point.is_object() || !has_text(point, "name") || !has_count(point, "instance", UINT32_MAX) ||
      !has_text(point, "state"))
    return false;
  const auto state = point["state"].get<std::string_view>();
  const bool is_outside = state == "outside";  // far away, its pixel may be any number
  const auto pixel = point.find("pixel");
  return (is_outside || state == "hidden" || state == "visible") && point.contains("depth_m") &&
         pixel != point.end() && pixel->is_array() && pixel->size() == 2 &&
         (is_outside || has_numbers(point, "pixel", 2));
}

// Numbers, texts, or short lists of numbers, by name.
bool has_drawn(const json& line) {
  const auto drawn = line.find("drawn");
  if (drawn == line.end()) return true;
  return drawn->is_object() && std::all_of(drawn->begin(), drawn->end(), [](const json& value) {
           constexpr size_t kMaxParts = 4;
           return value.is_string() || is_number(value) ||
                  (value.is_array() && value.size() <= kMaxParts &&
                   std::all_of(value.begin(), value.end(), is_number));
         });
}

bool has_state(const json& line, const Episode& episode) {
  return (episode.state_names.empty() || has_numbers(line, "state", episode.state_names.size())) &&
         (episode.environment_names.empty() ||
          has_numbers(line, "environment_state", episode.environment_names.size()));
}

template <typename IsElement>
bool has_list(const json& object, const char* name, IsElement&& is_element) {
  const auto found = object.find(name);
  return found != object.end() && found->is_array() && std::all_of(found->begin(), found->end(), is_element);
}

}  // namespace

bool is_image_line(const json& line, const Description& description) {
  const uint64_t pixels = uint64_t{description.width} * description.height;
  return line.is_object() && has_numbers(line, "cam_K", 9) && has_numbers(line, "cam_R_w2c", 9) &&
         has_numbers(line, "cam_t_w2c", 3) && has_number(line, "brightness") && has_drawn(line) &&
         has_state(line, description.episode) &&
         (!line.contains("beyond_range_px") || has_count(line, "beyond_range_px", pixels)) &&
         has_list(line, "instances", [&](const json& label) { return is_instance(label, description); }) &&
         has_list(line, "keypoints", is_keypoint);
}

}  // namespace fire3dv::dataset
