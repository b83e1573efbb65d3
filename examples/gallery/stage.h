// Builder of one scene file: shapes, lights and cameras, Y up.
#pragma once

#include <array>
#include <string>

#include "examples/common/gltf_writer.h"
#include "examples/common/mesh.h"
#include "examples/gallery/scenes.h"

namespace gallery {

// Pose of a shape that stands along Z, in a Y-up scene: rotation about X, rotation about Y, translation.
examples::GltfMatrix standing(examples::Vec3 at, float turn_rad = 0);

// Pose of a flat shape in XY, facing +Z, that shall face this way.
examples::GltfMatrix facing(examples::Vec3 at, examples::Vec3 normal);

// Sphere of 96 segments.
examples::Mesh ball(float radius);

class Stage {
 public:
  void shape(const std::string& name, const examples::Mesh& mesh, const examples::GltfMaterial& material,
             const examples::GltfMatrix& pose);
  void light(const examples::GltfLight& light, examples::Vec3 eye, examples::Vec3 target);
  void camera(const std::string& name, examples::Vec3 eye, examples::Vec3 target, float vertical_fov_rad);
  void ground(std::array<float, 3> color);
  SceneFile finish(const std::string& name) const;

 private:
  examples::GltfWriter writer_;
};

}  // namespace gallery
