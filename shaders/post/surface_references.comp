// Surface point of each pixel, for flow to a later image. Variants: FIRE3DV_SAMPLES 1 or 4.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "post/other_image.glsl"
#include "shading/shown_surface.glsl"
#include "shared/flow_types.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { SurfaceReferencesPush push; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer SurfaceReferenceOut { SurfaceReference at[]; };

void main() {
  GlobalsRef globals = GlobalsRef(push.globals);
  const uvec2 size = uvec2(globals.value.width, globals.value.height), pixel = gl_GlobalInvocationID.xy;
  if (any(greaterThanEqual(pixel, size))) return;
  const ShownSurface shown = shown_in(globals, Eye(push.visibility, push.look_world, push.orthographic), pixel);
  SurfaceReference reference = SurfaceReference(shown.id, vec3(0), shown.position);
  if (shown.id != 0) {
    const VisibleTriangle t = visible_triangle(globals, shown.id);
    PositionRef positions = PositionRef(globals.value.positions);
    const vec3 b = nearby(barycentrics_at(t, shown.position, vec2(size)));
    const vec3 node = positions.at[t.vertex[0]] * b.x + positions.at[t.vertex[1]] * b.y + positions.at[t.vertex[2]] * b.z;
    reference.barycentrics = b;
    // With the arithmetic of the later image, so that static surfaces have exactly no flow.
    reference.position_px = pixels_of(size, clip_position(globals.value.clip_from_world, world_position(t.world_from_node, node)));
  } else if (push.orthographic == 0) {
    reference.position_px = pixels_of(size, clip_direction(globals.value.clip_from_world, ray_through(globals, shown.position)));
  }
  SurfaceReferenceOut(push.references).at[pixel.y * size.x + pixel.x] = reference;
}
