// What is known of a mesh as a thing that casts shadows. It decides which of its triangles a shadow map must
// hold so that nothing is believed lit that is not; see shaders/common/shadow_maps.glsl.
#pragma once

#include "renderer/scene/scene.h"

namespace fire3dv::scene {

enum class CasterShape : uint8_t {
  closed,  // bounds a volume, faces outwards everywhere: light enters it through faces turned away from the
           // light
  planar,  // lies in one plane: cannot shadow itself
  open,    // anything else
};

struct Caster {
  CasterShape shape = CasterShape::open;
  glm::vec4 plane_node{0};  // planar: dot(xyz, p) + w = 0, node space
};

// Alpha-masked, blended and deformed primitives make a mesh open. Vertices count as one when their positions
// are equal; at borders, when they are but for rounding.
Caster caster_of(const Scene& scene, const Mesh& mesh);

// Of each mesh of the scene.
std::vector<Caster> casters_of(const Scene& scene);

}  // namespace fire3dv::scene
