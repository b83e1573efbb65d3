// Builder of glTF files with KHR_draco_mesh_compression. The stream comes from libdraco's own encoder.
#pragma once

#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>

#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tests/support/gltf_builder.h"

namespace fire3dv::test {

struct SourceMesh {
  std::vector<glm::vec3> positions, normals;
  std::vector<glm::vec2> uvs;
  std::vector<std::array<uint16_t, 4>> joints;
  std::vector<glm::vec4> weights;
  std::vector<std::array<uint8_t, 4>> colors;
  std::vector<std::array<uint32_t, 3>> faces;
};

// A square of 2 n^2 triangles with a smooth bump. Each vertex has its own position.
inline SourceMesh bumpy_square(int n) {
  SourceMesh mesh;
  for (int y = 0; y <= n; ++y) {
    for (int x = 0; x <= n; ++x) {
      const glm::vec2 uv = glm::vec2(x, y) / static_cast<float>(n);
      mesh.positions.emplace_back(uv, 0.3f * std::sin(3 * uv.x) * std::cos(2 * uv.y));
      mesh.normals.push_back(glm::normalize(glm::vec3(uv - 0.5f, 1)));
      mesh.uvs.push_back(uv);
    }
  }
  const auto at = [n](int x, int y) { return static_cast<uint32_t>(y * (n + 1) + x); };
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      mesh.faces.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      mesh.faces.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  }
  return mesh;
}

template <typename Value>
void add_attribute(draco::Mesh& mesh, draco::GeometryAttribute::Type type, draco::DataType data,
                   int components, bool normalized, const std::vector<Value>& values, uint32_t unique_id) {
  if (values.empty()) return;
  draco::GeometryAttribute description;
  description.Init(type, nullptr, static_cast<uint8_t>(components), data, normalized, sizeof(Value), 0);
  const int id = mesh.AddAttribute(description, true, static_cast<uint32_t>(values.size()));
  for (uint32_t i = 0; i < values.size(); ++i)
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), &values[i]);
  mesh.attribute(id)->set_unique_id(unique_id);
}

// Unique ids of the attributes, in no particular order, as exporters choose them.
enum DracoId : uint32_t {
  kWeightsId = 1,
  kUvId = 2,
  kPositionId = 3,
  kNormalId = 4,
  kJointsId = 5,
  kColorId = 7
};

inline std::unique_ptr<draco::Mesh> draco_mesh(const SourceMesh& source) {
  using Attribute = draco::GeometryAttribute;
  auto mesh = std::make_unique<draco::Mesh>();
  mesh->set_num_points(static_cast<uint32_t>(source.positions.size()));
  mesh->SetNumFaces(source.faces.size());
  for (uint32_t i = 0; i < source.faces.size(); ++i) {
    draco::Mesh::Face face;
    for (size_t corner = 0; corner < 3; ++corner) face[corner] = source.faces[i][corner];
    mesh->SetFace(draco::FaceIndex(i), face);
  }
  add_attribute(*mesh, Attribute::POSITION, draco::DT_FLOAT32, 3, false, source.positions, kPositionId);
  add_attribute(*mesh, Attribute::NORMAL, draco::DT_FLOAT32, 3, false, source.normals, kNormalId);
  add_attribute(*mesh, Attribute::TEX_COORD, draco::DT_FLOAT32, 2, false, source.uvs, kUvId);
  add_attribute(*mesh, Attribute::GENERIC, draco::DT_UINT16, 4, false, source.joints, kJointsId);
  add_attribute(*mesh, Attribute::GENERIC, draco::DT_FLOAT32, 4, false, source.weights, kWeightsId);
  add_attribute(*mesh, Attribute::COLOR, draco::DT_UINT8, 4, true, source.colors, kColorId);
  return mesh;
}

inline std::vector<std::byte> encoded(const draco::Mesh& mesh, int method) {
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 14);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::NORMAL, 12);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::TEX_COORD, 12);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) return {};
  const auto bytes = std::as_bytes(std::span(buffer.data(), buffer.size()));
  return {bytes.begin(), bytes.end()};
}

// One node with one primitive of this stream. The accessors have no bytes.
inline GltfBuilder draco_file(std::span<const std::byte> stream, const SourceMesh& source) {
  GltfBuilder builder;
  nlohmann::json attributes, ids;
  const auto add = [&](const char* name, size_t count, const char* type, ComponentType component,
                       bool normalized, DracoId id) {
    if (count == 0) return;
    nlohmann::json& accessors = builder.root["accessors"];
    nlohmann::json accessor{{"componentType", component}, {"type", type}, {"count", count}};
    if (normalized) accessor["normalized"] = true;
    accessors.push_back(accessor);
    attributes[name] = accessors.size() - 1;
    ids[name] = static_cast<uint32_t>(id);
  };
  add("POSITION", source.positions.size(), "VEC3", kFloat, false, kPositionId);
  add("NORMAL", source.normals.size(), "VEC3", kFloat, false, kNormalId);
  add("TEXCOORD_0", source.uvs.size(), "VEC2", kFloat, false, kUvId);
  add("JOINTS_0", source.joints.size(), "VEC4", kUnsignedShort, false, kJointsId);
  add("WEIGHTS_0", source.weights.size(), "VEC4", kFloat, false, kWeightsId);
  add("COLOR_0", source.colors.size(), "VEC4", kUnsignedByte, true, kColorId);
  nlohmann::json& accessors = builder.root["accessors"];
  accessors.push_back(
      {{"componentType", kUnsignedShort}, {"type", "SCALAR"}, {"count", source.faces.size() * 3}});
  const size_t indices = accessors.size() - 1;
  const nlohmann::json extension{{"bufferView", builder.add_view(stream)}, {"attributes", ids}};
  const size_t mesh = builder.add_mesh({{"attributes", attributes},
                                        {"indices", indices},
                                        {"extensions", {{"KHR_draco_mesh_compression", extension}}}});
  builder.add_node("square", {{"mesh", mesh}});
  builder.root["extensionsUsed"] = {"KHR_draco_mesh_compression"};
  builder.root["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  return builder;
}

}  // namespace fire3dv::test
