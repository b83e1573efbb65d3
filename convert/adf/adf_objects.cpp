#include "convert/adf/adf_objects.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <limits>

#include "convert/model.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

constexpr size_t kMaxObjects = 20'000, kMaxComparisons = 20'000'000;

// Rotations from glTF's axes (view and light along -Z, +Y up) to AMBF's: cameras look along -X with +Z up,
// lights shine along +X.
const glm::dquat kCameraFromView = glm::quat_cast(glm::dmat3(0, 1, 0, 0, 0, 1, 1, 0, 0));
const glm::dquat kLightFromShine = glm::quat_cast(glm::dmat3(0, -1, 0, 0, 0, 1, -1, 0, 0));

// Linear radiance of a white surface that faces an AMBF light. AMBF displays 0.9: 0.7 diffuse plus about 0.2
// ambient (0.4 of a material's ambient colour, mostly half its diffuse). glTF lights have no ambient term.
constexpr double kFacingRadiance = 0.787;

const char* suffix_of(AdfObject::Kind kind) {
  switch (kind) {
    case AdfObject::Kind::body:
      return "#body";
    case AdfObject::Kind::soft_body:
      return "#soft";
    case AdfObject::Kind::ghost:
      return "#ghost";
    case AdfObject::Kind::camera:
      return "#camera";
    case AdfObject::Kind::light:
      return "#light";
  }
  return "";
}

}  // namespace

std::optional<glm::dquat> adf_camera_rotation(const glm::dvec3& position, const glm::dvec3& look_at,
                                              const glm::dvec3& up) {
  const glm::dvec3 back = position - look_at;
  if (!(glm::length(back) > 1e-5) || !(glm::length(up) > 1e-5)) return std::nullopt;
  const glm::dvec3 x = glm::normalize(back);
  const glm::dvec3 right = glm::cross(glm::normalize(up), x);
  if (!(glm::length(right) > 1e-5)) return std::nullopt;
  const glm::dvec3 y = glm::normalize(right);
  return glm::quat_cast(glm::dmat3(x, y, glm::cross(x, y)));
}

std::optional<glm::dquat> adf_light_rotation(const glm::dvec3& direction) {
  if (!(glm::dot(direction, direction) >= 0.0001)) return std::nullopt;
  const glm::dvec3 x = glm::normalize(direction);
  // Y or Z, whichever is farther from the direction.
  const glm::dvec3 other_axis = std::abs(x.z) < std::abs(x.y) ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
  const glm::dvec3 y = glm::normalize(glm::cross(x, other_axis));
  return glm::quat_cast(glm::dmat3(x, y, glm::cross(x, y)));
}

bool AdfObjects::add(AdfObject object) {
  if (objects_.size() >= kMaxObjects) {
    report_.warn(object.location + ": this and further objects are left out: there are more than " +
                 std::to_string(kMaxObjects));
    return false;
  }
  objects_.push_back(std::move(object));
  return true;
}

void AdfObjects::find_names() {
  // AMBF has a map per kind and appends the first free number, from 1, to a duplicate name. Objects that AMBF
  // drops are named last.
  std::map<std::pair<AdfObject::Kind, std::string>, size_t> next_number;
  std::set<std::pair<AdfObject::Kind, std::string>> taken;
  std::set<std::string> all;
  names_.assign(objects_.size(), {});
  for (const bool dropped : {false, true}) {
    for (size_t i = 0; i < objects_.size(); ++i) {
      const AdfObject& object = objects_[i];
      if (object.dropped_by_ambf != dropped) continue;
      const std::string clean = sanitize_text(object.identifier);
      std::string name = clean;
      size_t& number = next_number[{object.kind, clean}];  // truncated names may collide only afterwards
      for (; !taken.emplace(object.kind, name).second; name = clean + std::to_string(number)) ++number;
      if (!all.insert(name).second) {
        const std::string first = name;
        do name += suffix_of(object.kind);
        while (!all.insert(name).second);
        report_.warn(object.location + ": an object of another kind is called " + quote(first) +
                     " too; this one's node is " + quote(name));
      }
      names_[i] = std::move(name);
    }
  }
}

