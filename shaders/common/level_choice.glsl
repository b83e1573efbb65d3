// Which level of detail a view shows a cluster in: see renderer/scene/cluster_levels.h. tests/unit/cluster_levels_test.cpp
// has the same rule in C++.
#ifndef FIRE3DV_LEVEL_CHOICE_GLSL
#define FIRE3DV_LEVEL_CHOICE_GLSL
#include "common/buffers.glsl"

// What a level of detail may differ by in a light's map.
const float kLevelTexels = 0.25;

// Whether a view might show the error of a group's simplification. A length e in the group's sphere, at depth z and at a
// distance r from the eye, is at most e * r / z^2 long in the image plane at depth 1. Spheres and errors of coarser groups
// hold those of finer ones, so when it says yes to a group it says yes to what was made from it; if rounding should undo
// that, a piece of surface is drawn at two levels, and never at none.
// looks: the view shows normals, colours and textures; else only where the surface is. Both errors hold those of finer
// groups, added up; a map reaches a part of a texel farther than these say, since they were found by samples.
bool shows_error(RasterView view, LevelGroupRecord group, AffineRows world_from_node, float stretch, bool looks) {
  const float error = (looks ? group.error : group.surface_error) * stretch * view.level_scale;
  if (view.eye_world.w == 0) return error > 1;
  const vec3 center = transform_point(world_from_node, group.center);
  const float radius = group.radius * stretch * 1.0001;
  const mat4 m = view.clip_from_world;
  const float depth = max(dot(vec4(m[0].w, m[1].w, m[2].w, m[3].w), vec4(center, 1)) - radius, 0);
  return error * (distance(center, view.eye_world.xyz) + radius) > depth * depth;
}

bool is_chosen_level(GlobalsRef globals, RasterView view, ClusterRecord cluster, AffineRows world_from_node, bool looks) {
  if (view.level_scale == 0) return cluster.made_by == FIRE3DV_NO_INDEX;
  if (cluster.made_by == FIRE3DV_NO_INDEX && cluster.merged_by == FIRE3DV_NO_INDEX) return true;
  const float stretch = largest_stretch(world_from_node);
  LevelGroupRef groups = LevelGroupRef(globals.value.level_groups);
  if (cluster.made_by != FIRE3DV_NO_INDEX && shows_error(view, groups.at[cluster.made_by], world_from_node, stretch, looks)) return false;
  return cluster.merged_by == FIRE3DV_NO_INDEX || shows_error(view, groups.at[cluster.merged_by], world_from_node, stretch, looks);
}

#endif
