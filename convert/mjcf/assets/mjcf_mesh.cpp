#include "convert/mjcf/assets/mjcf_mesh.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include "convert/mesh/geometry/mesh_normals.h"
#include "convert/mesh/mesh_store.h"
#include "convert/mjcf/assets/builtin_mesh.h"
#include "convert/mjcf/assets/convex_hull.h"
#include "convert/mjcf/assets/mesh_data.h"
#include "convert/mjcf/assets/mesh_inertia.h"
#include "convert/mjcf/assets/mjcf_source.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;

// MuJoCo's test for file types: the ending needs no dot.
bool ends_with(std::string name, std::string_view ending) {
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name.ends_with(ending);
}

Result<MeshData> parse_file(const MjcfElement& element, const std::string& name, const FileBytes& bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.view().data()), bytes.view().size());
  const std::string type = element.text("content_type");
  if (type == "model/obj" || (type.empty() && ends_with(name, "obj"))) return parse_obj(text);
  if (type == "model/stl" || (type.empty() && ends_with(name, "stl"))) return parse_stl(text);
  if (type == "model/vnd.mujoco.msh" || (type.empty() && ends_with(name, "msh"))) return parse_msh(text);
  return Error{quote(name) + " is not a mesh of a kind that MuJoCo reads (OBJ, STL, MSH)"};
}

Result<MeshData> read_data(MjcfSource& source, const MjcfElement& element) {
  if (const std::string builtin = element.text("builtin"); !builtin.empty() && builtin != "none") {
    const std::string parameters = element.text("params");
    constexpr size_t kMaxParameters = 16;
    if (!is_mjcf_numbers(parameters, kMaxParameters))
      return Error{"params holds something else than numbers"};
    return builtin_mesh(builtin, mjcf_numbers(parameters, kMaxParameters));
  }
  const InlineMesh own{element.find("vertex") ? *element.find("vertex") : std::string_view(),
                       element.find("normal") ? *element.find("normal") : std::string_view(),
                       element.find("texcoord") ? *element.find("texcoord") : std::string_view(),
                       element.find("face") ? *element.find("face") : std::string_view()};
  const std::string name = source.file_name(element.text("file"));
  if (name.empty()) {
    const auto& children = element.children;
    if (own.vertices.empty() && std::any_of(children.begin(), children.end(),
                                            [](const MjcfElement& each) { return each.kind == "plugin"; }))
      return Error{"its shape is computed by a plugin, which is not supported; save the mesh as a file"};
    if (own.vertices.empty()) return Error{"it has neither a file nor vertices"};
    return parse_inline_mesh(own);
  }
  const Result<fs::path> file =
      source.files().find(name, source.folders(element, source.compiler().mesh_folder));
  if (!file) return file.error();
  const Result<FileBytes> bytes = source.files().read(*file);
  if (!bytes) return bytes.error();
  Result<MeshData> data = parse_file(element, name, *bytes);
  if (!data) return Error{quote(file->string()) + ": " + data.error().message};
  return data;
}

// Applies the reference pose, then the scale.
void transform(const MjcfAttributes& from, const glm::dvec3& scale, MeshData& data,
               std::vector<glm::dvec3>& vertices) {
  const glm::dvec3 origin = from.vec3("refpos").value_or(glm::dvec3(0));
  const glm::dvec4 q = from.vec4("refquat").value_or(glm::dvec4(1, 0, 0, 0));
  const glm::dquat rotation = glm::length(q) > 1e-14
                                  ? glm::conjugate(glm::normalize(glm::dquat(q.x, q.y, q.z, q.w)))
                                  : glm::dquat(1, 0, 0, 0);
  for (const glm::vec3& vertex : data.vertices)
    vertices.push_back(scale * (rotation * (glm::dvec3(vertex) - origin)));
  for (glm::vec3& normal : data.normals) normal = glm::vec3((rotation * glm::dvec3(normal)) / scale);
  if (scale.x * scale.y * scale.z < 0)
    for (std::vector<MeshData::Triangle>* faces : {&data.faces, &data.normal_faces, &data.uv_faces})
      for (MeshData::Triangle& face : *faces) std::swap(face[1], face[2]);
}

// Shares vertices of equal position, so that normals are smooth across them.
void share_vertices(std::vector<glm::dvec3>& vertices, std::vector<MeshData::Triangle>& faces) {
  std::vector<uint32_t> order(vertices.size()), shared(vertices.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = static_cast<uint32_t>(i);
  const auto key = [&](uint32_t i) { return std::tuple(vertices[i].x, vertices[i].y, vertices[i].z); };
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return key(a) < key(b); });
  for (size_t i = 0; i < order.size(); ++i)
    shared[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? shared[order[i - 1]] : order[i];
  for (MeshData::Triangle& face : faces)
    for (uint32_t& corner : face) corner = shared[corner];
}

