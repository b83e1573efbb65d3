// Scene file builder: shared materials, visual meshes of objects, bodies in rest poses, lights and cameras.
// Positions are in the simulator's frame: Z up, metres.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "examples/common/gltf_writer.h"
#include "examples/common/mesh.h"
#include "examples/common/object.h"

namespace examples {

// Visual meshes of an object with material names, in the object's frame.

std::vector<Part> object_parts(const Object& object);

constexpr GltfMatrix kGltfIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

// Returns world_from_node for a stream_from_body in a stream with Z up, metres.
GltfMatrix rest_pose(const float* stream_from_body);

class SceneBuilder {
 public:
  // Both return an error message, or nothing on success.
  std::optional<std::string> add_materials();
  std::optional<std::string> save(const std::string& path, const std::string& example) const;

  // parts: in the body's frame.
  size_t add_mesh(const std::string& name, const std::vector<Part>& parts);
  // Objects of equal shape, size and material share a mesh.
  size_t object_mesh(const Object& object);
  void add_body(const std::string& name, const GltfMatrix& world_from_node, size_t mesh);

  void add_light(const GltfLight& light, Vec3 at, Vec3 target);
  void add_camera(const std::string& name, float vertical_fov_rad, Vec3 at, Vec3 target);

 private:
  struct MaterialUse {
    size_t index = 0;
    float uv_scale = 1;
  };

  GltfWriter writer_;
  std::map<std::string, MaterialUse> materials_;
  std::map<std::tuple<Shape, float, float, float, std::string, bool>, size_t> shared_;
};

}  // namespace examples
