// Per-cluster LOD selection for a view; see renderer/scene/clusters/clusters.h.
// tests/unit/renderer/scene/clusters/levels_test.cpp has the same rule in C++.
#ifndef FIRE3DV_LEVEL_CHOICE_GLSL
#define FIRE3DV_LEVEL_CHOICE_GLSL
#include "common/buffers.glsl"

// Error budget of a LOD in a light's map, in texels.
const float kLevelTexels = 0.25;

// True if a view may show the error of a group's simplification. A length e in the group's sphere, at depth z
// and distance r, projects to at most e * r / z^2 at depth 1. Spheres and errors of coarser groups contain
// those of finer ones, so the test is monotonic. Rounding may draw a surface at two levels, never at none.
// include_attributes: include the error of normals, colours and texture coordinates, otherwise of positions only.
bool shows_error(RasterView view, LevelGroupRecord group, AffineRows world_from_node, float stretch, bool include_attributes) {
  const float error = (include_attributes ? group.error : group.surface_error) * stretch * view.level_scale;
  if (view.eye_world.w == 0) return error > 1;
  const vec3 center = transform_point(world_from_node, group.center);
  const float radius = group.radius * stretch * 1.0001;
  const mat4 m = view.clip_from_world;
  const float depth = max(dot(vec4(m[0].w, m[1].w, m[2].w, m[3].w), vec4(center, 1)) - radius, 0);
  return error * (distance(center, view.eye_world.xyz) + radius) > depth * depth;
}

bool is_chosen_level(GlobalsRef globals, RasterView view, ClusterRecord cluster, AffineRows world_from_node, bool include_attributes) {
  if (view.level_scale == 0) return cluster.made_by == FIRE3DV_NO_INDEX;
  if (cluster.made_by == FIRE3DV_NO_INDEX && cluster.merged_by == FIRE3DV_NO_INDEX) return true;
  const float stretch = largest_stretch(world_from_node);
  LevelGroupRef groups = LevelGroupRef(globals.value.level_groups);
  if (cluster.made_by != FIRE3DV_NO_INDEX && shows_error(view, groups.at[cluster.made_by], world_from_node, stretch, include_attributes)) return false;
  return cluster.merged_by == FIRE3DV_NO_INDEX || shows_error(view, groups.at[cluster.merged_by], world_from_node, stretch, include_attributes);
}

#endif
