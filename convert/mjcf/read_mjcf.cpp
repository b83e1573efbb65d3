// Reader for MJCF: the file's own elements are compiled and posed here, so that every version of MJCF can be
// shown.
#include <algorithm>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "convert/mjcf/assets/mjcf_source.h"
#include "convert/mjcf/bodies/mjcf_bodies.h"
#include "convert/mjcf/bodies/mjcf_joints.h"
#include "convert/mjcf/bodies/mjcf_kinematics.h"
#include "convert/mjcf/bodies/mjcf_tendons.h"
#include "convert/mjcf/deformable/mjcf_flexes.h"
#include "convert/mjcf/deformable/mjcf_skins.h"
#include "convert/mjcf/mjcf_reader.h"
#include "convert/model.h"
#include "convert/readers.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

void report_unknown_sections(const MjcfSource& source) {
  static constexpr std::string_view kKnown[] = {"compiler",  "option",    "size",     "visual", "statistic",
                                                "default",   "extension", "custom",   "asset",  "contact",
                                                "tendon",    "equality",  "actuator", "sensor", "keyframe",
                                                "worldbody", "deformable"};
  for (const MjcfElement& section : source.root().children) {
    if (std::find(std::begin(kKnown), std::end(kKnown), section.kind) == std::end(kKnown))
      source.messages().warn(section.where() + ": the section is unknown and ignored");
    if (section.kind != "deformable") continue;
    for (const MjcfElement& child : section.children)
      if (child.kind != "skin" && child.kind != "flex")
        source.messages().warn(child.where() + ": the element is unknown and ignored");
  }
}

void read_visual(const MjcfSource& source, MjcfScene& scene) {
  for (const MjcfElement& section : source.root().children) {
    if (section.kind != "visual") continue;
    for (const MjcfElement& child : section.children) {
      const MjcfAttributes from = source.attributes(child, MjcfDefaults::kMain);
      if (child.kind == "global") {
        scene.is_view_given = true;
        scene.azimuth_deg = from.number("azimuth", scene.azimuth_deg);
        scene.elevation_deg = from.number("elevation", scene.elevation_deg);
        const double fovy = from.number("fovy", scene.vertical_fov_deg);
        if (fovy > 0 && fovy < 180) scene.vertical_fov_deg = fovy;
      } else if (child.kind == "map") {
        const double near = from.number("znear", scene.near_per_extent);
        if (near > 0) scene.near_per_extent = near;
        const double far = from.number("zfar", scene.far_per_extent);
        if (far > 0) scene.far_per_extent = far;
      }
    }
  }
}

void read_statistic(const MjcfSource& source, MjcfScene& scene) {
  for (const MjcfElement& section : source.root().children) {
    if (section.kind != "statistic") continue;
    scene.is_view_given = true;
    const MjcfAttributes from = source.attributes(section, MjcfDefaults::kMain);
    const double extent = from.number("extent", scene.extent);
    if (extent > 0) scene.extent = extent;
    scene.centre = from.vec3("center").value_or(scene.centre);
  }
}

constexpr size_t kMaxKeyframes = 256, kMaxKeyframeNumbers = 1'000'000;

std::vector<const MjcfElement*> keyframes_of(const MjcfSource& source) {
  std::vector<const MjcfElement*> keyframes;
  for (const MjcfElement& section : source.root().children) {
    if (section.kind != "keyframe") continue;
    for (const MjcfElement& key : section.children)
      if (key.kind == "key") keyframes.push_back(&key);
  }
  return keyframes;
}

// Numbers of an attribute, if there are as many as expected.
std::optional<std::vector<double>> key_numbers(const MjcfSource& source, const MjcfElement& key,
                                               const char* name, size_t count) {
  const std::string* const text = key.find(name);
  if (!text) return std::nullopt;
  std::vector<double> values = mjcf_numbers(*text, count + 1);
  if (values.size() == count) return values;
  source.messages().warn(key.where() + ": " + name + " has not " + std::to_string(count) +
                         " numbers, as the model needs; it is ignored");
  return std::nullopt;
}

