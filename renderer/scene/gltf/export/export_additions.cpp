// Nodes of an exported file that the loaded one does not have: lights, cameras, copies of nodes, and other
// files.

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"
#include "renderer/scene/gltf/export/export_parts.h"
#include "renderer/scene/model/shortest.h"

namespace fire3dv::scene {

using nlohmann::json;

void GlbExport::set_camera(uint32_t node, const Camera& camera) {
  json text;
  if (camera.orthographic) {
    text["type"] = "orthographic";
    text["orthographic"] = {{"xmag", shortest(camera.half_extent_m.x)},
                            {"ymag", shortest(camera.half_extent_m.y)},
                            {"znear", shortest(camera.near_m)},
                            {"zfar", shortest(camera.far_m)}};
  } else {
    text["type"] = "perspective";
    json& lens = text["perspective"];
    lens["yfov"] = shortest(camera.vertical_fov_rad);
    lens["znear"] = shortest(camera.near_m);
    if (camera.far_m > 0) lens["zfar"] = shortest(camera.far_m);
    if (camera.aspect > 0) lens["aspectRatio"] = shortest(camera.aspect);
    if (!camera.lens.is_pinhole())
      text["extras"] = {{"fNumber", shortest(camera.lens.f_number)},
                        {"focusDistanceM", shortest(camera.lens.focus_distance_m)}};
    if (camera.pixel_aspect != 1) text["extras"]["pixelAspectRatio"] = shortest(camera.pixel_aspect);
    if (camera.principal_point != glm::vec2(0))
      text["extras"]["principalPoint"] = {shortest(camera.principal_point.x),
                                          shortest(camera.principal_point.y)};
  }
  json& cameras = root_["cameras"];
  if (!cameras.is_array()) cameras = json::array();
  root_["nodes"][node]["camera"] = cameras.size();
  cameras.push_back(std::move(text));
}

// Names of all nodes of the file, and of added nodes that have their own; 1: the last number of each.
std::map<std::string, size_t> GlbExport::node_names(const std::vector<ExportedNode>& added) const {
  std::map<std::string, size_t> names;
  if (const auto nodes = root_.find("nodes"); nodes != root_.end() && !added.empty()) {
    for (const json& node : *nodes) names.emplace(node.value("name", std::string()), 1);
  }
  for (const ExportedNode& node : added) names.emplace(node.name, 1);
  return names;
}

// Number of the new node in the file; nullopt: its parent or its source is not in the file.
std::optional<uint32_t> GlbExport::add_node(const ExportedNode& node) {
  const auto source_of = [&](uint32_t number) {
    return number < source_of_node_.size() ? source_of_node_[number] : kNone;
  };
  const uint32_t parent = node.parent == kNone ? kNone : source_of(node.parent);
  const uint32_t copied = node.copied == kNone ? kNone : source_of(node.copied);
  if ((node.parent != kNone && parent == kNone) || (node.copied != kNone && copied == kNone))
    return std::nullopt;
  json& nodes = root_["nodes"];
  if (!nodes.is_array()) nodes = json::array();
  json text = copied == kNone ? json::object() : nodes.at(copied);
  text.erase("children");
  if (text.contains("extras") && text["extras"].is_object()) text["extras"].erase("fire3dv");  // its joints
  if (!node.name.empty()) text["name"] = node.name;
  const auto number = static_cast<uint32_t>(nodes.size());
  nodes.push_back(std::move(text));
  if (parent != kNone) {
    nodes[parent]["children"].push_back(number);
  } else if (const auto scenes = root_.find("scenes"); scenes != root_.end() && !scenes->empty()) {
    scenes->at(root_.value("scene", size_t{0}))["nodes"].push_back(number);
  } else {
    added_roots_.push_back(number);
  }
  source_of_node_.resize(std::max<size_t>(source_of_node_.size(), node.node + size_t{1}), kNone);
  source_of_node_[node.node] = number;
  if (node.light) set_light(number, *node.light);
  if (node.camera) set_camera(number, *node.camera);
  return number;
}

// A skin whose joints are all copied moves with the copies. copies: numbers in the file, by those of the
// sources.
void GlbExport::take_skins(const std::map<uint32_t, uint32_t>& copies) {
  std::map<size_t, size_t> own;
  for (const auto& [source, copy] : copies) {
    json& node = root_["nodes"][copy];
    if (!node.contains("skin")) continue;
    const auto skin = node["skin"].get<size_t>();
    if (const auto known = own.find(skin); known != own.end()) {
      node["skin"] = known->second;
      continue;
    }
    json text = root_["skins"].at(skin);
    const bool is_whole = std::ranges::all_of(
        text["joints"], [&](const json& joint) { return copies.contains(joint.get<uint32_t>()); });
    own[skin] = is_whole ? root_["skins"].size() : skin;
    if (is_whole) {
      for (json& joint : text["joints"]) joint = copies.at(joint.get<uint32_t>());
      text.erase("skeleton");
      root_["skins"].push_back(std::move(text));
    }
    node["skin"] = own[skin];
  }
}

namespace {

// Streams find nodes by name: a copied node leaves its name to the node of the file.
std::string name_in_copy(const std::string& name, const std::string& copy,
                         std::map<std::string, size_t>& names) {
  const std::string wanted = name + " (" + copy + ")";
  size_t& number = names[wanted];
  if (number++ == 0) return wanted;
  std::string unused = wanted + " " + std::to_string(number);
  while (!names.emplace(unused, 1).second) unused = wanted + " " + std::to_string(++number);
  return unused;
}

}  // namespace

// Returns the number of nodes that are left out.
size_t GlbExport::add_nodes(const std::vector<ExportedNode>& nodes) {
  size_t missing = 0;
  std::map<uint32_t, uint32_t> copies;  // of one copied node and those below it
  std::map<std::string, size_t> names = node_names(nodes);
  std::string copy;
  const auto end_copy = [&] { take_skins(std::exchange(copies, {})); };
  for (const ExportedNode& node : nodes) {
    if (!node.name.empty()) {
      end_copy();
      copy = node.name;
    }
    if (node.asset) {
      if (const Result<void> done = add_asset(node, names); !done)
        warnings_.push_back("node " + quote(node.name) + " is left out: " + done.error().message);
      continue;
    }
    // The loader makes the instances of a copied node.
    if (node.name.empty() && node.copied < is_instance_.size() && is_instance_[node.copied]) {
      mark_instance(node.node);
      continue;
    }
    const std::optional<uint32_t> number = add_node(node);
    missing += number ? 0 : 1;
    if (number && node.name.empty()) {
      json& text = root_["nodes"][*number];
      const std::string name = text.value("name", std::string());
      if (!name.empty()) text["name"] = name_in_copy(name, copy, names);
    }
    if (number && node.copied != kNone) copies[source_of_node_[node.copied]] = *number;
  }
  end_copy();
  return missing;
}

}  // namespace fire3dv::scene
