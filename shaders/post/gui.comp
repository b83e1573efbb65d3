// GUI panels over a finished image: one workgroup per tile with primitives. A pixel blends its tile's
// primitives in draw order. Blending uses encoded colours, like the panels' design.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#include "shared/bindings.h"
#include "shared/gui_types.h"

layout(local_size_x = FIRE3DV_GUI_TILE, local_size_y = FIRE3DV_GUI_TILE) in;
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer GuiPrimitiveRef { GuiPrimitive at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer GuiTileRef { GuiTile at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer GuiEntryRef { uint at[]; };
layout(push_constant, scalar) uniform Push { GuiPush push; };
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_IN) uniform sampler2D coverage;  // glyphs and soft edges
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_OUT, rgba8) uniform image2D result;

// Edge function that is exactly antisymmetric under exchange of from and to. Of two triangles with a common
// edge, exactly one covers a pixel centre on it.
float side_of(vec2 from, vec2 to, vec2 at) {
  const bool swapped = to.y < from.y || (to.y == from.y && to.x < from.x);
  const vec2 a = swapped ? to : from, b = swapped ? from : to;
  precise float side = (b.x - a.x) * (at.y - a.y) - (b.y - a.y) * (at.x - a.x);
  return swapped ? -side : side;
}
bool is_inside(float side, vec2 from, vec2 to) {
  const bool swapped = to.y < from.y || (to.y == from.y && to.x < from.x);
  return side > 0 || (side == 0 && !swapped);
}

bool shade(const GuiPrimitive primitive, vec2 at, out vec4 color, out vec2 uv) {
  if (primitive.kind == FIRE3DV_GUI_RECTANGLE) {
    if (any(lessThan(at, primitive.a.xy)) || any(greaterThanEqual(at, primitive.b.xy))) return false;
    uv = mix(primitive.a.zw, primitive.b.zw, (at - primitive.a.xy) / (primitive.b.xy - primitive.a.xy));
    color = unpackUnorm4x8(primitive.color_a);
    return true;
  }
  vec3 part = vec3(side_of(primitive.b.xy, primitive.c.xy, at), side_of(primitive.c.xy, primitive.a.xy, at),
                   side_of(primitive.a.xy, primitive.b.xy, at));
  if (!is_inside(part.x, primitive.b.xy, primitive.c.xy) || !is_inside(part.y, primitive.c.xy, primitive.a.xy) ||
      !is_inside(part.z, primitive.a.xy, primitive.b.xy))
    return false;
  part /= part.x + part.y + part.z;
  uv = part.x * primitive.a.zw + part.y * primitive.b.zw + part.z * primitive.c.zw;
  color = part.x * unpackUnorm4x8(primitive.color_a) + part.y * unpackUnorm4x8(primitive.color_b) +
          part.z * unpackUnorm4x8(primitive.color_c);
  return true;
}

void main() {
  const uint number = gl_WorkGroupID.y * FIRE3DV_GUI_TILES_IN_ROW + gl_WorkGroupID.x;
  if (number >= push.tile_count) return;
  const GuiTile tile = GuiTileRef(push.tiles).at[number];
  const uvec2 pixel = uvec2(tile.tile_position & 0xffffu, tile.tile_position >> 16) * FIRE3DV_GUI_TILE + gl_LocalInvocationID.xy;
  if (pixel.x >= push.width || pixel.y >= push.height) return;
  const vec2 at = vec2(pixel) + 0.5;
  vec3 shown = imageLoad(result, ivec2(pixel)).rgb;
  for (uint i = 0; i < tile.count; ++i) {
    const GuiPrimitive primitive = GuiPrimitiveRef(push.primitives).at[GuiEntryRef(push.entries).at[tile.first + i]];
    if (any(lessThan(at, primitive.clip.xy)) || any(greaterThanEqual(at, primitive.clip.zw))) continue;
    vec4 color;
    vec2 uv;
    if (!shade(primitive, at, color, uv)) continue;
    shown = mix(shown, color.rgb, color.a * textureLod(coverage, uv, 0).r);
  }
  imageStore(result, ivec2(pixel), vec4(shown, 1));
}
