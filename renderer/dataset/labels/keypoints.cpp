#include "renderer/dataset/labels/keypoints.h"

#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/files.h"
#include "base/text.h"

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

std::vector<uint32_t> find_nodes(const scene::Scene& scene, const std::string& name) {
  std::vector<uint32_t> nodes;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    if (scene.nodes[n].name == name || scene.nodes[n].path == name) nodes.push_back(n);
  }
  return nodes;
}

// Returns an error for points that are not {"name": [x, y, z]}.
Result<void> add_points(const scene::Scene& scene, const std::string& name, const json& points,
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
    for (const uint32_t node : find_nodes(scene, name)) {
      point.node = node;
      const Instance* const instance = description.find_instance(node + 1);
      point.instance = instance ? instance->number : 0;
      if (description.keypoints.size() == kMaxKeypoints)
        return Error{"the scene has more than " + std::to_string(kMaxKeypoints) + " keypoints: name fewer"};
      description.keypoints.push_back(point);
    }
  }
  return {};
}

}  // namespace

Result<void> read_keypoints(const scene::Scene& scene, const std::filesystem::path& side_file,
                            Description& description) {
  const json file = json_of_scene(scene.source);
  const json nodes = file.is_object() ? file.value("nodes", json::array()) : json::array();
  for (const json& node : nodes) {
    if (!node.is_object() || !node.contains("name") || !node["name"].is_string()) continue;
    const json extras = node.value("extras", json::object());
    if (!extras.is_object() || !extras.contains("keypoints")) continue;
    auto added = add_points(scene, node["name"].get<std::string>(), extras["keypoints"], description);
    if (!added) description.warnings.push_back(added.error().message + ", and is left out");
  }
  if (side_file.empty()) return {};
  auto bytes = read_whole_file(side_file, kMaxJsonBytes);
  if (!bytes) return bytes.error();
  const json side = json::parse(bytes->begin(), bytes->end(), nullptr, false);
  const std::string name = side_file.string();
  if (!side.is_object()) return Error{name + " is not JSON of the form {\"NODE\": {\"tip\": [x, y, z]}}"};
  for (const auto& [node, points] : side.items()) {
    if (find_nodes(scene, node).empty())
      return Error{name + ": no node of the scene has the name or path " + quote(node)};
    if (auto added = add_points(scene, node, points, description); !added)
      return Error{name + ": " + added.error().message};
  }
  return {};
}

}  // namespace fire3dv::dataset