std::optional<size_t> AdfObjects::parent_of(size_t child) const {
  const std::string& name = objects_[child].parent;
  // AMBF searches the maps filled so far: the exact name, else the only name that contains it. Exactly one
  // map must match.
  std::optional<size_t> answer;
  size_t answers = 0;
  for (const auto kind : {AdfObject::Kind::body, AdfObject::Kind::soft_body, AdfObject::Kind::ghost,
                          AdfObject::Kind::camera, AdfObject::Kind::light}) {
    std::optional<size_t> exact, part;
    size_t parts = 0;
    for (size_t i = 0; i < child; ++i) {
      if (objects_[i].kind != kind) continue;
      if (names_[i] == name) exact = i;
      if (names_[i].find(name) == std::string::npos) continue;
      part = i;
      ++parts;
    }
    if (!exact && parts != 1) continue;
    answer = exact ? exact : part;
    ++answers;
  }
  if (answers == 1) return answer;
  // Otherwise: the first later object whose name contains it.
  for (size_t i = child + 1; i < objects_.size(); ++i)
    if (objects_[i].identifier.find(name) != std::string::npos) return i;
  return std::nullopt;
}

void AdfObjects::find_parents() {
  parents_.assign(objects_.size(), std::nullopt);
  size_t comparisons = 0;
  for (size_t i = 0; i < objects_.size(); ++i) {
    if (objects_[i].parent.empty()) continue;
    comparisons += objects_.size();
    if (comparisons <= kMaxComparisons) parents_[i] = parent_of(i);
    if (!parents_[i]) {
      report_.warn(objects_[i].location + ": " + quote(names_[i]) + " has the parent " +
                   quote(objects_[i].parent) + ", which is not there; its pose is taken as in the world");
    }
  }
}

void AdfObjects::drop_loops() {
  std::vector<size_t> walk_of(objects_.size(), 0);
  for (size_t start = 0; start < objects_.size(); ++start) {
    size_t at = start;
    while (walk_of[at] == 0 && parents_[at]) {
      walk_of[at] = start + 1;
      at = *parents_[at];
    }
    if (walk_of[at] == 0) walk_of[at] = start + 1;
    if (!parents_[at] || walk_of[at] != start + 1) continue;
    report_.warn(objects_[at].location + ": " + quote(names_[at]) +
                 " is among its own parents' parents; its pose is taken as in the world");
    parents_[at].reset();
  }
}

glm::dmat4 AdfObjects::world_from(size_t object) const {
  glm::dmat4 world_from_object(1);
  for (std::optional<size_t> at = object; at; at = parents_[*at]) {
    glm::dmat4 parent_from = glm::mat4_cast(objects_[*at].rotation);
    parent_from[3] = glm::dvec4(objects_[*at].translation, 1);
    world_from_object = parent_from * world_from_object;
  }
  return world_from_object;
}

// Median centre of the meshes; large planes and outliers do not shift it.
glm::dvec3 AdfObjects::center(const Model& model) const {
  std::vector<glm::dvec3> centres;
  for (const Mesh& mesh : model.meshes) {
    glm::vec3 low(std::numeric_limits<float>::max()), high(std::numeric_limits<float>::lowest());
    for (const Surface& surface : mesh.surfaces)
      for (const glm::vec3& p : surface.positions) low = glm::min(low, p), high = glm::max(high, p);
    centres.push_back(0.5 * (glm::dvec3(low) + glm::dvec3(high)));
  }
  std::vector<double> along[3];
  for (size_t i = 0; i < objects_.size(); ++i) {
    if (!objects_[i].mesh || objects_[i].kind == AdfObject::Kind::ghost) continue;
    const glm::dvec3 at(world_from(i) * glm::dvec4(centres[*objects_[i].mesh], 1));
    for (int k = 0; k < 3; ++k) along[k].push_back(at[k]);
  }
  glm::dvec3 median(0);
  for (int k = 0; k < 3; ++k) {
    if (along[k].empty()) continue;
    const auto half = along[k].begin() + static_cast<std::ptrdiff_t>(along[k].size() / 2);
    std::nth_element(along[k].begin(), half, along[k].end());
    median[k] = *half;
  }
  return median;
}

