#include "convert/sdf/library/sdf_appearance.h"

#include <sdf/Box.hh>
#include <sdf/Capsule.hh>
#include <sdf/Cylinder.hh>
#include <sdf/Element.hh>
#include <sdf/Ellipsoid.hh>
#include <sdf/Mesh.hh>
#include <sdf/Pbr.hh>
#include <sdf/Plane.hh>
#include <sdf/Sphere.hh>

#include "base/text.h"
#include "convert/sdf/library/sdf_values.h"

namespace fire3dv::convert {
namespace {

SdfShape shape_of(SdfShape::Type type, const glm::dvec3& size) {
  SdfShape shape;
  shape.type = type;
  shape.size = size;
  return shape;
}

// Numbers of an element that this libsdformat does not know: SDF 1.11 has cones.
double number(const sdf::ElementPtr& element, const char* name, double otherwise) {
  const sdf::ElementPtr child = element->FindElement(name);
  return child ? child->Get<double>("", otherwise).first : otherwise;
}

SdfShape polylines(const sdf::ElementPtr& geometry) {
  SdfShape shape;
  shape.type = SdfShape::Type::polyline;
  for (sdf::ElementPtr line = geometry->FindElement("polyline"); line;
       line = line->GetNextElement("polyline")) {
    SdfShape::Polyline made;
    made.height = number(line, "height", 1);
    for (sdf::ElementPtr point = line->FindElement("point"); point; point = point->GetNextElement("point"))
      made.points.push_back(vec2(point->Get<ignition::math::Vector2d>()));
    shape.polylines.push_back(std::move(made));
  }
  return shape;
}

std::optional<SdfShape> shape_of_element(const sdf::Geometry& geometry, const std::string& where,
                                         std::vector<std::string>& warnings) {
  const sdf::ElementPtr element = geometry.Element();
  if (!element) return std::nullopt;
  if (element->FindElement("polyline")) return polylines(element);
  if (const sdf::ElementPtr cone = element->FindElement("cone"))
    return shape_of(SdfShape::Type::cone, {number(cone, "radius", 0.5), number(cone, "length", 1), 0});
  if (element->FindElement("empty")) return std::nullopt;
  const sdf::ElementPtr first = element->GetFirstElement();
  warnings.push_back(where + ": its <geometry> is " +
                     (first ? "a <" + printable_text(first->GetName(), 100) + ">, which is not drawn"
                            : std::string("empty")) +
                     "; use a mesh");
  return std::nullopt;
}

}  // namespace

std::optional<SdfShape> sdf_shape(const sdf::Geometry& geometry, const SdfDocuments& documents,
                                  const std::string& where, std::vector<std::string>& warnings) {
  using Type = SdfShape::Type;
  switch (geometry.Type()) {
    case sdf::GeometryType::BOX:
      return shape_of(Type::box, vec3(geometry.BoxShape()->Size()));
    case sdf::GeometryType::SPHERE:
      return shape_of(Type::sphere, {geometry.SphereShape()->Radius(), 0, 0});
    case sdf::GeometryType::CYLINDER:
      return shape_of(Type::cylinder,
                      {geometry.CylinderShape()->Radius(), geometry.CylinderShape()->Length(), 0});
    case sdf::GeometryType::CAPSULE:
      return shape_of(Type::capsule,
                      {geometry.CapsuleShape()->Radius(), geometry.CapsuleShape()->Length(), 0});
    case sdf::GeometryType::ELLIPSOID:
      return shape_of(Type::ellipsoid, vec3(geometry.EllipsoidShape()->Radii()));
    case sdf::GeometryType::PLANE: {
      SdfShape shape = shape_of(Type::plane, glm::dvec3(vec2(geometry.PlaneShape()->Size()), 0));
      shape.normal = vec3(geometry.PlaneShape()->Normal());
      return shape;
    }
    case sdf::GeometryType::MESH: {
      const sdf::Mesh& mesh = *geometry.MeshShape();
      SdfShape shape = shape_of(Type::mesh, vec3(mesh.Scale()));
      shape.mesh = {mesh.Uri(), documents.original(mesh.FilePath())};
      shape.submesh = mesh.Submesh();
      shape.is_centred = mesh.CenterSubmesh();
      return shape;
    }
    case sdf::GeometryType::HEIGHTMAP:
      warnings.push_back(where + ": its <heightmap> is not drawn; use a mesh");
      return std::nullopt;
    case sdf::GeometryType::EMPTY:
      break;
  }
  return shape_of_element(geometry, where, warnings);
}

SdfMaterial sdf_material(const sdf::Material& from, const SdfDocuments& documents, const std::string& where,
                         std::vector<std::string>& warnings) {
  SdfMaterial made;
  made.diffuse = vec4(from.Diffuse());
  // gz-sim has no ambient colours; with one alone, which Gazebo Classic shows, all would be black.
  const sdf::ElementPtr element = from.Element();
  if (element && !element->HasElement("diffuse") && element->HasElement("ambient") && !from.PbrMaterial())
    made.diffuse = vec4(from.Ambient());
  made.specular = glm::vec3(vec4(from.Specular()));
  made.emissive = glm::vec3(vec4(from.Emissive()));
  made.script = from.ScriptName();
  made.is_double_sided = from.DoubleSided();
  const std::filesystem::path file = documents.original(from.FilePath());
  if (!from.NormalMap().empty()) made.normal_map = {from.NormalMap(), file};
  const sdf::Pbr* pbr = from.PbrMaterial();
  if (!pbr) return made;
  const sdf::PbrWorkflow* metal = pbr->Workflow(sdf::PbrWorkflowType::METAL);
  const sdf::PbrWorkflow* any = metal ? metal : pbr->Workflow(sdf::PbrWorkflowType::SPECULAR);
  if (!any) return made;
  made.is_pbr = true;
  const auto map = [&](const std::string& uri) { return SdfUri{uri, file}; };
  made.albedo_map = map(any->AlbedoMap());
  made.normal_map = map(any->NormalMap());
  made.occlusion_map = map(any->AmbientOcclusionMap());
  made.emissive_map = map(any->EmissiveMap());
  if (!any->LightMap().empty()) warnings.push_back(where + ": its <light_map> is not used");
  if (!any->NormalMap().empty() && any->NormalMapType() == sdf::NormalMapSpace::OBJECT) {
    warnings.push_back(where + ": its <normal_map> of type object is left out: bake one of type tangent");
    made.normal_map = {};
  }
  if (!metal) {
    warnings.push_back(where + ": <specular> of <pbr> is not read; use <metal>");
    made.metalness = 0;
    made.roughness = static_cast<float>(1 - any->Glossiness());
    return made;
  }
  made.metalness = static_cast<float>(metal->Metalness());
  made.roughness = static_cast<float>(metal->Roughness());
  made.metalness_map = map(metal->MetalnessMap());
  made.roughness_map = map(metal->RoughnessMap());
  return made;
}

SdfLight sdf_light(const sdf::Light& from) {
  SdfLight made;
  switch (from.Type()) {
    case sdf::LightType::DIRECTIONAL:
      made.type = Light::Type::directional;
      break;
    case sdf::LightType::SPOT:
      made.type = Light::Type::spot;
      break;
    default:
      made.type = Light::Type::point;
  }
  made.diffuse = glm::vec3(vec4(from.Diffuse()));
  made.intensity = from.Intensity();
  made.constant = from.ConstantAttenuationFactor();
  made.linear = from.LinearAttenuationFactor();
  made.quadratic = from.QuadraticAttenuationFactor();
  made.direction = vec3(from.Direction());
  made.inner_angle_rad = from.SpotInnerAngle().Radian();
  made.outer_angle_rad = from.SpotOuterAngle().Radian();
  return made;
}

SdfCamera sdf_camera(const sdf::Camera& from, const std::string& where, std::vector<std::string>& warnings) {
  SdfCamera made;
  if (is_sound(from.RawPose())) {
    made.translation = vec3(from.RawPose().Pos());
    made.rotation = quat(from.RawPose().Rot());
  }
  made.horizontal_fov_rad = from.HorizontalFov().Radian();
  made.width = from.ImageWidth();
  made.height = from.ImageHeight();
  made.near_m = from.NearClip();
  made.far_m = from.FarClip();
  if (from.HasLensIntrinsics()) {
    made.focal_px = glm::dvec2(from.LensIntrinsicsFx(), from.LensIntrinsicsFy());
    const glm::dvec2 off(from.LensIntrinsicsCx() - made.width / 2, from.LensIntrinsicsCy() - made.height / 2);
    // Centred cameras are written with the centre of the image or of its middle pixel.
    constexpr double kCentred_px = 1;
    if (std::max(std::abs(off.x), std::abs(off.y)) > kCentred_px) made.principal_px = off;
  }
  const bool is_distorted = from.DistortionK1() != 0 || from.DistortionK2() != 0 ||
                            from.DistortionK3() != 0 || from.DistortionP1() != 0 || from.DistortionP2() != 0;
  if (is_distorted) warnings.push_back(where + ": its <distortion> is not drawn");
  return made;
}

}  // namespace fire3dv::convert
