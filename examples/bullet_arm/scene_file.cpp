#include "examples/bullet_arm/scene_file.h"

#include <algorithm>
#include <cmath>

#include "examples/bullet_arm/arm.h"
#include "examples/common/mesh.h"
#include "examples/common/scene_builder.h"

namespace bullet_arm {

using namespace examples;

namespace {

Part cylinder(const char* material, float radius, float half_height, Vec3 at, float bevel = 0.004f) {
  return {moved(cylinder_mesh(radius, half_height, bevel), at), material};
}
// Hub of a joint about Y.
Part hub(const char* material, float radius, float half_width, Vec3 at) {
  return {moved(z_to_y(cylinder_mesh(radius, half_width, 0.005f)), at), material};
}
Part flange(const char* material, float radius, float half_length, Vec3 at) {
  return {moved(z_to_x(cylinder_mesh(radius, half_length, 0.003f)), at), material};
}
Part box(const char* material, Vec3 half, Vec3 at, float bevel = 0.004f) {
  return {moved(box_mesh(half, bevel), at), material};
}

std::vector<Part> base_parts() {
  std::vector<Part> parts = {cylinder("painted_graphite", 0.17f, 0.014f, {0, 0, -0.046f}),
                             cylinder("painted_white", 0.125f, 0.040f, {0, 0, 0.006f}, 0.010f),
                             cylinder("brushed_metal", 0.108f, 0.010f, {0, 0, 0.050f}, 0.003f)};
  for (int i = 0; i < 8; ++i) {  // mounting bolts
    const float angle = 0.7853982f * (static_cast<float>(i) + 0.5f);
    parts.push_back(cylinder("brushed_metal", 0.010f, 0.006f,
                             {0.148f * std::cos(angle), 0.148f * std::sin(angle), -0.028f}, 0.002f));
  }
  return parts;
}

std::vector<Part> turret_parts() {
  return {cylinder("painted_orange", 0.098f, 0.050f, {0, 0, -0.058f}, 0.012f),
          box("painted_orange", {0.062f, 0.018f, 0.095f}, {0, 0.073f, 0.062f}, 0.014f),
          box("painted_orange", {0.062f, 0.018f, 0.095f}, {0, -0.073f, 0.062f}, 0.014f),
          hub("brushed_metal", 0.050f, 0.102f, {0, 0, 0.110f})};
}

std::vector<Part> upper_arm_parts() {
  const float half = kUpperArm_m / 2;
  return {{link_mesh(half, 0.078f, 0.060f, 0.050f, 0.014f), "painted_orange"},
          {moved(link_mesh(half * 0.62f, 0.038f, 0.032f, 0.053f, 0.004f), {0.01f, 0, 0}), "painted_graphite"},
          hub("brushed_metal", 0.043f, 0.062f, {half, 0, 0})};
}

std::vector<Part> forearm_parts() {
  const float half = kForearm_m / 2;
  return {{link_mesh(half, 0.058f, 0.042f, 0.042f, 0.012f), "painted_white"},
          {moved(link_mesh(half * 0.58f, 0.027f, 0.021f, 0.0445f, 0.003f), {0.01f, 0, 0}), "painted_orange"},
          hub("painted_graphite", 0.047f, 0.054f, {-half, 0, 0}),
          hub("brushed_metal", 0.030f, 0.052f, {half, 0, 0})};
}

std::vector<Part> wrist_parts() {
  return {hub("painted_graphite", 0.038f, 0.041f, {-kWrist_m / 2, 0, 0}),
          flange("painted_graphite", 0.034f, 0.034f, {-0.004f, 0, 0}),
          flange("brushed_metal", 0.037f, 0.006f, {kWrist_m / 2 - 0.007f, 0, 0})};
}

std::vector<Part> palm_parts() {
  return {flange("brushed_metal", 0.032f, 0.014f, {-kPalm_m / 2 + 0.014f, 0, 0}),
          box("painted_graphite", {0.026f, 0.080f, 0.032f}, {0.010f, 0, 0}, 0.008f),
          box("painted_orange", {0.0125f, 0.0805f, 0.0325f}, {0.006f, 0, 0}, 0.006f),
          box("brushed_metal", {0.006f, 0.076f, 0.010f}, {0.040f, 0, 0}, 0.002f)};
}

// inside: +1 if the other finger is towards +Y.
std::vector<Part> finger_parts(float inside) {
  return {
      box("brushed_metal", {kFinger_m / 2 - 0.004f, 0.006f, 0.015f}, {0.004f, -0.003f * inside, 0}, 0.003f),
      box("painted_graphite", {0.016f, 0.012f, 0.019f}, {-0.038f, -0.003f * inside, 0}, 0.004f),
      box("rubber", {0.024f, 0.0035f, 0.0145f}, {0.029f, 0.0055f * inside, 0}, 0.002f)};
}

// Visual meshes of a link in its frame, metres. index: as in kArmNames.
std::vector<Part> arm_parts(size_t index) {
  switch (index) {
    case 0:
      return base_parts();
    case 1:
      return turret_parts();
    case 2:
      return upper_arm_parts();
    case 3:
      return forearm_parts();
    case 4:
      return wrist_parts();
    case 5:
      return palm_parts();
    case 6:
      return finger_parts(-1);  // finger_left is on the +Y side
    default:
      return finger_parts(1);
  }
}

void add_bodies(SceneBuilder& scene, const Simulation& simulation) {
  for (size_t i = 0; i < kArmNames.size(); ++i) {
    scene.add_body(kArmNames[i], rest_pose(&simulation.poses()[i * 12]),
                   scene.add_mesh(kArmNames[i], arm_parts(i)));
  }
  size_t streamed = kArmNames.size();
  for (const Object& object : simulation.layout()) {
    const GltfMatrix pose = object.mass_kg > 0 ? rest_pose(&simulation.poses()[streamed++ * 12])
                                               : rest_pose(examples::pose_of(object.stream_from_body).data());
    scene.add_body(object.name, pose, scene.object_mesh(object));
  }
}

void add_surroundings(SceneBuilder& scene) {
  scene.add_body("floor", examples::kGltfIdentity,
                 scene.add_mesh("floor", {{examples::floor_mesh(5), "floor"}}));
  scene.add_body("backdrop", examples::kGltfIdentity,
                 scene.add_mesh("backdrop", {{examples::backdrop_mesh(4.2f, 1.9f, 1.0f), "backdrop"}}));

  // Lighting: the spot is a warm key light from the left, the directional light a cool fill from the right.
  scene.add_light({"key_light", "spot", {1.0f, 0.93f, 0.82f}, 130, 0.34f, 0.56f}, {-1.5f, -1.9f, 2.7f},
                  {0, -0.35f, 0.1f});
  scene.add_light({"fill_light", "directional", {0.72f, 0.84f, 1.0f}, 1.7f}, {0.35f, -1.8f, 2.0f}, {0, 0, 0});

  scene.add_camera("camera_front", 0.72f, {0.45f, -2.15f, 1.20f}, {0.06f, -0.28f, 0.22f});
  scene.add_camera("camera_gripper", 0.78f, {-1.28f, -0.98f, 0.52f}, {-0.40f, -0.38f, 0.12f});
  scene.add_camera("camera_side", 0.75f, {1.75f, -1.05f, 0.75f}, {0.22f, -0.32f, 0.20f});
}

}  // namespace

std::optional<std::string> write_scene(const Simulation& simulation, const std::string& path) {
  SceneBuilder scene;
  if (const auto error = scene.add_materials()) return error;
  add_bodies(scene, simulation);
  add_surroundings(scene);
  return scene.save(path, "bullet_arm");
}

}  // namespace bullet_arm