// The keyframes' joint positions, by name. first: those of the first one, in which the model is posed.
std::vector<Kinematics::NamedPose> named_poses(const MjcfSource& source, const MjcfTree& tree,
                                               const MjcfCoordinates& first) {
  std::vector<Kinematics::NamedPose> poses;
  const std::vector<const MjcfElement*> keyframes = keyframes_of(source);
  size_t numbers = 0;
  for (size_t i = 0; i < keyframes.size(); ++i) {
    const MjcfElement& key = *keyframes[i];
    numbers += tree.coordinates;
    if (i == kMaxKeyframes || numbers > kMaxKeyframeNumbers) {
      source.messages().warn(key.where() +
                             ": this keyframe and those after it are not named poses: there are " +
                             std::to_string(keyframes.size()));
      break;
    }
    MjcfCoordinates coordinates = first;
    if (i != 0) {
      coordinates = default_coordinates(tree);
      if (key.find("qpos")) {
        auto values = key_numbers(source, key, "qpos", tree.coordinates);
        if (!values) continue;
        coordinates.values = std::move(*values);
      }
    }
    const std::string* const name = key.find("name");
    poses.push_back(
        {name && !name->empty() ? *name : "key " + std::to_string(i), mjcf_positions(tree, coordinates)});
  }
  return poses;
}

void read_keyframe(const MjcfSource& source, const MjcfTree& tree, MjcfCoordinates& coordinates) {
  const std::vector<const MjcfElement*> keyframes = keyframes_of(source);
  if (keyframes.empty()) return;
  const auto numbers = [&](const char* name, size_t count) {
    return key_numbers(source, *keyframes.front(), name, count);
  };
  if (auto values = numbers("qpos", tree.coordinates)) coordinates.values = std::move(*values);
  std::vector<size_t> mocap;
  for (size_t i = 0; i < tree.bodies.size(); ++i)
    if (tree.bodies[i].is_mocap) mocap.push_back(i);
  const auto positions = numbers("mpos", 3 * mocap.size()), rotations = numbers("mquat", 4 * mocap.size());
  for (size_t i = 0; i < mocap.size(); ++i) {
    MjcfPose pose = tree.bodies[mocap[i]].pose;
    if (positions) {
      const double* p = &(*positions)[3 * i];
      pose.position = {p[0], p[1], p[2]};
    }
    if (rotations) {
      const double* q = &(*rotations)[4 * i];
      const glm::dquat given(q[0], q[1], q[2], q[3]);
      if (glm::length(given) > 1e-14) pose.rotation = glm::normalize(given);
    }
    coordinates.mocap[mocap[i]] = pose;
  }
}

}  // namespace

Result<MjcfScene> read_mjcf_scene(const std::filesystem::path& file, const ReadOptions& options,
                                  Sources& sources, std::vector<std::string>& warnings) {
  MjcfMessages messages(warnings);
  MjcfFiles files(file, options.package_folders, options.is_confined, sources);
  sources.add(file);
  Result<std::unique_ptr<MjcfSource>> source = MjcfSource::open(file, files, messages);
  if (!source) return source.error();
  report_unknown_sections(**source);
  MjcfScene scene;
  MjcfTree tree;
  MjcfBodyReader bodies(scene, tree);
  if (Result<void> done = bodies.read(**source); !done) return done.error();
  MjcfCoordinates coordinates = default_coordinates(tree);
  const MjcfPosedBodies rest = pose_bodies(tree, coordinates);
  read_keyframe(**source, tree, coordinates);
  const MjcfPosedBodies posed = pose_bodies(tree, coordinates);
  const MjcfExtent extent = extent_of(tree, rest);
  scene.centre = extent.centre;
  scene.extent = extent.extent;
  scene.is_view_given = false;
  read_statistic(**source, scene);
  read_visual(**source, scene);
  pose_scene(tree, rest, posed, scene);
  add_tendons(tree, posed, scene);
  scene.kinematics = mjcf_kinematics(tree, coordinates);
  scene.kinematics.poses = named_poses(**source, tree, coordinates);
  add_skins(tree, posed, scene);
  add_flexes(tree, posed, scene);
  scene.sky = (*source)->sky();
  return scene;
}

Result<Model> read_mjcf(const std::filesystem::path& file, const ReadOptions& options) {
  Model model;
  model.name = file.stem().string();
  const Result<MjcfScene> scene = read_mjcf_scene(file, options, model.sources, model.warnings);
  if (!scene) return scene.error();
  if (!scene->is_view_given) model.view_from = kThreeQuarterFront;
  add_mjcf(*scene, options, model);
  return model;
}

}  // namespace fire3dv::convert
