#include "adapters/gazebo/scene/scene_model.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "adapters/gazebo/scene/materials.h"
#include "protocol/base/text.h"
#include "tools/convert/mesh/mesh_files.h"
#include "tools/convert/mesh/mesh_store.h"
#include "tools/convert/mesh/node_frames.h"
#include "tools/convert/mesh/surfaces.h"

namespace fire3dv::gazebo {
namespace {

constexpr size_t kMaxTriangles = 20'000'000;
constexpr size_t kMaxWarnings = 100;
constexpr double kMaxSize_m = 1e7;

using convert::Mesh;
using convert::SdfEntity;
using convert::Surface;

// Geometry.Type of Gazebo's messages.
enum GeometryType {
  kBox,
  kCylinder,
  kSphere,
  kPlane,
  kImage,
  kHeightmap,
  kMesh,
  kTriangleFan,
  kLineStrip,
  kPolyline,
  kCone,
  kEmpty,
  kArrow,
  kAxis,
  kCapsule,
  kEllipsoid
};

bool is_size(double x) {
  return std::isfinite(x) && x > 0 && x <= kMaxSize_m;
}

glm::dvec3 vector(const pb::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

bool is_finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Cone along Z with its tip above, centred at half its height.
Surface cone(double radius, double half_length) {
  constexpr uint32_t kSlices = 48;
  Surface surface;
  const double slope = std::atan2(radius, 2 * half_length);
  for (uint32_t i = 0; i <= kSlices; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSlices, u = static_cast<double>(i) / kSlices;
    const glm::dvec2 around(std::cos(angle), std::sin(angle));
    const glm::vec3 normal(glm::dvec3(around * std::cos(slope), std::sin(slope)));
    surface.positions.emplace_back(glm::dvec3(radius * around, -half_length));
    surface.positions.emplace_back(0, 0, half_length);
    surface.positions.emplace_back(glm::dvec3(radius * around, -half_length));
    surface.normals.insert(surface.normals.end(), {normal, normal, glm::vec3(0, 0, -1)});
    surface.uvs.insert(surface.uvs.end(), {glm::vec2(u, 1), glm::vec2(u, 0),
                                           glm::vec2(0.5 + 0.5 * around.x, 0.5 - 0.5 * around.y)});
  }
  for (uint32_t i = 0; i < kSlices; ++i) {
    surface.indices.insert(surface.indices.end(), {3 * i, 3 * i + 3, 3 * i + 1});
    if (i > 0 && i + 1 < kSlices)
      surface.indices.insert(surface.indices.end(), {2, 3 * (i + 1) + 2, 3 * i + 2});
  }
  return surface;
}

class Builder {
 public:
  Builder(convert::Model& model, const Resources& resources)
      : model_(model),
        resources_(resources),
        files_(model),
        store_(model, kMaxTriangles),
        materials_(model, resources) {}

  void add(const TopLevel& item) {
    const size_t first = model_.nodes.size();
    std::vector<size_t> node_of;
    for (const Entity& entity : item.entities) {
      convert::Node node;
      node.name = item.added_node.empty() ? entity.name : own_name(entity);
      if (entity.parent != kNoParent) node.parent = node_of[entity.parent];
      node.translation = entity.pose.translation;
      node.rotation = entity.pose.rotation;
      node_of.push_back(model_.nodes.size());
      const size_t self = model_.nodes.size();
      model_.nodes.push_back(std::move(node));
      if (entity.visual) {
        // The mesh is found first: it may add materials, not nodes.
        const std::optional<size_t> mesh = mesh_of(*entity.visual, entity.name);
        model_.nodes[self].mesh = mesh;
      }
      if (entity.light) add_light(*entity.light, model_.nodes[self].name, self);
      if (entity.sensor) add_camera(*entity.sensor, model_.nodes[self].name, self);
    }
    FIRE3DV_ASSERT(model_.nodes.size() >= first + item.entities.size());
  }

 private:
  void warn(const std::string& text) {
    if (model_.warnings.size() < kMaxWarnings) model_.warnings.push_back(text);
  }
  std::optional<size_t> mesh_of(const pb::Visual& visual, const std::string& node);
  std::optional<Surface> shape_of(const pb::Geometry& geometry, const std::string& node);
  std::optional<Mesh> file_mesh(const pb::Visual& visual, const std::string& node);
  Result<std::vector<Surface>> file_surfaces(const pb::MeshGeom& from, const std::filesystem::path& file,
                                             const glm::dvec3& scale);
  void add_light(const pb::Light& from, std::string name, size_t parent);
  void add_camera(const pb::Sensor& from, std::string name, size_t parent);

  convert::Model& model_;
  const Resources& resources_;
  convert::MeshFiles files_;
  convert::MeshStore store_;
  Materials materials_;
  std::map<int, bool> reported_types_;
};

std::optional<Surface> Builder::shape_of(const pb::Geometry& geometry, const std::string& node) {
  const auto bad = [&]() -> std::optional<Surface> {
    warn(quote(node) + " is left out: its geometry has a size that is not above 0");
    return std::nullopt;
  };
  const auto round = [&](const pb::CylinderGeom& from,
                         Surface (*make)(double, double)) -> std::optional<Surface> {
    if (!is_size(from.radius()) || !is_size(from.length())) return bad();
    return make(from.radius(), from.length() / 2);
  };
  switch (geometry.type()) {
    case kBox: {
      const glm::dvec3 size = vector(geometry.box().size());
      if (!is_size(size.x) || !is_size(size.y) || !is_size(size.z)) return bad();
      return convert::box(size * 0.5);
    }
    case kCylinder:
      return round(geometry.cylinder(), convert::cylinder);
    case kCone:
      return round(geometry.cone(), cone);
    case kCapsule:
      return round(geometry.capsule(), convert::capsule);
    case kSphere: {
      const double radius = geometry.sphere().radius();
      if (!is_size(radius)) return bad();
      return convert::ellipsoid(glm::dvec3(radius));
    }
    case kEllipsoid: {
      const glm::dvec3 radii = vector(geometry.ellipsoid().radii());
      if (!is_size(radii.x) || !is_size(radii.y) || !is_size(radii.z)) return bad();
      return convert::ellipsoid(radii);
    }
    case kPlane: {
      const pb::PlaneGeom& plane = geometry.plane();
      if (!is_size(plane.size().x()) || !is_size(plane.size().y())) return bad();
      const Surface flat = convert::rectangle(plane.size().x() / 2, plane.size().y() / 2, glm::dvec2(1));
      const glm::dvec3 normal = vector(plane.normal());
      const double length = glm::length(normal);
      if (!std::isfinite(length) || length < 1e-9 || normal / length == glm::dvec3(0, 0, 1)) return flat;
      // The shortest rotation from +Z to the normal.
      const glm::dvec3 to = normal / length;
      const glm::dquat turn = to.z < -0.999999
                                  ? glm::dquat(0, 1, 0, 0)
                                  : glm::normalize(glm::dquat(1 + to.z, glm::cross(glm::dvec3(0, 0, 1), to)));
      Mesh turned;
      convert::add_surface(turned, flat, convert::matrix_of(glm::dvec3(0), turn), 0);
      return turned.surfaces.front();
    }
    case kEmpty:
      return std::nullopt;
    default:
      if (!std::exchange(reported_types_[geometry.type()], true))
        warn(quote(node) + " is left out: geometries of type " + std::to_string(geometry.type()) +
             (geometry.type() == kHeightmap  ? " (heightmap)"
              : geometry.type() == kPolyline ? " (polyline)"
                                             : "") +
             " are not converted; open the .sdf file, or give it a mesh");
      return std::nullopt;
  }
}

Result<std::vector<Surface>> Builder::file_surfaces(const pb::MeshGeom& from,
                                                    const std::filesystem::path& file,
                                                    const glm::dvec3& scale) {
  Result<std::vector<Surface>> surfaces = files_.surfaces(file, scale);
  if (!surfaces || from.submesh().empty()) return surfaces;
  // Surfaces of the node of that name and below it.
  Result<convert::ImportedMesh> whole = files_.scene(file);
  if (!whole) return whole.error();
  std::vector<bool> is_part(whole->nodes.size(), false);
  std::vector<glm::dmat4> file_from_node(whole->nodes.size(), glm::dmat4(1));
  for (size_t i = 0; i < whole->nodes.size(); ++i) {
    const convert::ImportedNode& node = whole->nodes[i];
    file_from_node[i] = node.file_from_node;
    is_part[i] =
        node.name == from.submesh() || (node.parent >= 0 && is_part[static_cast<size_t>(node.parent)]);
  }
  Mesh part;
  for (size_t i = 0; i < whole->surfaces.size(); ++i) {
    const size_t node = whole->surface_nodes[i];
    if (!is_part[node]) continue;
    glm::dmat4 scaled(1);
    for (int axis = 0; axis < 3; ++axis) scaled[axis][axis] = scale[axis];
    convert::add_surface(part, whole->surfaces[i], scaled * file_from_node[node],
                         whole->surfaces[i].material);
  }
  if (part.surfaces.empty()) return Error{"it has no submesh " + quote(from.submesh())};
  if (from.center_submesh()) {
    glm::vec3 low(INFINITY), high(-INFINITY);
    for (const Surface& surface : part.surfaces)
      for (const glm::vec3& p : surface.positions) low = glm::min(low, p), high = glm::max(high, p);
    for (Surface& surface : part.surfaces)
      for (glm::vec3& p : surface.positions) p -= (low + high) * 0.5f;
  }
  return std::move(part.surfaces);
}

std::optional<Mesh> Builder::file_mesh(const pb::Visual& visual, const std::string& node) {
  const pb::MeshGeom& from = visual.geometry().mesh();
  glm::dvec3 scale = from.has_scale() ? vector(from.scale()) : glm::dvec3(1);
  if (!is_finite(scale) || scale == glm::dvec3(0)) scale = glm::dvec3(1);
  const Result<std::filesystem::path> file = resources_.find(from.filename());
  if (!file) {
    warn(quote(node) + " has no mesh: " + file.error().message);
    return std::nullopt;
  }
  files_.allow_images_below(resources_.image_folders(*file));
  Result<std::vector<Surface>> surfaces = file_surfaces(from, *file, scale);
  if (!surfaces) {
    warn(quote(node) + " has no mesh: " + quote(file->string()) + ": " + surfaces.error().message);
    return std::nullopt;
  }
  Mesh mesh;
  mesh.name = convert::sanitize_text(file->filename().string(), 256);
  const std::optional<size_t> own =
      visual.has_material() ? std::optional(materials_.of_visual(visual, node)) : std::nullopt;
  for (Surface& surface : *surfaces) {
    surface.material = own ? *own : materials_.with_transparency(surface.material, visual.transparency());
    mesh.surfaces.push_back(std::move(surface));
  }
  return mesh;
}

std::optional<size_t> Builder::mesh_of(const pb::Visual& visual, const std::string& node) {
  if (std::isfinite(visual.transparency()) && visual.transparency() >= 1) return std::nullopt;  // invisible
  std::optional<Mesh> mesh;
  if (!store_.take_shape(Mesh())) {
    warn(quote(node) + " is left out: " + store_.why_full());
    return std::nullopt;
  }
  if (visual.geometry().type() == kMesh) {
    mesh = file_mesh(visual, node);
  } else if (std::optional<Surface> shape = shape_of(visual.geometry(), node)) {
    shape->material = materials_.of_visual(visual, node);
    mesh.emplace();
    mesh->name = convert::sanitize_text(node, 256);
    mesh->surfaces.push_back(std::move(*shape));
  }
  if (!mesh) return std::nullopt;
  return store_.add(std::move(*mesh));
}

void Builder::add_light(const pb::Light& from, std::string name, size_t parent) {
  enum { kPoint, kSpot, kDirectional };
  const float intensity = from.intensity();
  if (from.is_light_off() || !std::isfinite(intensity) || intensity <= 0) return;
  if (from.type() < kPoint || from.type() > kDirectional) {
    warn(quote(name) + " is left out: unknown type of light " + std::to_string(from.type()));
    return;
  }
  convert::Light light;
  light.name = name;
  light.type = from.type() == kDirectional ? convert::Light::Type::directional
               : from.type() == kSpot      ? convert::Light::Type::spot
                                           : convert::Light::Type::point;
  for (int i = 0; i < 3; ++i) {
    const float value = i == 0 ? from.diffuse().r() : i == 1 ? from.diffuse().g() : from.diffuse().b();
    light.color[i] = std::isfinite(value) ? std::clamp(value, 0.0f, 1.0f) : 0;
  }
  // Gazebo's power is intensity * pi, attenuated by 1 / (c + l d + q d^2); glTF's falls off with the square
  // alone.
  const float c = from.attenuation_constant(), l = from.attenuation_linear(),
              q = from.attenuation_quadratic();
  float candela = std::numbers::pi_v<float> * intensity;
  if (from.type() != kDirectional) {
    const float at_1_m = c + l + q;
    if (std::isfinite(at_1_m) && at_1_m > 0) candela /= at_1_m;
  }
  light.intensity = std::min(candela, 1e9f);
  if (from.type() == kSpot) {
    const auto half = [](float angle) {
      return std::isfinite(angle) ? std::clamp(angle / 2, 0.0f, 1.5707f) : 0.0f;
    };
    light.outer_cone_rad = std::max(half(from.spot_outer_angle()), 0.01f);
    light.inner_cone_rad = std::min(half(from.spot_inner_angle()), light.outer_cone_rad - 0.001f);
  }
  glm::dvec3 direction = from.has_direction() ? vector(from.direction()) : glm::dvec3(0, 0, -1);
  if (!is_finite(direction) || glm::length(direction) < 1e-9) direction = glm::dvec3(0, 0, -1);
  convert::Node node;
  node.name = convert::sdf_light_name(name);
  node.parent = parent;
  node.rotation = convert::shining(direction);
  node.light = model_.lights.size();
  model_.lights.push_back(std::move(light));
  model_.nodes.push_back(std::move(node));
}

void Builder::add_camera(const pb::Sensor& from, std::string name, size_t parent) {
  const pb::CameraSensor& sensor = from.camera();
  const double width = sensor.image_size().x(), height = sensor.image_size().y(),
               fov = sensor.horizontal_fov();
  if (!is_size(width) || !is_size(height) || !(fov > 0 && fov < 3.1)) return;
  convert::Camera camera;
  camera.name = name;
  camera.vertical_fov_rad = static_cast<float>(2 * std::atan(std::tan(fov / 2) * height / width));
  camera.aspect = static_cast<float>(width / height);
  if (is_size(sensor.near_clip())) camera.near_m = static_cast<float>(sensor.near_clip());
  if (is_size(sensor.far_clip()) && sensor.far_clip() > sensor.near_clip())
    camera.far_m = static_cast<float>(sensor.far_clip());
  convert::Node node;
  node.name = convert::sdf_view_name(name);
  node.parent = parent;
  const float* m = kSensorFromCamera;
  node.rotation = glm::quat_cast(glm::dmat3(m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]));
  node.camera = model_.cameras.size();
  model_.cameras.push_back(std::move(camera));
  model_.nodes.push_back(std::move(node));
}

}  // namespace

convert::Model scene_model(const std::vector<TopLevel>& items, const Resources& resources,
                           const std::string& name) {
  convert::Model model;
  model.name = convert::sanitize_text(name, 256);
  Builder builder(model, resources);
  for (const TopLevel& item : items) builder.add(item);
  return model;
}

}  // namespace fire3dv::gazebo
