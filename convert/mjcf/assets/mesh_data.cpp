#include "convert/mjcf/assets/mesh_data.h"

#include <cmath>
#include <cstring>
#include <string>
#include <tuple>
#include <unordered_map>

#include "convert/mjcf/xml/mjcf_attributes.h"

namespace fire3dv::convert {
namespace {

constexpr size_t kMaxNumbers = 60'000'000;
constexpr float kMaxCoordinate = 1 << 30;

Error has_wrong_size(const char* format) {
  return Error{std::string("the ") + format +
               " file has counts that differ from its contents; export it again"};
}

template <typename T>
T value_at(std::string_view bytes, size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

struct VertexHash {
  size_t operator()(const glm::vec3& v) const {
    return std::hash<std::string_view>()({reinterpret_cast<const char*>(&v), sizeof v});
  }
};

Result<void> check_faces(const std::vector<MeshData::Triangle>& faces, size_t count, const char* kind) {
  for (const MeshData::Triangle& face : faces)
    for (const uint32_t index : face)
      if (index >= count)
        return Error{"a face names " + std::string(kind) + " " + std::to_string(index) + " of " +
                     std::to_string(count) + ", counted from 0; export it again"};
  return {};
}

// Counts must be three, or two, per vertex.
template <typename Vector>
Result<std::vector<Vector>> vectors(std::string_view text, const char* attribute) {
  constexpr size_t kLength = static_cast<size_t>(Vector::length());
  if (!is_mjcf_numbers(text, kMaxNumbers))
    return Error{std::string(attribute) + " holds something else than numbers"};
  const std::vector<double> numbers = mjcf_numbers(text, kMaxNumbers);
  if (numbers.size() % kLength != 0)
    return Error{"the count of numbers in " + std::string(attribute) + " is not a multiple of " +
                 std::to_string(kLength)};
  std::vector<Vector> made(numbers.size() / kLength);
  for (size_t i = 0; i < numbers.size(); ++i)
    made[i / kLength][static_cast<int>(i % kLength)] = static_cast<float>(numbers[i]);
  return made;
}

}  // namespace

Result<void> check_mesh_data(const MeshData& mesh) {
  for (const glm::vec3& v : mesh.vertices)
    for (int i = 0; i < 3; ++i)
      if (!(std::abs(v[i]) <= kMaxCoordinate))
        return Error{"a vertex is not finite, or beyond 2^30; export it again"};
  for (const auto& [faces, count, kind] :
       {std::tuple(&mesh.faces, mesh.vertices.size(), "vertex"),
        std::tuple(&mesh.normal_faces, mesh.normals.size(), "normal"),
        std::tuple(&mesh.uv_faces, mesh.uvs.size(), "texture coordinate")}) {
    if (Result<void> done = check_faces(*faces, count, kind); !done) return done;
  }
  return {};
}

Result<MeshData> parse_stl(std::string_view bytes) {
  constexpr size_t kHeader = 84, kTriangle = 50;
  if (bytes.size() < kHeader) return has_wrong_size("STL");
  const size_t count = value_at<uint32_t>(bytes, 80);
  if (count != (bytes.size() - kHeader) / kTriangle) {
    if (bytes.starts_with("solid"))
      return Error{"the STL file is text, which MuJoCo does not read either: export it as binary STL"};
    return has_wrong_size("STL");
  }
  MeshData mesh;
  std::unordered_map<glm::vec3, uint32_t, VertexHash> known;
  mesh.faces.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    MeshData::Triangle face{};
    for (size_t k = 0; k < 3; ++k) {
      const size_t at = kHeader + kTriangle * i + 12 * (k + 1);
      // Adding 0 makes -0 and 0 equal.
      const glm::vec3 v(value_at<float>(bytes, at) + 0.0f, value_at<float>(bytes, at + 4) + 0.0f,
                        value_at<float>(bytes, at + 8) + 0.0f);
      const auto [entry, is_new] = known.emplace(v, static_cast<uint32_t>(mesh.vertices.size()));
      if (is_new) mesh.vertices.push_back(v);
      face[k] = entry->second;
    }
    mesh.faces.push_back(face);
  }
  if (Result<void> done = check_mesh_data(mesh); !done) return done.error();
  return mesh;
}

Result<MeshData> parse_msh(std::string_view bytes) {
  constexpr size_t kHeader = 16;
  if (bytes.size() < kHeader) return has_wrong_size("MSH");
  uint64_t counts[4];
  for (size_t i = 0; i < 4; ++i) counts[i] = value_at<uint32_t>(bytes, 4 * i);
  const auto [vertices, normals, uvs, faces] = counts;
  // The sum cannot overflow, since counts have 32 bits.
  if (bytes.size() != kHeader + 12 * vertices + 12 * normals + 8 * uvs + 12 * faces)
    return has_wrong_size("MSH");
  if ((normals != 0 && normals != vertices) || (uvs != 0 && uvs != vertices))
    return Error{"the MSH file has normals or texture coordinates for some vertices only; export it again"};
  MeshData mesh;
  size_t at = kHeader;
  const auto take = [&](auto& to, uint64_t count) {
    to.resize(count);
    if (count > 0) std::memcpy(to.data(), bytes.data() + at, count * sizeof to[0]);
    at += count * sizeof to[0];
  };
  take(mesh.vertices, vertices);
  take(mesh.normals, normals);
  take(mesh.uvs, uvs);
  take(mesh.faces, faces);
  if (normals != 0) mesh.normal_faces = mesh.faces;
  if (uvs != 0) mesh.uv_faces = mesh.faces;
  if (Result<void> done = check_mesh_data(mesh); !done) return done.error();
  return mesh;
}

Result<MeshData> parse_inline_mesh(const InlineMesh& text) {
  MeshData mesh;
  Result<std::vector<glm::vec3>> vertices = vectors<glm::vec3>(text.vertices, "vertex");
  if (!vertices) return vertices.error();
  mesh.vertices = std::move(*vertices);
  Result<std::vector<glm::vec3>> normals = vectors<glm::vec3>(text.normals, "normal");
  if (!normals) return normals.error();
  mesh.normals = std::move(*normals);
  Result<std::vector<glm::vec2>> uvs = vectors<glm::vec2>(text.uvs, "texcoord");
  if (!uvs) return uvs.error();
  mesh.uvs = std::move(*uvs);
  if (!is_mjcf_numbers(text.faces, kMaxNumbers)) return Error{"face holds something else than numbers"};
  const std::vector<double> corners = mjcf_numbers(text.faces, kMaxNumbers);
  if (corners.size() % 3 != 0) return Error{"the count of numbers in face is not a multiple of 3"};
  mesh.faces.resize(corners.size() / 3);
  for (size_t i = 0; i < corners.size(); ++i) {
    if (!(corners[i] >= 0 && corners[i] < static_cast<double>(mesh.vertices.size())))
      return Error{"a face names vertex " + std::to_string(static_cast<int64_t>(std::round(corners[i]))) +
                   " of " + std::to_string(mesh.vertices.size()) + ", counted from 0"};
    mesh.faces[i / 3][i % 3] = static_cast<uint32_t>(corners[i]);
  }
  if (mesh.normals.size() == mesh.vertices.size()) mesh.normal_faces = mesh.faces;
  if (mesh.uvs.size() == mesh.vertices.size()) mesh.uv_faces = mesh.faces;
  if (Result<void> done = check_mesh_data(mesh); !done) return done.error();
  return mesh;
}

}  // namespace fire3dv::convert
