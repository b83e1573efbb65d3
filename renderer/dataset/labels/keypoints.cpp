#include "renderer/dataset/labels/keypoints.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/files.h"
#include "base/nearest_names.h"
#include "base/text.h"
#include "renderer/scene/model/node_names.h"

namespace fire3dv::dataset {
namespace {

using nlohmann::json;

constexpr uint64_t kMaxJsonBytes = uint64_t{1} << 28;
constexpr uint64_t kMaxSceneBytes = uint64_t{1} << 40;
constexpr size_t kMaxKeypoints = 10'000;  // each is in the labels of each image

// JSON of a .gltf or .glb file; discarded: it is neither.
json json_of_scene(const std::filesystem::path& path) {
  const json nothing(json::value_t::discarded);
  auto file = OpenFile::open(path, kMaxSceneBytes);
  if (!file) return nothing;
  std::array<std::byte, 20> header{};
  uint64_t at = 0, size = file->size();
  if (file->size() >= header.size() && file->read(0, header) && std::memcmp(header.data(), "glTF", 4) == 0) {
    uint32_t length = 0;
    std::memcpy(&length, header.data() + 12, sizeof length);
    at = header.size();
    size = length;
  } else if (lower_extension(path) != ".gltf") {
    return nothing;
  }
  if (size > kMaxJsonBytes || at + size > file->size()) return nothing;
  std::string text(size, ' ');
  if (!file->read(at, std::as_writable_bytes(std::span(text)))) return nothing;
  return json::parse(text, nullptr, false);
}

// File nodes of the scene, without the nodes of instances: in the order in which the loader adds them.
std::vector<uint32_t> file_nodes(const scene::Scene& scene) {
  std::vector<uint32_t> nodes;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    if (!scene.nodes[n].path.empty() || scene.nodes[n].parent == scene::kNone) nodes.push_back(n);
  }
  return nodes;
}

std::vector<size_t> indices_at(const json& object, const char* member, size_t count) {
  std::vector<size_t> indices;
  const auto found = object.find(member);
  if (found == object.end() || !found->is_array()) return indices;
  for (const json& each : *found) {
    if (each.is_number_unsigned() && each.get<uint64_t>() < count) indices.push_back(each.get<size_t>());
  }
  return indices;
}

// Scene node of each node of the file, in the order of the file; kNone: it is not in the scene. The scene has
// them depth first, from the roots of the default scene. Empty: the scene has other nodes than the file.
std::vector<uint32_t> match_nodes(const json& file, const json& nodes, const scene::Scene& scene) {
  std::vector<bool> is_child(nodes.size());
  for (const json& node : nodes) {
    for (const size_t child :
         node.is_object() ? indices_at(node, "children", nodes.size()) : std::vector<size_t>())
      is_child[child] = true;
  }
  std::vector<size_t> pending;
  const auto scenes = file.find("scenes");
  if (scenes != file.end() && scenes->is_array() && !scenes->empty()) {
    const auto shown = file.find("scene");
    const size_t index = shown != file.end() && shown->is_number_unsigned() ? shown->get<size_t>() : 0;
    if (index < scenes->size() && (*scenes)[index].is_object())
      pending = indices_at((*scenes)[index], "nodes", nodes.size());
    // Exporters list descendants of roots, too.
    std::erase_if(pending, [&](size_t node) { return is_child[node]; });
  } else {
    for (size_t i = 0; i < nodes.size(); ++i) {
      if (!is_child[i]) pending.push_back(i);
    }
  }
  std::reverse(pending.begin(), pending.end());
  const std::vector<uint32_t> in_scene = file_nodes(scene);
  std::vector<uint32_t> matched(nodes.size(), scene::kNone);
  size_t next = 0;
  while (!pending.empty()) {
    const size_t at = pending.back();
    pending.pop_back();
    if (matched[at] != scene::kNone || !nodes[at].is_object()) return {};
    const auto name = nodes[at].find("name");
    const bool has_name = name != nodes[at].end() && name->is_string();
    if (next == in_scene.size() ||
        scene.nodes[in_scene[next]].name != (has_name ? name->get_ref<const std::string&>() : std::string()))
      return {};
    matched[at] = in_scene[next++];
    const std::vector<size_t> children = indices_at(nodes[at], "children", nodes.size());
    pending.insert(pending.end(), children.rbegin(), children.rend());
  }
  return matched;
}

std::vector<uint32_t> find_nodes(const scene::Scene& scene, const std::string& name) {
  std::vector<uint32_t> nodes;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    if (scene.nodes[n].name == name || scene.nodes[n].path == name) nodes.push_back(n);
  }
  return nodes;
}

