// Meshes that lie in one plane, such as the ground: no shadow map holds them. They would be most of its extent, and on
// a slope their own depth would hide what lies just above.
#ifndef FIRE3DV_SHEETS_GLSL
#define FIRE3DV_SHEETS_GLSL
#include "common/culling.glsl"

bool is_sheet(GlobalsRef globals, uint part) {
  for (uint i = 0; i < globals.value.sheet_count; ++i) {
    if (SheetRef(globals.value.sheets).at[i].part == part) return true;
  }
  return false;
}

// Whether a sheet may lie between the point and the light. A sheet does not shadow itself.
bool sheet_may_be_between(GlobalsRef globals, uint own_part, vec3 point_world, vec3 to_light, float distance_m) {
  for (uint i = 0; i < globals.value.sheet_count; ++i) {
    const SheetRecord sheet = SheetRef(globals.value.sheets).at[i];
    if (sheet.part == own_part) continue;
    const PartRecord part = PartRef(globals.value.parts).at[sheet.part];
    const AffineRows world_from_node = AffineRowsRef(globals.value.world_from_node).at[part.node];
    const vec3 normal = normalize(transform_normal(world_from_node, sheet.plane_node.xyz));
    const PrimitiveRecord primitive = PrimitiveRef(globals.value.primitives).at[part.primitive];
    const vec3 center = transform_point(world_from_node, primitive.mesh_center);
    const float radius = primitive.mesh_radius * largest_stretch(world_from_node) * 1.001;
    const vec3 in_plane = transform_point(world_from_node, -sheet.plane_node.w * sheet.plane_node.xyz);
    const float height = dot(normal, point_world - in_plane);
    const float towards = dot(normal, to_light);
    const float rounding = 1e-5 * (radius + length(point_world - center));
    if (height * towards > 0 && abs(height) > rounding) continue;  // goes away from the plane
    const float along = -height / (abs(towards) > 1e-7 ? towards : 1e-7);
    if (along > distance_m + rounding || along < -rounding / max(abs(towards), 1e-3)) continue;
    if (distance(point_world + to_light * along, center) <= radius + rounding) return true;
    if (abs(towards) < 1e-3) return true;  // nearly in the plane
  }
  return false;
}

#endif
