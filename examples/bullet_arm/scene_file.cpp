#include "examples/bullet_arm/scene_file.h"

#include "examples/bullet_arm/arm.h"
#include "examples/bullet_arm/shapes.h"
#include "examples/common/frames.h"
#include "examples/common/object_parts.h"
#include "examples/common/scene_builder.h"

namespace bullet_arm {
namespace {

using examples::GlbMatrix, examples::rest_pose, examples::SceneBuilder;

void add_bodies(SceneBuilder& scene, const Simulation& simulation) {
  for (size_t i = 0; i < kArmNames.size(); ++i) {
    scene.add_body(kArmNames[i], rest_pose(&simulation.poses()[i * 12]),
                   scene.add_mesh(kArmNames[i], arm_parts(i)));
  }
  size_t streamed = kArmNames.size();
  for (const Object& object : simulation.layout()) {
    const GlbMatrix pose = object.mass_kg > 0 ? rest_pose(&simulation.poses()[streamed++ * 12])
                                              : rest_pose(examples::pose_of(object.stream_from_body).data());
    scene.add_body(object.name, pose, scene.object_mesh(object));
  }
}

void add_surroundings(SceneBuilder& scene) {
  scene.add_body("floor", examples::kGlbIdentity,
                 scene.add_mesh("floor", {{examples::floor_mesh(5), "floor"}}));
  scene.add_body("backdrop", examples::kGlbIdentity,
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
