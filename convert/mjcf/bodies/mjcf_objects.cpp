// Objects in bodies: joints, masses, geoms, sites, cameras and lights.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "convert/mjcf/bodies/mjcf_bodies.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kMinLength = 1e-14;

std::optional<MjcfShape> shape_of(const std::string& type) {
  static const std::pair<const char*, MjcfShape> kShapes[] = {
      {"plane", MjcfShape::plane},     {"hfield", MjcfShape::height_field}, {"sphere", MjcfShape::sphere},
      {"capsule", MjcfShape::capsule}, {"ellipsoid", MjcfShape::ellipsoid}, {"cylinder", MjcfShape::cylinder},
      {"box", MjcfShape::box},         {"mesh", MjcfShape::mesh},           {"sdf", MjcfShape::mesh}};
  for (const auto& [name, shape] : kShapes)
    if (type == name) return shape;
  return std::nullopt;
}

std::array<float, 4> rgba_of(const MjcfAttributes& from) {
  const glm::dvec4 rgba = from.vec4("rgba").value_or(glm::dvec4(0.5, 0.5, 0.5, 1));
  return {static_cast<float>(rgba.r), static_cast<float>(rgba.g), static_cast<float>(rgba.b),
          static_cast<float>(rgba.a)};
}

// Pose of a geom or site in its frame; with fromto, the shape's length along Z is set.
MjcfPose shape_pose(const MjcfAttributes& from, const MjcfCompiler& compiler, MjcfShape shape,
                    glm::dvec3& size) {
  const auto ends = from.find("fromto") ? from.numbers("fromto", 6) : std::nullopt;
  if (!ends) return {from.vec3("pos").value_or(glm::dvec3(0)), from.rotation(compiler)};
  const glm::dvec3 first((*ends)[0], (*ends)[1], (*ends)[2]), last((*ends)[3], (*ends)[4], (*ends)[5]);
  const double half = glm::length(first - last) / 2;
  if (shape == MjcfShape::ellipsoid || shape == MjcfShape::box)
    size = {size.x, size.x, half};
  else
    size.y = half;
  const std::optional<glm::dquat> rotation = mjcf_z_rotation(first - last);
  if (!rotation) from.warn("the points of fromto are equal");
  return {0.5 * (first + last), rotation.value_or(glm::dquat(1, 0, 0, 0))};
}

double volume_of(MjcfShape shape, const glm::dvec3& s, bool is_shell) {
  switch (shape) {
    case MjcfShape::sphere:
      return is_shell ? 4 * kPi * s.x * s.x : 4 * kPi * s.x * s.x * s.x / 3;
    case MjcfShape::capsule:
      return is_shell ? 4 * kPi * s.x * (s.x + s.y) : kPi * s.x * s.x * (2 * s.y + 4 * s.x / 3);
    case MjcfShape::cylinder:
      return is_shell ? 2 * kPi * s.x * (s.x + 2 * s.y) : 2 * kPi * s.x * s.x * s.y;
    case MjcfShape::ellipsoid:
      return 4 * kPi * s.x * s.y * s.z / 3;
    case MjcfShape::box:
      return is_shell ? 8 * (s.x * s.y + s.y * s.z + s.z * s.x) : 8 * s.x * s.y * s.z;
    default:
      return 0;
  }
}

double bound_radius(MjcfShape shape, const glm::dvec3& s) {
  switch (shape) {
    case MjcfShape::sphere:
      return s.x;
    case MjcfShape::capsule:
      return s.x + s.y;
    case MjcfShape::cylinder:
      return std::hypot(s.x, s.y);
    case MjcfShape::ellipsoid:
      return std::max({s.x, s.y, s.z});
    case MjcfShape::box:
      return glm::length(s);
    default:
      return 0;
  }
}

int sizes_needed(MjcfShape shape) {
  switch (shape) {
    case MjcfShape::sphere:
      return 1;
    case MjcfShape::capsule:
    case MjcfShape::cylinder:
      return 2;
    case MjcfShape::ellipsoid:
    case MjcfShape::box:
      return 3;
    default:
      return 0;
  }
}

