#include "renderer/dataset/labels/description.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>
#include <type_traits>

#include "base/files.h"
#include "base/text.h"
#include "renderer/offline/timeline.h"

namespace fire3dv::dataset {
namespace {

using nlohmann::ordered_json;

constexpr uint64_t kMaxDescriptionBytes = uint64_t{1} << 28;
constexpr size_t kMaxTextBytes = 4096;
constexpr uint32_t kMaxSide = 16384;

// nlohmann throws for text that is not UTF-8.
std::string text(const std::string& value) {
  return printable_text(value, kMaxTextBytes);
}

std::string text_at(const ordered_json& from, const char* name) {
  const auto found = from.find(name);
  return found != from.end() && found->is_string() ? found->get<std::string>() : std::string();
}
template <typename T>
bool number_at(const ordered_json& from, const char* name, T& value) {
  const auto found = from.find(name);
  if (found == from.end() || !found->is_number()) return false;
  const auto number = found->get<double>();
  if constexpr (std::is_integral_v<T>) {
    if (!(number >= 0 && number <= 4294967295.0)) return false;
  }
  value = static_cast<T>(number);
  return true;
}
bool size_at(const ordered_json& from, const char* name, uint64_t& value) {
  const auto found = from.find(name);
  if (found == from.end() || !found->is_number_unsigned()) return false;
  value = found->get<uint64_t>();
  return true;
}
bool flag_at(const ordered_json& from, const char* name) {
  const auto found = from.find(name);
  return found != from.end() && found->is_boolean() && found->get<bool>();
}
bool numbers_at(const ordered_json& from, const char* name, double (&values)[3]) {
  const auto found = from.find(name);
  if (found == from.end() || !found->is_array() || found->size() != 3) return false;
  for (size_t i = 0; i < 3; ++i) {
    if (!(*found)[i].is_number()) return false;
    values[i] = (*found)[i].get<double>();
  }
  return true;
}

bool texts_at(const ordered_json& json, const char* name, std::vector<std::string>& out) {
  const auto found = json.find(name);
  if (found == json.end() || !found->is_array() || found->size() > kMaxStateNumbers) return false;
  for (const auto& each : *found) {
    if (!each.is_string()) return false;
    out.push_back(each.get<std::string>());
  }
  return true;
}

bool parse(const ordered_json& json, Episode& out) {
  if (!json.is_object() || !number_at(json, "fps", out.fps) || out.fps == 0 || out.fps > kMaxFps)
    return false;
  out.task = text_at(json, "task");
  out.has_linear_depth = flag_at(json, "linear_depth");
  return texts_at(json, "state", out.state_names) && texts_at(json, "environment", out.environment_names);
}

// old_name: of earlier versions.
bool id_at(const ordered_json& from, const char* old_name, uint32_t& id) {
  return number_at(from, "obj_id", id) || number_at(from, old_name, id);
}

bool parse(const ordered_json& json, Description& out) {
  if (!json.is_object() || text_at(json, "type") != "fire3dv dataset") return false;
  out.format = text_at(json, "format");
  out.command = text_at(json, "command");
  out.license = text_at(json, "license");
  if (!number_at(json, "width", out.width) || !number_at(json, "height", out.height) ||
      !number_at(json, "depth_unit_mm", out.depth_unit_mm) ||
      !number_at(json, "label_alpha", out.label_alpha) || !size_at(json, "tar_bytes", out.tar_bytes) ||
      out.width == 0 || out.height == 0 || out.width > kMaxSide || out.height > kMaxSide ||
      !(out.depth_unit_mm > 0))
    return false;
  if (json.contains("flow_frames") && !number_at(json, "flow_frames", out.flow_frames)) return false;
  out.is_stereo = flag_at(json, "stereo");
  if (const auto episode = json.find("episode"); episode != json.end() && !parse(*episode, out.episode))
    return false;
  for (const char* name : {"cameras", "objects", "instances", "keypoints", "warnings"}) {
    if (!json.contains(name) || !json[name].is_array()) return false;
    const bool has_texts = std::string_view("cameras warnings").find(name) != std::string_view::npos;
    for (const auto& each : json[name]) {
      if (has_texts ? !each.is_string() : !each.is_object()) return false;
    }
  }
  if (json["cameras"].empty() || json["cameras"].size() > offline::kMaxCameras) return false;
  for (const auto& camera : json["cameras"]) out.cameras.push_back(camera.get<std::string>());
  for (const auto& each : json["objects"]) {
    Object object;
    object.name = text_at(each, "name");
    object.deforms = flag_at(each, "deforms");
    if (!id_at(each, "id", object.id) || !number_at(each, "diameter_mm", object.diameter_mm) ||
        !numbers_at(each, "min_mm", object.min_mm) || !numbers_at(each, "size_mm", object.size_mm) ||
        object.id != out.objects.size() + 1)
      return false;
    out.objects.push_back(object);
  }
  for (const auto& each : json["instances"]) {
    Instance instance;
    instance.name = text_at(each, "name");
    instance.path = text_at(each, "path");
    if (!number_at(each, "instance", instance.number) || !id_at(each, "object", instance.object) ||
        !number_at(each, "class", instance.semantic) || !numbers_at(each, "scale", instance.scale) ||
        instance.object == 0 || instance.object > out.objects.size() ||
        instance.number <= (out.instances.empty() ? 0 : out.instances.back().number))
      return false;
    --instance.object;
    out.instances.push_back(instance);
  }
  for (const auto& each : json["keypoints"]) {
    Keypoint point;
    point.name = text_at(each, "name");
    if (!number_at(each, "node", point.node) || !number_at(each, "instance", point.instance) ||
        !numbers_at(each, "node_from_point_m", point.node_from_point_m))
      return false;
    out.keypoints.push_back(point);
  }
  for (const auto& each : json["warnings"]) out.warnings.push_back(each.get<std::string>());
  if (const auto lines = json.find("randomization"); lines != json.end()) {
    if (!lines->is_array() || !size_at(json, "seed", out.seed)) return false;
    for (const auto& line : *lines) {
      if (!line.is_string()) return false;
      out.randomization.push_back(line.get<std::string>());
    }
  }
  return true;
}

}  // namespace

const Instance* Description::find_instance(uint32_t number) const {
  const auto at =
      std::lower_bound(instances.begin(), instances.end(), number,
                       [](const Instance& instance, uint32_t wanted) { return instance.number < wanted; });
  return at != instances.end() && at->number == number ? &*at : nullptr;
}

std::string list_names(const std::vector<std::string>& names) {
  constexpr size_t kMaxListed = 5;
  std::string list;
  for (size_t i = 0; i < std::min(names.size(), kMaxListed); ++i) list += (i ? ", " : "") + quote(names[i]);
  return list + (names.size() > kMaxListed ? ", ..." : "");
}

std::string to_json(const Description& description) {
  ordered_json json;
  json["type"] = "fire3dv dataset";
  json["format"] = description.format;
  json["command"] = text(description.command);
  json["license"] = text(description.license);
  json["width"] = description.width;
  json["height"] = description.height;
  json["depth_unit_mm"] = description.depth_unit_mm;
  json["tar_bytes"] = description.tar_bytes;
  json["label_alpha"] = description.label_alpha;
  json["flow_frames"] = description.flow_frames;
  json["stereo"] = description.is_stereo;
  if (const Episode& episode = description.episode; episode.fps != 0) {
    ordered_json& written = json["episode"];
    written = {
        {"fps", episode.fps}, {"task", text(episode.task)}, {"linear_depth", episode.has_linear_depth}};
    for (const char* name : {"state", "environment"}) written[name] = ordered_json::array();
    for (const std::string& name : episode.state_names) written["state"].push_back(text(name));
    for (const std::string& name : episode.environment_names) written["environment"].push_back(text(name));
  }
  for (const char* name : {"cameras", "objects", "instances", "keypoints", "warnings"})
    json[name] = ordered_json::array();
  for (const std::string& camera : description.cameras) json["cameras"].push_back(text(camera));
  for (const Object& object : description.objects)
    json["objects"].push_back({{"obj_id", object.id},
                               {"name", text(object.name)},
                               {"diameter_mm", object.diameter_mm},
                               {"min_mm", object.min_mm},
                               {"size_mm", object.size_mm},
                               {"deforms", object.deforms}});
  for (const Instance& instance : description.instances)
    json["instances"].push_back({{"instance", instance.number},
                                 {"obj_id", description.objects[instance.object].id},
                                 {"class", instance.semantic},
                                 {"name", text(instance.name)},
                                 {"path", text(instance.path)},
                                 {"scale", instance.scale}});
  for (const Keypoint& point : description.keypoints)
    json["keypoints"].push_back({{"name", text(point.name)},
                                 {"node", point.node},
                                 {"instance", point.instance},
                                 {"node_from_point_m", point.node_from_point_m}});
  for (const std::string& warning : description.warnings) json["warnings"].push_back(text(warning));
  if (!description.randomization.empty()) {
    json["seed"] = description.seed;
    json["randomization"] = ordered_json::array();
    for (const std::string& line : description.randomization) json["randomization"].push_back(text(line));
  }
  return json.dump(1) + "\n";
}

Result<Description> as_written(const Description& description) {
  const std::string text = to_json(description);
  if (text.size() > kMaxDescriptionBytes)
    return Error{"the labelled objects take " + std::to_string(text.size() >> 20) + " MiB in " +
                 kDescriptionName + ": label fewer nodes with --object"};
  Description result;
  if (!parse(ordered_json::parse(text), result))
    return Error{"a labelled node has a size that is not finite: choose others with --object"};
  return result;
}

Result<Description> read_description(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / kDescriptionName;
  auto bytes = read_whole_file(path, kMaxDescriptionBytes);
  if (!bytes) return bytes.error();
  const ordered_json json = ordered_json::parse(bytes->begin(), bytes->end(), nullptr, false);
  Description description;
  if (json.is_discarded() || !parse(json, description))
    return Error{path.string() +
                 " is not what fire3dv dataset writes: name another folder, or remove this one"};
  return description;
}

}  // namespace fire3dv::dataset
