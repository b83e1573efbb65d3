#include "tools/convert/adf/adf_model.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

using Kind = AdfObject::Kind;

std::string single_slashes(const std::string& text) {
  std::string single;
  for (const char c : text)
    if (c != '/' || single.empty() || single.back() != '/') single += c;
  return single;
}

// Returns namespace and block id. An absolute namespace of the block replaces the file's.
std::string identifier_of(const AdfFile& file, const AdfFile::Block& block, const AdfReading& reading) {
  const std::string outer = single_slashes(file["namespace"].text()),
                    own = single_slashes(block.value["namespace"].text());
  return reading.name_prefix + (own.starts_with('/') ? own : outer + own) + block.id;
}

// R = Rz(yaw) Ry(pitch) Rx(roll)
glm::dquat rotation_of(const AdfValue& orientation) {
  const glm::dvec3 rpy = orientation.vector(glm::dvec3(0), "rpy");
  return glm::angleAxis(rpy.z, glm::dvec3(0, 0, 1)) * glm::angleAxis(rpy.y, glm::dvec3(0, 1, 0)) *
         glm::angleAxis(rpy.x, glm::dvec3(1, 0, 0));
}

AdfObject object_of(Kind kind, const AdfFile& file, const AdfFile::Block& block, const AdfReading& reading) {
  AdfObject object;
  object.kind = kind;
  object.identifier = identifier_of(file, block, reading);
  object.place = block.value.place();
  if (kind != Kind::body && kind != Kind::soft_body) object.parent = block.value["parent"].text();
  file.note_unknown_fields(block.value);
  return object;
}

bool read_bodies(const AdfFile& file, const char* list, Kind kind, AdfReading& reading) {
  const AdfSearchPaths places{file.folder(), file["high resolution path"].text()};
  for (const AdfFile::Block& block : file.blocks(list)) {
    AdfObject object = object_of(kind, file, block, reading);
    const AdfValue location = block.value["location"];
    object.translation = location["position"].vector(glm::dvec3(0));
    object.rotation = rotation_of(location["orientation"]);
    const AdfAppearance appearance = reading.visuals.appearance_of(block.value, block.id, places);
    object.mesh = appearance.mesh;
    object.dropped_by_ambf = appearance.mesh_is_missing;
    if (!reading.objects.add(std::move(object))) return false;
  }
  return true;
}

bool read_cameras(const AdfFile& file, AdfReading& reading) {
  for (const AdfFile::Block& block : file.blocks("cameras")) {
    AdfObject object = object_of(Kind::camera, file, block, reading);
    const AdfValue& b = block.value;
    object.translation = b["location"].vector(glm::dvec3(0));
    const auto rotation = adf_camera_rotation(object.translation, b["look at"].vector(glm::dvec3(0)),
                                              b["up"].vector(glm::dvec3(0, 0, 1)));
    if (rotation)
      object.rotation = *rotation;
    else
      b.warn("its \"look at\" equals its position or lies along its \"up\": its direction is undefined");

    const double fov = b["field view angle"].number(0.7);
    object.camera.vertical_fov_rad = static_cast<float>(std::clamp(fov, 0.01, 3.1));
    if (fov < 0.01 || fov > 3.1) b["field view angle"].warn("is no angle that a camera can have");
    double near = b["clipping plane"]["near"].number(0.1), far = b["clipping plane"]["far"].number(10);
    if (!(near >= 1e-6 && far > near && far <= 1e9)) {
      b["clipping plane"].warn("does not hold 0 < near < far; taken as 0.1 and 10");
      near = 0.1;
      far = 10;
    }
    object.camera.near_m = static_cast<float>(near);
    object.camera.far_m = static_cast<float>(far);
    if (b["orthographic view width"].is_defined())
      b["orthographic view width"].warn(
          "requests an orthographic camera; it is converted to a perspective one");
    if (b["stereo"].is_map()) object.eye_separation_m = b["stereo"]["eye separation"].number(0.2);
    if (!reading.objects.add(std::move(object))) return false;
  }
  return true;
}

bool read_lights(const AdfFile& file, AdfReading& reading) {
  for (const AdfFile::Block& block : file.blocks("lights")) {
    AdfObject object = object_of(Kind::light, file, block, reading);
    const AdfValue& b = block.value;
    object.translation = b["location"].vector(glm::dvec3(0));
    const AdfValue direction = b["direction"];
    if (const auto rotation = adf_light_rotation(direction.vector(glm::dvec3(0))))
      object.rotation = *rotation;
    else
      b.warn("has no \"direction\"; it shines along X, as in AMBF");
    // AMBF's approximate conversion to degrees, and the limit of its library.
    const double half_angle_deg = std::clamp(b["cutoff angle"].number(0.7) * (180 / 3.14), 0.5, 90.0);
    object.light.type = Light::Type::spot;
    object.light.outer_cone_rad = static_cast<float>(glm::radians(half_angle_deg));
    // AMBF's cone edge is hard; glTF needs a non-zero width.
    object.light.inner_cone_rad = 0.97f * object.light.outer_cone_rad;
    const AdfValue attenuation = b["attenuation"];
    object.attenuation = {attenuation["constant"].number(1), attenuation["linear"].number(0),
                          attenuation["quadratic"].number(0)};
    if (!reading.objects.add(std::move(object))) return false;
  }
  return true;
}

void warn_about_ignored_fields(const AdfFile& file, std::initializer_list<const char*> lists) {
  for (const char* list : lists) {
    const AdfValue value = file[list];
    if (value.is_map() || !value.items().empty()) value.warn("is not converted");
  }
}

}  // namespace

bool read_adf_model(const AdfFile& file, AdfReading& reading) {
  file.note_unknown_fields();
  reading.visuals.allow_images_below(file.folder());
  warn_about_ignored_fields(file, {"vehicles", "volumes"});
  return read_bodies(file, "bodies", Kind::body, reading) &&
         read_bodies(file, "soft bodies", Kind::soft_body, reading) &&
         read_bodies(file, "ghost objects", Kind::ghost, reading) && read_cameras(file, reading) &&
         read_lights(file, reading);
}

bool read_adf_world(const AdfFile& file, AdfReading& reading) {
  file.note_unknown_fields();
  warn_about_ignored_fields(file, {"skybox"});
  return read_lights(file, reading) && read_cameras(file, reading);
}

}  // namespace fire3dv::convert
