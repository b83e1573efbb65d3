// Conservative cluster culling for a view. It never rejects a cluster with a triangle that covers a sample.
#ifndef FIRE3DV_CULLING_GLSL
#define FIRE3DV_CULLING_GLSL
#include "visibility/raster_rules.glsl"

// Clearly back-facing; a nearly edge-on triangle never is.
bool faces_away(RasterView view, vec3 normal, vec3 point) {
  const vec3 look = view.eye_world.w != 0 ? point - view.eye_world.xyz : view.eye_world.xyz;
  return dot(normal, look) > 1e-4 * sqrt(dot(normal, normal) * dot(look, look));
}

// True if a light's map needs only the part's triangles that face away from the light. In a closed mesh seen
// from outside, a ray from any visible point hits such a triangle first. False where the near plane may cut
// the mesh open. visibility/light_views.comp computes it once a frame.
bool casts_by_back_faces(GlobalsRef globals, uint part) { return UintRef(globals.value.backface_casters).at[part] != 0; }

bool can_cast_by_back_faces(GlobalsRef globals, PartRecord part) {
  if ((part.flags & FIRE3DV_PART_CLOSED) == 0) return false;
  const AffineRows world_from_node = AffineRowsRef(globals.value.world_from_node).at[part.node];
  const PrimitiveRecord primitive = PrimitiveRef(globals.value.primitives).at[part.primitive];
  const vec3 center = transform_point(world_from_node, primitive.mesh_center);
  const float radius = primitive.mesh_radius * largest_stretch(world_from_node) * 1.01;
  const vec4 window = globals.value.near_window, plane = globals.value.near_plane;
  return distance(center, window.xyz) > radius + window.w ||
         dot(plane.xyz, center) + plane.w > radius + 1e-6 * (abs(plane.w) + dot(abs(plane.xyz), abs(center)));
}

// True if a view draws only one side of a part: the camera front faces, a light back faces.
bool draws_one_side(GlobalsRef globals, uint part_index, PartRecord part) {
#ifdef FIRE3DV_LIGHTS
  return casts_by_back_faces(globals, part_index);
#else
  return (part.flags & FIRE3DV_PART_DOUBLE_SIDED) == 0;
#endif
}

// True if a triangle of a one-sided part is drawn. Nearly edge-on triangles count as both sides, so that none
// is missing.
bool shows_side(RasterView view, vec3 normal, vec3 point) {
#ifdef FIRE3DV_LIGHTS
  return !faces_away(view, -normal, point);
#else
  return !faces_away(view, normal, point);
#endif
}

// World-space bounding sphere of a cluster. A deformed mesh has one sphere for the whole mesh; a radius of 0
// means unknown.
vec4 sphere_of_cluster(GlobalsRef globals, PartRecord part, ClusterRecord cluster, AffineRows world_from_node) {
  const float stretch = largest_stretch(world_from_node);
  if ((part.flags & FIRE3DV_PART_DEFORMED) == 0) {
    return vec4(transform_point(world_from_node, cluster.center), cluster.radius * stretch * 1.0001);
  }
  const PrimitiveRecord primitive = PrimitiveRef(globals.value.primitives).at[part.primitive];
  return vec4(transform_point(world_from_node, primitive.mesh_center), primitive.mesh_radius * stretch * 1.01);
}

bool can_be_seen(GlobalsRef globals, RasterView view, uint part_index, PartRecord part, ClusterRecord cluster,
                 AffineRows world_from_node, vec4 sphere) {
  const bool deformed = (part.flags & FIRE3DV_PART_DEFORMED) != 0;
  const vec3 center = sphere.xyz;
  const float radius = sphere.w;
  if (deformed && !(radius > 0)) return true;
  for (int i = 0; i < 6; ++i) {
    const vec4 plane = view.planes_world[i];
    // The plane's rounding error grows with the distance from the origin.
    if (dot(plane.xyz, center) + plane.w < -radius - 1e-6 * (abs(plane.w) + dot(abs(plane.xyz), abs(center)))) return false;
  }
#ifndef FIRE3DV_LIGHTS
  if ((part.flags & FIRE3DV_PART_DOUBLE_SIDED) != 0) return true;
#endif
  if (deformed || cluster.cone_cutoff >= 1 || !scales_evenly(world_from_node)) return true;
  vec3 axis = transform_direction(world_from_node, cluster.cone_axis) / largest_stretch(world_from_node);
  float slack = 1e-3;
#ifdef FIRE3DV_LIGHTS
  // A light's map holds only back faces of closed meshes, and all triangles of other meshes.
  if (!casts_by_back_faces(globals, part_index)) return true;
  axis = -axis;
#endif
  if (view.eye_world.w == 0) return dot(view.eye_world.xyz, axis) < cluster.cone_cutoff + slack;
  const vec3 look = center - view.eye_world.xyz;
  return dot(look, axis) < (cluster.cone_cutoff + slack) * length(look) + radius;
}

#endif
