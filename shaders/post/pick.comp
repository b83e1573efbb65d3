// Picking at one pixel: primitive instance and its transform, depth and world position. Variants: FIRE3DV_SAMPLES 1 or 4.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shading/shown_surface.glsl"

layout(local_size_x = 1) in;
layout(push_constant, scalar) uniform Push { PickPush push; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer PickedOut { PickedSurface value; };

void main() {
  GlobalsRef globals = GlobalsRef(push.globals);
  const Eye eye = Eye(push.visibility, push.look_world, push.orthographic);
  const ShownSurface shown = shown_in(globals, eye, uvec2(push.x, push.y));
  const AffineRows nowhere = AffineRows(vec4(1, 0, 0, 0), vec4(0, 1, 0, 0), vec4(0, 0, 1, 0));
  PickedSurface picked = PickedSurface(nowhere, vec3(0), kInfinity, FIRE3DV_NO_INDEX, FIRE3DV_NO_INDEX);
  if (shown.id != 0) {
    const VisibleTriangle t = visible_triangle(globals, shown.id);
    picked.part = part_of_id(globals, shown.id);
    picked.transform = t.part.node;
    picked.world_from_node = t.world_from_node;
    picked.depth_m = shown.depth_m;
    if (push.orthographic != 0) {
      const vec3 b = nearby(barycentrics_at(t, shown.position, vec2(globals.value.width, globals.value.height)));
      picked.world = t.world[0] * b.x + t.world[1] * b.y + t.world[2] * b.z;
    } else {
      const vec3 ray = ray_through(globals, shown.position);
      picked.world = globals.value.eye_world + ray * (shown.depth_m / dot(ray, push.look_world));
    }
  }
  PickedOut(push.picked).value = picked;
}
