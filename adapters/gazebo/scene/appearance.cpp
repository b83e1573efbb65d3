#include "adapters/gazebo/scene/appearance.h"

#include <glm/glm.hpp>

namespace fire3dv::gazebo {
namespace {

using convert::SdfLight;
using convert::SdfMaterial;
using convert::SdfShape;
using convert::SdfUri;

// Geometry.Type of Gazebo's messages.
enum GeometryType {
  kBox = 0,
  kCylinder = 1,
  kSphere = 2,
  kPlane = 3,
  kHeightmap = 5,
  kMesh = 6,
  kPolyline = 9,
  kCone = 10,
  kEmpty = 11,
  kCapsule = 14,
  kEllipsoid = 15
};

glm::dvec3 vector(const pb::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

glm::vec3 rgb(const pb::Color& color) {
  return {color.r(), color.g(), color.b()};
}

SdfShape shape_of(SdfShape::Type type, const glm::dvec3& size) {
  SdfShape shape;
  shape.type = type;
  shape.size = size;
  return shape;
}

SdfShape round_shape(SdfShape::Type type, const pb::CylinderGeom& from) {
  return shape_of(type, {from.radius(), from.length(), 0});
}

}  // namespace

std::optional<SdfShape> sdf_shape(const pb::Geometry& geometry, const std::string& where,
                                  std::vector<std::string>& warnings) {
  using Type = SdfShape::Type;
  switch (geometry.type()) {
    case kBox:
      return shape_of(Type::box, vector(geometry.box().size()));
    case kCylinder:
      return round_shape(Type::cylinder, geometry.cylinder());
    case kCone:
      return round_shape(Type::cone, geometry.cone());
    case kCapsule:
      return round_shape(Type::capsule, geometry.capsule());
    case kSphere:
      return shape_of(Type::sphere, {geometry.sphere().radius(), 0, 0});
    case kEllipsoid:
      return shape_of(Type::ellipsoid, vector(geometry.ellipsoid().radii()));
    case kPlane: {
      const pb::PlaneGeom& plane = geometry.plane();
      SdfShape shape = shape_of(Type::plane, {plane.size().x(), plane.size().y(), 0});
      if (plane.has_normal()) shape.normal = vector(plane.normal());
      return shape;
    }
    case kPolyline: {
      SdfShape shape;
      shape.type = Type::polyline;
      for (const pb::Polyline& line : geometry.polyline()) {
        SdfShape::Polyline made;
        made.height = line.height();
        for (const pb::Vector2d& point : line.point()) made.points.emplace_back(point.x(), point.y());
        shape.polylines.push_back(std::move(made));
      }
      return shape;
    }
    case kMesh: {
      const pb::MeshGeom& mesh = geometry.mesh();
      SdfShape shape = shape_of(Type::mesh, mesh.has_scale() ? vector(mesh.scale()) : glm::dvec3(1));
      shape.mesh.uri = mesh.filename();
      shape.submesh = mesh.submesh();
      shape.is_centred = mesh.center_submesh();
      return shape;
    }
    case kEmpty:
      return std::nullopt;
    default:
      warnings.push_back(where + " is left out: geometries of type " + std::to_string(geometry.type()) +
                         (geometry.type() == kHeightmap ? " (heightmap)" : "") +
                         " are not drawn; use a mesh");
      return std::nullopt;
  }
}

SdfMaterial sdf_material(const pb::Material& from, const std::string& where,
                         std::vector<std::string>& warnings) {
  enum { kNone, kMetal, kSpecular };
  SdfMaterial made;
  if (from.has_diffuse()) made.diffuse = glm::vec4(rgb(from.diffuse()), from.diffuse().a());
  made.specular = rgb(from.specular());
  made.emissive = rgb(from.emissive());
  made.script = from.script().name();
  made.is_double_sided = from.double_sided();
  made.normal_map.uri = from.normal_map();
  if (!from.has_pbr() || from.pbr().type() == kNone) return made;
  const pb::Material::Pbr& pbr = from.pbr();
  made.is_pbr = true;
  made.albedo_map.uri = pbr.albedo_map();
  made.normal_map.uri = pbr.normal_map();
  made.occlusion_map.uri = pbr.ambient_occlusion_map();
  made.emissive_map.uri = pbr.emissive_map();
  if (!pbr.light_map().empty()) warnings.push_back(where + ": its <light_map> is not used");
  if (pbr.type() == kSpecular) {
    made.metalness = 0;
    made.roughness = static_cast<float>(1 - pbr.glossiness());
    return made;
  }
  made.metalness = static_cast<float>(pbr.metalness());
  made.roughness = static_cast<float>(pbr.roughness());
  made.metalness_map.uri = pbr.metalness_map();
  made.roughness_map.uri = pbr.roughness_map();
  return made;
}

std::optional<SdfLight> sdf_light(const pb::Light& from, const std::string& where,
                                  std::vector<std::string>& warnings) {
  enum { kPoint, kSpot, kDirectional };
  SdfLight made;
  switch (from.type()) {
    case kPoint:
      made.type = convert::Light::Type::point;
      break;
    case kSpot:
      made.type = convert::Light::Type::spot;
      break;
    case kDirectional:
      made.type = convert::Light::Type::directional;
      break;
    default:
      warnings.push_back(where + " is left out: unknown type of light " + std::to_string(from.type()));
      return std::nullopt;
  }
  made.diffuse = rgb(from.diffuse());
  made.intensity = static_cast<double>(from.intensity());
  made.is_off = from.is_light_off();
  made.constant = static_cast<double>(from.attenuation_constant());
  made.linear = static_cast<double>(from.attenuation_linear());
  made.quadratic = static_cast<double>(from.attenuation_quadratic());
  if (from.has_direction()) made.direction = vector(from.direction());
  made.inner_angle_rad = static_cast<double>(from.spot_inner_angle());
  made.outer_angle_rad = static_cast<double>(from.spot_outer_angle());
  return made;
}

convert::SdfCamera sdf_camera(const pb::CameraSensor& from) {
  convert::SdfCamera made;
  made.horizontal_fov_rad = from.horizontal_fov();
  made.width = from.image_size().x();
  made.height = from.image_size().y();
  made.near_m = from.near_clip();
  made.far_m = from.far_clip();
  return made;
}

}  // namespace fire3dv::gazebo
