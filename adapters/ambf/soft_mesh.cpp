#include "adapters/ambf/soft_mesh.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

#include "base/color/srgb.h"
#include "base/glb.h"
#include "base/text.h"

namespace fire3dv::ambf {
namespace {

constexpr const char* kVerticesName = "vertices";

float linear(float value) {
  return linear_from_srgb(std::clamp(value, 0.0f, 1.0f));
}

nlohmann::json view_json(const base::GlbBuffer::View& view) {
  return {{"buffer", 0},
          {"byteOffset", view.offset},
          {"byteLength", view.bytes},
          {"target", static_cast<int>(view.target)}};
}

}  // namespace

std::string soft_node_name(const std::string& name) {
  return name + " (soft body)";
}

std::string soft_vertices_path(const std::string& name) {
  return path_part(soft_node_name(name)) + "/" + kVerticesName;
}

std::vector<std::byte> soft_mesh_glb(const SoftMesh& mesh) {
  const size_t vertices = mesh.positions.size() / 3;
  if (vertices == 0 || mesh.triangles.size() < 3) return {};
  const auto names_no_vertex = [&](uint32_t index) { return index >= vertices; };
  if (std::any_of(mesh.triangles.begin(), mesh.triangles.end(), names_no_vertex)) return {};

  std::array<float, 3> low, high;
  for (size_t axis = 0; axis < 3; ++axis) {
    low[axis] = high[axis] = mesh.positions[axis];
    for (size_t i = axis; i < vertices * 3; i += 3) {
      if (!std::isfinite(mesh.positions[i])) return {};
      low[axis] = std::min(low[axis], mesh.positions[i]);
      high[axis] = std::max(high[axis], mesh.positions[i]);
    }
  }
  using Target = base::GlbBuffer::Target;
  base::GlbBuffer buffer;
  buffer.add_view(std::as_bytes(std::span(mesh.positions).first(vertices * 3)), Target::array_buffer);
  buffer.add_view(std::as_bytes(std::span(mesh.triangles)), Target::element_array_buffer);
  const auto& color = mesh.color_srgb;

  nlohmann::json root;
  root["asset"] = {{"version", "2.0"}};
  root["scene"] = 0;
  root["scenes"] = {{{"nodes", {0}}}};
  root["nodes"] = nlohmann::json::array(
      {{{"name", kVerticesName}, {"mesh", 0}, {"rotation", {-0.70710678, 0, 0, 0.70710678}}}});
  root["meshes"] = nlohmann::json::array(
      {{{"primitives",
         nlohmann::json::array({{{"attributes", {{"POSITION", 0}}}, {"indices", 1}, {"material", 0}}})}}});
  root["materials"] = nlohmann::json::array(
      {{{"doubleSided", true},
        {"alphaMode", color[3] < 1 ? "BLEND" : "OPAQUE"},
        {"pbrMetallicRoughness",
         {{"baseColorFactor",
           {linear(color[0]), linear(color[1]), linear(color[2]), std::clamp(color[3], 0.0f, 1.0f)}},
          {"metallicFactor", 0},
          {"roughnessFactor", 0.6}}}}});
  root["accessors"] = nlohmann::json::array(
      {{{"bufferView", 0},
        {"componentType", 5126},
        {"count", vertices},
        {"type", "VEC3"},
        {"min", low},
        {"max", high}},
       {{"bufferView", 1}, {"componentType", 5125}, {"count", mesh.triangles.size()}, {"type", "SCALAR"}}});
  root["bufferViews"] = nlohmann::json::array({view_json(buffer.views()[0]), view_json(buffer.views()[1])});
  root["buffers"] = nlohmann::json::array({{{"byteLength", buffer.bytes().size()}}});
  return base::make_glb(root.dump(), buffer.bytes());
}

}  // namespace fire3dv::ambf
