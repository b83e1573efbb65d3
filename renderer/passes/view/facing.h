// Sides of a scene's triangles that a view sees. Triangles of single-sided materials are invisible from
// behind, so that a view from the wrong side of an open surface shows nothing.
#pragma once

#include <glm/glm.hpp>
#include <span>

#include "renderer/scene/model/scene.h"
#include "renderer/scene/model/scene_edits.h"

namespace fire3dv::passes {

// Share of the triangle area of visible instances whose front is towards the eye, 0 to 1; triangles of
// double-sided materials, of skinned or morphed meshes, and points and lines count as fronts. 1 if there are
// no triangles with an area. Of many triangles every n-th one is looked at.
// eye_world: homogeneous; w = 1: a position in metres; w = 0: the direction to an eye at infinity.
// edits: nodes that they hide do not count; may be null.
float front_facing_share(const scene::Scene& scene, const scene::SceneEdits* edits,
                         std::span<const glm::mat4> world_from_node, const glm::vec4& eye_world);

// The scene's Scene::view_from or default_orientation(), turned to another side if nearly all triangles show
// it their backs and fewer show theirs to the other side.
glm::mat4 default_orientation(const scene::Scene& scene, std::span<const glm::mat4> world_from_node);

}  // namespace fire3dv::passes
