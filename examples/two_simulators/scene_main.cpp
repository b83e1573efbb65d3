// Scene exporter of the example: two_simulators_scene FILE.glb writes the scene that both simulators move.
#include <cstdio>
#include <optional>
#include <string>

#include "examples/common/scene_builder.h"
#include "examples/two_simulators/carousel.h"
#include "examples/two_simulators/heap.h"

namespace two_simulators {
namespace {

using examples::GltfMatrix, examples::Part, examples::SceneBuilder, examples::Vec3;

// world_from_node of an unrotated body at this stage position.
GltfMatrix standing(Vec3 at_m) {
  const Matrix stage_from_body = {1, 0, 0, at_m.x, 0, 1, 0, at_m.y, 0, 0, 1, at_m.z};
  return examples::rest_pose(stage_from_body.data());
}

Part box(const char* material, Vec3 half, Vec3 at, float bevel) {
  return {examples::moved(examples::box_mesh(half, bevel), at), material};
}

void add_table(SceneBuilder& scene) {
  std::vector<Part> parts = {box("wood", kTableHalf_m, {0, 0, -kTableHalf_m.z}, 0.008f)};
  const float leg_half = (-kFloorZ_m - 2 * kTableHalf_m.z) / 2;
  for (const float x : {-1.0f, 1.0f}) {
    for (const float y : {-1.0f, 1.0f}) {
      parts.push_back(box("wood_dark", {0.028f, 0.028f, leg_half},
                          {x * (kTableHalf_m.x - 0.06f), y * (kTableHalf_m.y - 0.06f), kFloorZ_m + leg_half},
                          0.006f));
    }
  }
  scene.add_body("table", standing({}), scene.add_mesh("table", parts));
}

void add_heap(SceneBuilder& scene) {
  for (const examples::Object& object : heap_layout()) {
    Matrix pose = examples::pose_of(object.stream_from_body);
    pose[3] += kHeapAt_m.x, pose[7] += kHeapAt_m.y, pose[11] += kHeapAt_m.z;
    scene.add_body(object.name, examples::rest_pose(pose.data()), scene.object_mesh(object));
  }
  const Vec3 half = kStirrerBladeHalf_m;
  const std::vector<Part> parts = {
      {examples::cylinder_mesh(kStirrerHub_m, kStirrerHubHalf_m, 0.006f), "painted_graphite"},
      {examples::moved(examples::capsule_mesh(0.016f, 0), {0, 0, kStirrerHubHalf_m}), "gold"},
      box("painted_orange", half, {kStirrerBladeAt_m, 0, -0.018f}, 0.003f),
      box("painted_orange", half, {-kStirrerBladeAt_m, 0, -0.018f}, 0.003f)};
  scene.add_body(kStirrerName, standing(kHeapAt_m + Vec3{0, 0, kStirrerZ_m}),
                 scene.add_mesh(kStirrerName, parts));
}

void add_carousel(SceneBuilder& scene) {
  scene.add_body("carousel_stand", standing(kCarouselAt_m),
                 scene.add_mesh("carousel_stand", carousel_stand()));
  for (const CarouselBody& body : carousel_bodies())
    scene.add_body(body.name, standing(kCarouselAt_m + body.at_m), scene.add_mesh(body.name, body.parts));
}

void add_surroundings(SceneBuilder& scene) {
  const GltfMatrix floor = standing({0, 0, kFloorZ_m});
  scene.add_body("floor", floor, scene.add_mesh("floor", {{examples::floor_mesh(5), "floor"}}));
  scene.add_body("backdrop", floor,
                 scene.add_mesh("backdrop", {{examples::backdrop_mesh(3.6f, 3.0f, 1.2f), "backdrop"}}));

  // Lighting: a warm key light from the left, a cool fill from the right.
  scene.add_light({"key_light", "spot", {1.0f, 0.93f, 0.82f}, 120, 0.34f, 0.60f}, {-1.3f, -1.7f, 2.3f},
                  {0, 0, 0.1f});
  scene.add_light({"fill_light", "directional", {0.72f, 0.84f, 1.0f}, 1.7f}, {0.5f, -1.8f, 1.6f}, {0, 0, 0});

  scene.add_camera("camera_front", 0.62f, {0.08f, -1.58f, 0.74f}, {0.0f, 0, 0.18f});
  scene.add_camera("camera_heap", 0.62f, {-0.52f, -0.72f, 0.48f}, kHeapAt_m + Vec3{0.02f, 0, 0.02f});
  scene.add_camera("camera_carousel", 0.70f, {0.56f, -1.00f, 0.30f}, kCarouselAt_m + Vec3{-0.02f, 0, 0.30f});
}

// Returns an error message, or nothing on success.
std::optional<std::string> write_scene(const std::string& path) {
  SceneBuilder scene;
  if (const auto error = scene.add_materials()) return error;
  add_table(scene);
  add_heap(scene);
  add_carousel(scene);
  add_surroundings(scene);
  return scene.save(path, "two_simulators");
}

}  // namespace
}  // namespace two_simulators

int main(int argc, char** argv) {
  if (argc != 2 || argv[1][0] == '-') {
    std::fprintf(stderr, "two_simulators_scene: name the file to write: two_simulators_scene FILE.glb\n");
    return 2;
  }
  if (const auto error = two_simulators::write_scene(argv[1])) {
    std::fprintf(stderr, "two_simulators_scene: %s\n", error->c_str());
    return 1;
  }
  return 0;
}
