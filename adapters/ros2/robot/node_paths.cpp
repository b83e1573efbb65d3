#include "adapters/ros2/robot/node_paths.h"

#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "base/text.h"

namespace fire3dv::ros2 {
namespace {

using Json = nlohmann::json;

constexpr size_t kHeaderBytes = 20;  // of the file and of its first chunk

}  // namespace

std::unordered_map<std::string, std::string> node_paths(std::span<const uint8_t> glb) {
  std::unordered_map<std::string, std::string> paths;
  if (glb.size() < kHeaderBytes) return paths;
  const size_t length = glb[12] | size_t{glb[13]} << 8 | size_t{glb[14]} << 16 | size_t{glb[15]} << 24;
  if (length > glb.size() - kHeaderBytes) return paths;
  const uint8_t* const text = glb.data() + kHeaderBytes;
  const Json file = Json::parse(text, text + length, nullptr, false);
  if (!file.is_object() || !file.contains("nodes") || !file["nodes"].is_array()) return paths;
  const Json& nodes = file["nodes"];
  std::vector<bool> is_child(nodes.size(), false);
  const auto children = [&](size_t node) {
    std::vector<size_t> indices;
    if (!nodes[node].is_object() || !nodes[node].contains("children")) return indices;
    for (const Json& child : nodes[node]["children"])
      if (child.is_number_unsigned() && child.get<size_t>() < nodes.size())
        indices.push_back(child.get<size_t>());
    return indices;
  };
  for (size_t i = 0; i < nodes.size(); ++i)
    for (const size_t child : children(i)) is_child[child] = true;
  std::vector<std::pair<size_t, std::string>> open;  // node and path of its parent
  for (size_t i = 0; i < nodes.size(); ++i)
    if (!is_child[i]) open.emplace_back(i, "");
  std::vector<bool> is_seen(nodes.size(), false);
  while (!open.empty()) {
    const auto [node, parent] = std::move(open.back());
    open.pop_back();
    if (is_seen[node]) continue;
    is_seen[node] = true;
    const Json& value = nodes[node];
    const bool has_name = value.is_object() && value.contains("name") && value["name"].is_string();
    const std::string name = has_name ? value["name"].get<std::string>() : std::string();
    const std::string path = parent + (parent.empty() ? "" : "/") + path_part(name);
    paths.emplace(name, path);
    for (const size_t child : children(node)) open.emplace_back(child, path);
  }
  return paths;
}

}  // namespace fire3dv::ros2
