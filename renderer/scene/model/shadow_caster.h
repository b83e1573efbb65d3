// Shadow caster class of a mesh: closed, planar or open. It decides which faces a conservative shadow map
// contains; see shaders/shading/shadow_maps.glsl.
#pragma once

#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

enum class CasterShape : uint8_t {
  // Watertight with outward winding: light enters it through back faces.
  closed,
  planar,  // in one plane: casts no shadow on itself
  open,    // all other meshes
};

struct Caster {
  CasterShape shape = CasterShape::open;
  glm::vec4 plane_node{0};  // planar: dot(xyz, p) + w = 0 in node space
};

// Classifies a mesh. Alpha-masked, blended and deformed primitives make it open. Vertices are welded if their
// positions are equal; at borders, if they are equal except for rounding.
Caster classify_caster(const Scene& scene, const Mesh& mesh);

// Classifies all meshes of the scene.
std::vector<Caster> classify_casters(const Scene& scene);

}  // namespace fire3dv::scene