void AdfObjects::write(Model& model) {
  find_names();
  find_parents();
  drop_loops();
  center_ = center(model);
  nodes_.assign(objects_.size(), std::nullopt);
  for (size_t i = 0; i < objects_.size(); ++i) {
    // Parents that AMBF creates later must still precede their children.
    std::vector<size_t> above;
    for (std::optional<size_t> at = i; at && !nodes_[*at]; at = parents_[*at]) above.push_back(*at);
    for (; !above.empty(); above.pop_back()) write_node(model, above.back());
  }
  write_joints(model);
}

void AdfObjects::write_joints(Model& model) {
  if (joints_.empty()) return;
  std::vector<AdfJointBody> bodies;
  for (size_t i = 0; i < objects_.size(); ++i) {
    const AdfObject& object = objects_[i];
    if (object.kind != AdfObject::Kind::body) continue;
    bodies.push_back({object.id, names_[i], object.file, nodes_[i].value(), object.scale, object.translation,
                      glm::normalize(object.rotation)});
  }
  model.kinematics = adf_kinematics(joints_, bodies, report_);
}

void AdfObjects::write_node(Model& model, size_t object) {
  const AdfObject& from = objects_[object];
  Node node;
  node.name = names_[object];
  if (parents_[object]) node.parent = nodes_[*parents_[object]];
  node.translation = from.translation;
  node.rotation = glm::normalize(from.rotation);
  node.mesh = from.mesh;
  nodes_[object] = model.nodes.size();
  model.nodes.push_back(node);

  const auto add_child = [&](const char* suffix, const glm::dquat& rotation, const glm::dvec3& at) -> Node& {
    Node child;
    child.name = names_[object] + suffix;
    child.parent = nodes_[object];
    child.rotation = rotation;
    child.translation = at;
    model.nodes.push_back(std::move(child));
    return model.nodes.back();
  };
  const auto add_camera = [&](const char* suffix, const char* camera_suffix, double right) {
    Camera camera = from.camera;
    camera.name = names_[object] + camera_suffix;
    model.cameras.push_back(std::move(camera));
    add_child(suffix, kCameraFromView, {0, right, 0}).camera = model.cameras.size() - 1;
  };
  if (from.kind == AdfObject::Kind::camera) {
    add_camera("#view", "", 0);
    if (from.eye_separation_m) {
      add_camera("#left", "#left", -0.5 * *from.eye_separation_m);
      add_camera("#right", "#right", 0.5 * *from.eye_separation_m);
    }
  }
  if (from.kind == AdfObject::Kind::light) {
    // AMBF's lights fall off by "attenuation" only, glTF's by the squared distance. The intensity makes both
    // equal at the centre of the scene.
    const double distance = std::max(0.05, glm::distance(glm::dvec3(world_from(object)[3]), center_));
    const double loss =
        from.attenuation.x + from.attenuation.y * distance + from.attenuation.z * distance * distance;
    Light light = from.light;
    light.name = names_[object];
    const double intensity = glm::pi<double>() * kFacingRadiance * distance * distance / std::max(loss, 0.01);
    light.intensity = static_cast<float>(std::min(intensity, 1e12));
    model.lights.push_back(std::move(light));
    add_child("#light", kLightFromShine, {}).light = model.lights.size() - 1;
  }
}

}  // namespace fire3dv::convert