// Limits of a slide or hinge. Without limited="true" or "false", a range is a limit where autolimits holds.
std::optional<glm::dvec2> joint_range(const MjcfAttributes& from, MjcfJoint::Type type,
                                      const MjcfCompiler& compiler) {
  if (type != MjcfJoint::Type::slide && type != MjcfJoint::Type::hinge) return std::nullopt;
  const std::string limited = from.text("limited");
  const bool is_limited = limited == "true" || (limited != "false" && compiler.limits_automatically);
  const std::optional<glm::dvec2> range = is_limited ? from.vec2("range") : std::nullopt;
  if (!range || !(range->x < range->y)) return std::nullopt;
  if (type == MjcfJoint::Type::slide) return range;
  return glm::dvec2(compiler.radians(range->x), compiler.radians(range->y));
}

MjcfTracked tracking_of(const MjcfAttributes& from, const std::string& scoped_target) {
  MjcfTracked tracked;
  const std::string mode = from.text("mode");
  if (mode == "track")
    tracked.mode = MjcfTracking::track;
  else if (mode == "trackcom")
    tracked.mode = MjcfTracking::track_mass;
  else if (mode == "targetbody")
    tracked.mode = MjcfTracking::target_body;
  else if (mode == "targetbodycom")
    tracked.mode = MjcfTracking::target_mass;
  else if (!mode.empty() && mode != "fixed")
    from.warn("mode=" + quote(mode) + " is unknown; fixed is used");
  tracked.target = from.text("target");
  tracked.target_in_scope = scoped_target;
  return tracked;
}

// Numbers of pixels as lengths on the sensor, if there are any; otherwise the lengths.
glm::dvec2 sensor_lengths(const MjcfAttributes& from, const char* in_pixels, const char* in_metres,
                          const glm::dvec2& pixel_m) {
  const glm::dvec2 pixels = from.vec2(in_pixels).value_or(glm::dvec2(0));
  glm::dvec2 lengths = from.vec2(in_metres).value_or(glm::dvec2(0));
  for (int i = 0; i < 2; ++i)
    if (pixels[i] != 0 && pixel_m[i] > 0) lengths[i] = pixels[i] * pixel_m[i];
  return lengths;
}

// Projection of a camera with a sensor. MuJoCo's principal point is to the left and down.
void set_intrinsics(const MjcfAttributes& from, const glm::dvec2& sensor, MjcfCamera& camera) {
  const glm::dvec2 resolution = from.vec2("resolution").value_or(glm::dvec2(0));
  const bool has_pixels = resolution.x > 0 && resolution.y > 0;
  const glm::dvec2 pixel_m = has_pixels ? sensor / resolution : glm::dvec2(0);
  const glm::dvec2 focal = sensor_lengths(from, "focalpixel", "focal", pixel_m);
  if (focal.y > 0) camera.vertical_fov_deg = glm::degrees(2 * std::atan2(sensor.y / 2, focal.y));
  // The image has the shape of the resolution, or without one that of the sensor.
  constexpr double kLeastDifference = 1e-6;  // of rounded numbers
  const double pixel_aspect = has_pixels && resolution.x > 1 && resolution.y > 1 ? pixel_m.x / pixel_m.y : 1;
  if (focal.x > 0 && focal.y > 0) {
    const double aspect = pixel_aspect * focal.y / focal.x;
    if (std::abs(aspect - 1) > kLeastDifference) camera.pixel_aspect = aspect;
  }
  const glm::dvec2 offset = sensor_lengths(from, "principalpixel", "principal", pixel_m);
  camera.principal_point = -offset / (glm::dvec2(pixel_aspect, 1) * sensor.y);
}

void set_projection(const MjcfAttributes& from, MjcfCamera& camera) {
  const double fovy = from.number("fovy", 45);
  if (from.text("projection") == "orthographic" || from.text("orthographic") == "true") {
    if (fovy > 0) {
      camera.height_m = fovy;
      return;
    }
  } else {
    if (fovy > 0 && fovy < 180) camera.vertical_fov_deg = fovy;
    const glm::dvec2 sensor = from.vec2("sensorsize").value_or(glm::dvec2(0));
    if (sensor.x > 0 && sensor.y > 0) return set_intrinsics(from, sensor, camera);
    if (fovy > 0 && fovy < 180) return;
  }
  from.warn("fovy is not between 0 and 180 degrees; 45 is used");
}

}  // namespace

