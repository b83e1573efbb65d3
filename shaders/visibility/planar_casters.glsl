// Planar casters such as the ground, which shadow maps omit. They would dominate a map's extent, and on a
// slope their own depth would hide objects just above.
#ifndef FIRE3DV_PLANAR_CASTERS_GLSL
#define FIRE3DV_PLANAR_CASTERS_GLSL
#include "visibility/culling.glsl"

bool is_planar_caster(GlobalsRef globals, uint part) {
  for (uint i = 0; i < globals.value.planar_caster_count; ++i) {
    if (PlanarCasterPlaneRef(globals.value.planar_casters).at[i].part == part) return true;
  }
  return false;
}

PlanarCasterPlane planar_caster_plane(GlobalsRef globals, PlanarCasterRecord caster) {
  const PartRecord part = PartRef(globals.value.parts).at[caster.part];
  const AffineRows world_from_node = AffineRowsRef(globals.value.world_from_node).at[part.node];
  const PrimitiveRecord primitive = PrimitiveRef(globals.value.primitives).at[part.primitive];
  PlanarCasterPlane plane;
  plane.normal_world = normalize(transform_normal(world_from_node, caster.plane_node.xyz));
  plane.radius_m = primitive.mesh_radius * largest_stretch(world_from_node) * 1.001;
  plane.center_world = transform_point(world_from_node, primitive.mesh_center);
  plane.part = caster.part;
  plane.in_plane_world = transform_point(world_from_node, -caster.plane_node.w * caster.plane_node.xyz);
  plane.padding = 0;
  return plane;
}

// True if a planar caster may lie between the point and the light. A planar mesh does not shadow itself.
bool planar_caster_may_be_between(GlobalsRef globals, uint own_part, vec3 point_world, vec3 to_light, float distance_m) {
  for (uint i = 0; i < globals.value.planar_caster_count; ++i) {
    const PlanarCasterPlane caster = PlanarCasterPlaneRef(globals.value.planar_casters).at[i];
    if (caster.part == own_part) continue;
    const float height = dot(caster.normal_world, point_world - caster.in_plane_world);
    const float towards = dot(caster.normal_world, to_light);
    const float rounding = 1e-5 * (caster.radius_m + length(point_world - caster.center_world));
    if (height * towards > 0 && abs(height) > rounding) continue;  // the ray leaves the plane
    const float along = -height / (abs(towards) > 1e-7 ? towards : 1e-7);
    if (along > distance_m + rounding || along < -rounding / max(abs(towards), 1e-3)) continue;
    if (distance(point_world + to_light * along, caster.center_world) <= caster.radius_m + rounding) return true;
    if (abs(towards) < 1e-3) return true;  // nearly parallel to the plane
  }
  return false;
}

#endif