// Returns an error for points that are not {"name": [x, y, z]}. A point replaces an earlier one of its node
// and name.
Result<void> add_points(std::span<const uint32_t> nodes, const std::string& name, const json& points,
                        Description& description) {
  const std::string where = "keypoints of node " + quote(name);
  if (!points.is_object()) return Error{where + " are not an object such as {\"tip\": [0, 0, 0.1]}"};
  for (const auto& [title, place] : points.items()) {
    Keypoint point;
    point.name = title;
    bool is_good = place.is_array() && place.size() == 3;
    for (size_t i = 0; i < 3 && is_good; ++i) {
      is_good = place[i].is_number() && std::isfinite(place[i].get<double>());
      if (is_good) point.node_from_point_m[i] = place[i].get<double>();
    }
    if (!is_good)
      return Error{where + ": " + quote(title) + " is not three numbers (metres in the node's axes)"};
    for (const uint32_t node : nodes) {
      point.node = node;
      const Instance* const instance = description.find_instance(node + 1);
      point.instance = instance ? instance->number : 0;
      const auto same =
          std::find_if(description.keypoints.begin(), description.keypoints.end(),
                       [&](const Keypoint& other) { return other.node == node && other.name == title; });
      if (same != description.keypoints.end()) {
        *same = point;
        continue;
      }
      if (description.keypoints.size() == kMaxKeypoints)
        return Error{"the scene has more than " + std::to_string(kMaxKeypoints) + " keypoints: name fewer"};
      description.keypoints.push_back(point);
    }
  }
  return {};
}

void read_extras(const scene::Scene& scene, Description& description) {
  const json file = json_of_scene(scene.source);
  const auto nodes = file.is_object() ? file.find("nodes") : file.end();
  if (nodes == file.end() || !nodes->is_array()) return;
  std::vector<uint32_t> matched;
  for (size_t i = 0; i < nodes->size(); ++i) {
    const json& node = (*nodes)[i];
    const auto extras = node.is_object() ? node.find("extras") : node.end();
    if (extras == node.end() || !extras->is_object()) continue;
    const auto points = extras->find("keypoints");
    if (points == extras->end()) continue;
    if (matched.empty()) matched = match_nodes(file, *nodes, scene);
    if (matched.empty()) {
      description.warnings.push_back(
          "keypoints in the file are left out: its nodes are not those of the scene");
      return;
    }
    if (matched[i] == scene::kNone) continue;
    const std::vector<uint32_t> found{matched[i]};
    auto added = add_points(found, scene.nodes[matched[i]].name, *points, description);
    if (!added) description.warnings.push_back(added.error().message + ", and is left out");
  }
}

}  // namespace

Result<void> read_keypoints(const scene::Scene& scene, const std::filesystem::path& side_file,
                            Description& description) {
  read_extras(scene, description);
  if (side_file.empty()) return {};
  auto bytes = read_whole_file(side_file, kMaxJsonBytes);
  if (!bytes) return bytes.error();
  const json side = json::parse(bytes->begin(), bytes->end(), nullptr, false);
  const std::string name = side_file.string();
  if (!side.is_object()) return Error{name + " is not JSON of the form {\"NODE\": {\"tip\": [x, y, z]}}"};
  for (const auto& [node, points] : side.items()) {
    const std::vector<uint32_t> found = find_nodes(scene, node);
    if (found.empty())
      return Error{name + ": no node of the scene has the name or path " + quote(node) +
                   name_hint(node, scene::node_names(scene, node), "nodes")};
    if (auto added = add_points(found, node, points, description); !added)
      return Error{name + ": " + added.error().message};
  }
  return {};
}

}  // namespace fire3dv::dataset