void MjcfBodyReader::read_inertial(const MjcfElement& element, const Scope& scope) {
  const MjcfAttributes from = scope.source->attributes(element, scope.class_index);
  MjcfMass mass;
  mass.add(from.number("mass", 0), scope.frame * from.vec3("pos").value_or(glm::dvec3(0)));
  tree_.bodies[scope.body].given_mass = mass;
}

void MjcfBodyReader::read_joint(const MjcfElement& element, const Scope& scope) {
  if (scope.body == 0) {
    scope.source->messages().warn(element.where() + " is ignored: the world has no joints");
    return;
  }
  MjcfJoint joint;
  if (element.kind == "freejoint") {
    joint.type = MjcfJoint::Type::free;
    joint.name = scope.name(element.text("name"));
  } else {
    const MjcfCompiler& compiler = scope.source->compiler();
    const MjcfAttributes from =
        scope.source->attributes(element, scope.source->class_of(element, scope.class_index));
    const std::string type = from.text("type");
    joint.type = type == "free"    ? MjcfJoint::Type::free
                 : type == "ball"  ? MjcfJoint::Type::ball
                 : type == "slide" ? MjcfJoint::Type::slide
                                   : MjcfJoint::Type::hinge;
    if (joint.type == MjcfJoint::Type::hinge && !type.empty() && type != "hinge")
      from.warn("type=" + quote(type) + " is unknown; hinge is used");
    joint.position = scope.frame * from.vec3("pos").value_or(glm::dvec3(0));
    const glm::dvec3 axis = from.vec3("axis").value_or(glm::dvec3(0, 0, 1));
    if (glm::length(axis) > kMinLength) joint.axis = scope.frame.rotation * glm::normalize(axis);
    joint.name = scope.name(from.name());
    joint.reference = from.number("ref", 0);
    joint.range = joint_range(from, joint.type, compiler);
    if (joint.type == MjcfJoint::Type::hinge) joint.reference = compiler.radians(joint.reference);
  }
  if (joint.type == MjcfJoint::Type::free) joint.position = glm::dvec3(0);
  tree_.bodies[scope.body].joints.push_back(joint);
}

// Takes the mesh of a geom as its shape, or fits a primitive to it. Returns false where the geom is left out.
bool MjcfBodyReader::shape_mesh(const MjcfAttributes& from, const Scope& scope, MjcfTreeGeom& made,
                                MjcfPose& mass_pose, double& volume) {
  const MjcfMeshAsset* const asset = scope.source->mesh(from.text("mesh"), from.element(), assets_);
  if (!asset) return false;
  const MjcfMesh& mesh = *asset->mesh;
  mass_pose = made.geom.pose * mesh.inertia_pose;
  if (made.geom.shape == MjcfShape::mesh) {
    made.geom.data = asset->index;
    made.bound_radius = mesh.bound_radius;
    volume = mesh.volume;
    if (!made.geom.material && asset->element->find("material"))
      made.geom.material = scope.source->material(asset->element->text("material"), *asset->element, assets_);
    return true;
  }
  const glm::dvec3 scale(from.number("fitscale", 1));
  const MjcfFit fit = fit_mjcf_mesh(mesh, made.geom.shape, scope.source->compiler().fits_bounds);
  made.geom.size = fit.size * scale;
  made.geom.pose = mass_pose * MjcfPose{fit.centre, glm::dquat(1, 0, 0, 0)};
  mass_pose = made.geom.pose;
  return true;
}