Surface surface_of(const MeshData& data, const std::vector<glm::dvec3>& vertices, bool smooth) {
  const bool has_uvs = data.uv_faces.size() == data.faces.size();
  const bool has_normals = data.normal_faces.size() == data.faces.size();
  std::vector<glm::vec3> made;
  if (!has_normals) {
    std::vector<glm::dvec3> positions = vertices;
    std::vector<MeshData::Triangle> faces = data.faces;
    share_vertices(positions, faces);
    made = corner_normals(positions, faces, smooth ? kAllSmooth : kSmoothCosine, NormalWeights::area);
  }
  SurfaceBuilder builder(true, has_uvs);
  for (size_t i = 0; i < data.faces.size(); ++i) {
    SurfaceBuilder::Corner corners[3];
    for (size_t k = 0; k < 3; ++k) {
      corners[k].position = glm::vec3(vertices[data.faces[i][k]]);
      corners[k].normal = has_normals ? data.normals[data.normal_faces[i][k]] : made[3 * i + k];
      if (!has_uvs) continue;
      const glm::vec2 uv = data.uvs[data.uv_faces[i][k]];
      if (std::isfinite(uv.x) && std::isfinite(uv.y)) corners[k].uv = uv;
    }
    builder.add(corners[0], corners[1], corners[2]);
  }
  return builder.take();
}

MeshVolume volume_kind(const MjcfAttributes& from) {
  const std::string inertia = from.text("inertia");
  return inertia == "shell"                          ? MeshVolume::shell
         : inertia == "exact" || inertia == "convex" ? MeshVolume::exact
                                                     : MeshVolume::legacy;
}

}  // namespace

Result<MeshData> read_mjcf_mesh_data(MjcfSource& source, const MjcfElement& element) {
  Result<MeshData> data = read_data(source, element);
  if (!data) return data.error();
  std::map<std::tuple<float, float, float>, uint32_t> known;
  std::vector<uint32_t> shared;
  std::vector<glm::vec3> vertices;
  for (const glm::vec3& v : data->vertices) {
    const auto next = static_cast<uint32_t>(vertices.size());
    const auto [entry, is_new] = known.try_emplace({v.x, v.y, v.z}, next);
    if (is_new) vertices.push_back(v);
    shared.push_back(entry->second);
  }
  data->vertices = std::move(vertices);
  for (MeshData::Triangle& face : data->faces)
    for (uint32_t& corner : face) corner = shared[corner];
  return data;
}

Result<std::shared_ptr<const MjcfMesh>> read_mjcf_mesh(MjcfSource& source, const MjcfMeshAsset& asset) {
  const MjcfElement& element = *asset.element;
  const MjcfAttributes from = source.attributes(element, asset.class_index);
  const glm::dvec3 scale = from.vec3("scale").value_or(glm::dvec3(1));
  if (scale.x == 0 || scale.y == 0 || scale.z == 0) return Error{"a component of its scale is 0"};
  Result<MeshData> data = read_data(source, element);
  if (!data) return data.error();
  if (data->faces.empty()) {
    Result<std::vector<MeshData::Triangle>> hull = convex_hull(data->vertices);
    if (!hull) return hull.error();
    data->faces = std::move(*hull);
    data->normal_faces.clear();
    data->uv_faces =
        data->uvs.size() == data->vertices.size() ? data->faces : std::vector<MeshData::Triangle>();
  }
  std::vector<glm::dvec3> vertices;
  vertices.reserve(data->vertices.size());
  transform(from, scale, *data, vertices);
  for (const glm::dvec3& vertex : vertices)
    for (int i = 0; i < 3; ++i)
      if (!(std::abs(vertex[i]) <= 1e30)) return Error{"its scale is too large for its vertices"};
  auto mesh = std::make_shared<MjcfMesh>();
  add_mesh_inertia(vertices, data->faces, volume_kind(from), *mesh);
  mesh->surface =
      std::make_shared<const Surface>(surface_of(*data, vertices, from.flag("smoothnormal", false)));
  return std::shared_ptr<const MjcfMesh>(std::move(mesh));
}

MjcfFit fit_mjcf_mesh(const MjcfMesh& mesh, MjcfShape shape, bool fits_bounds) {
  MjcfFit fit;
  glm::dvec3 half = mesh.inertia_half;
  if (fits_bounds) {
    fit.centre = (mesh.low + mesh.high) / 2.0;
    half = (mesh.high - mesh.low) / 2.0;
  }
  const double radius = fits_bounds ? std::max(half.x, half.y) : (half.x + half.y) / 2;
  switch (shape) {
    case MjcfShape::sphere:
      fit.size.x = fits_bounds ? std::max({half.x, half.y, half.z}) : (half.x + half.y + half.z) / 3;
      break;
    case MjcfShape::capsule:
      fit.size = {radius, fits_bounds ? half.z - radius : std::max(0.0, half.z - radius / 2), 0};
      break;
    case MjcfShape::cylinder:
      fit.size = {radius, half.z, 0};
      break;
    default:
      fit.size = half;
  }
  return fit;
}

}  // namespace fire3dv::convert
