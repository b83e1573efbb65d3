// A scene file in the making: the materials that the examples share, bodies at rest, lights and cameras.
// Places are in the frame of a simulator: Z up, metres.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "examples/common/glb_writer.h"
#include "examples/common/mesh.h"
#include "examples/common/object.h"

namespace examples {

constexpr GlbMatrix kGlbIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

// world_from_node of a body whose stream_from_body is given, in a stream that is Z up, metres.
GlbMatrix rest_pose(const float* stream_from_body);

class SceneBuilder {
 public:
  // Both return nothing on success, else one sentence.
  std::optional<std::string> add_materials();
  std::optional<std::string> save(const std::string& path, const std::string& example) const;

  // Of parts in the body's frame.
  size_t add_mesh(const std::string& name, const std::vector<Part>& parts);
  // Objects of one shape, size and material share a mesh.
  size_t object_mesh(const Object& object);
  void add_body(const std::string& name, const GlbMatrix& world_from_node, size_t mesh);

  void add_light(const GlbLight& light, Vec3 at, Vec3 target);
  void add_camera(const std::string& name, float vertical_fov_rad, Vec3 at, Vec3 target);

 private:
  struct MaterialUse {
    size_t index = 0;
    float uv_scale = 1;
  };

  GlbWriter writer_;
  std::map<std::string, MaterialUse> materials_;
  std::map<std::tuple<Shape, float, float, float, std::string, bool>, size_t> shared_;
};

}  // namespace examples