void MjcfBodyReader::read_geom(const MjcfElement& element, const Scope& scope) {
  MjcfSource& source = *scope.source;
  const MjcfAttributes from = source.attributes(element, source.class_of(element, scope.class_index));
  const MjcfCompiler& compiler = source.compiler();
  if (compiler.discards_visual && from.integer("contype", 1) == 0 && from.integer("conaffinity", 1) == 0)
    return;
  MjcfTreeGeom made;
  MjcfGeom& geom = made.geom;
  const std::string type = from.text("type");
  const std::optional<MjcfShape> shape = type.empty() ? MjcfShape::sphere : shape_of(type);
  if (!shape) {
    from.warn("is left out: type=" + quote(type) + " is unknown");
    return;
  }
  geom.name = scope.name(from.name());
  geom.body = scope.body;
  geom.shape = *shape;
  geom.group = from.integer("group", 0);
  geom.rgba = rgba_of(from);
  if (const std::string material = from.text("material"); !material.empty())
    geom.material = source.material(material, element, assets_);
  geom.size = from.size(glm::dvec3(0));
  geom.pose = scope.frame * shape_pose(from, compiler, *shape, geom.size);
  MjcfPose mass_pose = geom.pose;
  double volume = 0;
  if (geom.shape == MjcfShape::mesh || !from.text("mesh").empty()) {
    if (!shape_mesh(from, scope, made, mass_pose, volume)) return;
  } else if (geom.shape == MjcfShape::height_field) {
    geom.data = source.height_field(from.text("hfield"), element, assets_);
    if (!geom.data) return;
    const MjcfHeightField& field = *assets_.height_fields[*geom.data];
    made.bound_radius = glm::length(glm::dvec3(field.half, std::max(field.height, field.base)));
  }
  for (int i = 0; i < sizes_needed(geom.shape); ++i) {
    if (geom.size[i] > 0) continue;
    from.warn("is left out: its size has too few positive numbers");
    return;
  }
  if (geom.shape != MjcfShape::mesh) {
    if (geom.shape != MjcfShape::height_field) made.bound_radius = bound_radius(geom.shape, geom.size);
    volume = volume_of(geom.shape, geom.size, from.text("shellinertia") == "true");
  }
  made.bound_centre = mass_pose.position;
  if (geom.group >= compiler.first_inertia_group && geom.group <= compiler.last_inertia_group)
    tree_.bodies[scope.body].geom_mass.add(from.number("mass", from.number("density", 1000) * volume),
                                           mass_pose.position);
  tree_.bodies[scope.body].takes_geom_mass = compiler.inertia_from_geom == MjcfCompiler::InertiaFromGeom::yes;
  tree_.geoms.push_back(std::move(made));
}

void MjcfBodyReader::read_site(const MjcfElement& element, const Scope& scope) {
  MjcfSource& source = *scope.source;
  const MjcfAttributes from = source.attributes(element, source.class_of(element, scope.class_index));
  glm::dvec3 size(0);
  const MjcfPose pose =
      scope.frame *
      shape_pose(from, source.compiler(), shape_of(from.text("type")).value_or(MjcfShape::sphere), size);
  if (const std::string name = scope.name(from.name()); !name.empty())
    tree_.site_index.emplace(name, tree_.sites.size());
  tree_.sites.push_back({scope.body, pose});
}

void MjcfBodyReader::read_camera(const MjcfElement& element, const Scope& scope) {
  MjcfSource& source = *scope.source;
  const MjcfAttributes from = source.attributes(element, source.class_of(element, scope.class_index));
  MjcfCamera camera;
  camera.name = scope.name(from.name());
  camera.body = scope.body;
  camera.world_pose =
      scope.frame * MjcfPose{from.vec3("pos").value_or(glm::dvec3(0)), from.rotation(source.compiler())};
  set_projection(from, camera);
  tree_.cameras.push_back(std::move(camera));
  tree_.camera_tracking.push_back(tracking_of(from, scope.name(from.text("target"))));
}

void MjcfBodyReader::read_light(const MjcfElement& element, const Scope& scope) {
  MjcfSource& source = *scope.source;
  const MjcfAttributes from = source.attributes(element, source.class_of(element, scope.class_index));
  MjcfLight light;
  light.name = scope.name(from.name());
  light.body = scope.body;
  light.position = scope.frame * from.vec3("pos").value_or(glm::dvec3(0));
  const glm::dvec3 direction = from.vec3("dir").value_or(glm::dvec3(0, 0, -1));
  light.direction =
      glm::length(direction) > kMinLength ? scope.frame.rotation * glm::normalize(direction) : glm::dvec3(0);
  light.diffuse = from.vec3("diffuse").value_or(glm::dvec3(0.7));
  light.is_active = from.flag("active", true);
  light.cutoff_deg = from.number("cutoff", 45);
  const std::string type = from.text("type");
  if (type == "directional" || (type.empty() && from.flag("directional", false)))
    light.type = Light::Type::directional;
  else if (type == "point" || light.cutoff_deg > 90)
    light.type = Light::Type::point;
  if (type == "image") {
    light.is_active = false;
    from.warn("image lights are not shown");
  }
  tree_.lights.push_back(std::move(light));
  tree_.light_tracking.push_back(tracking_of(from, scope.name(from.text("target"))));
}

}  // namespace fire3dv::convert
