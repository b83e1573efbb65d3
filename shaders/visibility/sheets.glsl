// Planar occluders such as the ground, which shadow maps omit. They would dominate a map's extent, and on a
// slope their own depth would hide objects just above.
#ifndef FIRE3DV_SHEETS_GLSL
#define FIRE3DV_SHEETS_GLSL
#include "visibility/culling.glsl"

bool is_sheet(GlobalsRef globals, uint part) {
  for (uint i = 0; i < globals.value.sheet_count; ++i) {
    if (SheetPlaceRef(globals.value.sheets).at[i].part == part) return true;
  }
  return false;
}

SheetPlace place_of_sheet(GlobalsRef globals, SheetRecord sheet) {
  const PartRecord part = PartRef(globals.value.parts).at[sheet.part];
  const AffineRows world_from_node = AffineRowsRef(globals.value.world_from_node).at[part.node];
  const PrimitiveRecord primitive = PrimitiveRef(globals.value.primitives).at[part.primitive];
  SheetPlace place;
  place.normal_world = normalize(transform_normal(world_from_node, sheet.plane_node.xyz));
  place.radius_m = primitive.mesh_radius * largest_stretch(world_from_node) * 1.001;
  place.center_world = transform_point(world_from_node, primitive.mesh_center);
  place.part = sheet.part;
  place.in_plane_world = transform_point(world_from_node, -sheet.plane_node.w * sheet.plane_node.xyz);
  place.padding = 0;
  return place;
}

// True if a planar occluder may lie between the point and the light. A planar mesh does not shadow itself.
bool sheet_may_be_between(GlobalsRef globals, uint own_part, vec3 point_world, vec3 to_light, float distance_m) {
  for (uint i = 0; i < globals.value.sheet_count; ++i) {
    const SheetPlace sheet = SheetPlaceRef(globals.value.sheets).at[i];
    if (sheet.part == own_part) continue;
    const float height = dot(sheet.normal_world, point_world - sheet.in_plane_world);
    const float towards = dot(sheet.normal_world, to_light);
    const float rounding = 1e-5 * (sheet.radius_m + length(point_world - sheet.center_world));
    if (height * towards > 0 && abs(height) > rounding) continue;  // the ray leaves the plane
    const float along = -height / (abs(towards) > 1e-7 ? towards : 1e-7);
    if (along > distance_m + rounding || along < -rounding / max(abs(towards), 1e-3)) continue;
    if (distance(point_world + to_light * along, sheet.center_world) <= sheet.radius_m + rounding) return true;
    if (abs(towards) < 1e-3) return true;  // nearly parallel to the plane
  }
  return false;
}

#endif
