// Buffer references: typed access to device addresses. Also affine-matrix helpers.
#ifndef FIRE3DV_BUFFERS_GLSL
#define FIRE3DV_BUFFERS_GLSL

#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

#include "shared/types.h"

layout(buffer_reference, scalar, buffer_reference_align = 16) buffer AffineRowsRef { AffineRows at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer NodeSourceRef { NodeSource at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer StreamSourceRef { StreamSource at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer AddressRef { uint64_t at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer UintRef { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer WordRef { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PositionRef { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer FrameRef { FrameRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer UvRef { vec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer ExtrasRef { ExtrasRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer MaterialRef { MaterialRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer MaterialExtensionRef { MaterialExtensionRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer PrimitiveRef { PrimitiveRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer DrawRef { DrawRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer LightRef { LightRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer PartRef { PartRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer ClusterRef { ClusterRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LevelGroupRef { LevelGroupRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer ClusterInstanceRef { ClusterInstance at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer RasterViewRef { RasterView at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer RasterSetRef { RasterSet value; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer ViewWorkRef { ViewWork at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer LargeWorkRef { LargeWork value; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer HugeTriangleRef { HugeTriangle at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer PreparedTriangleRef { PreparedTriangle at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer TileEntryRef { TileEntry at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer LightShadowRef { LightShadow at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer LightPoseRef { LightPose at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PlanarCasterRef { PlanarCasterRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer PlanarCasterPlaneRef { PlanarCasterPlane at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer RayEntryRef { RayEntry at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer ListedRayRef { ListedRay at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer RayListRef { RayList at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LightViewRequestRef { LightViewRequest at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer RasterViewOut { RasterView at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer DeformRecordRef { DeformRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer DeformGroupRef { DeformGroup at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer JointRef { JointRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer UintsRef { uint at[]; };

#include "common/lanes.glsl"

vec3 transform_point(AffineRows m, vec3 p) {
  const vec4 h = vec4(p, 1);
  return vec3(dot(m.row0, h), dot(m.row1, h), dot(m.row2, h));
}

vec3 transform_direction(AffineRows m, vec3 d) {
  return vec3(dot(m.row0.xyz, d), dot(m.row1.xyz, d), dot(m.row2.xyz, d));
}

// Normals transform by the cofactor matrix, which needs no inverse and keeps their side under reflection.
vec3 transform_normal(AffineRows m, vec3 n) {
  const vec3 r0 = m.row0.xyz, r1 = m.row1.xyz, r2 = m.row2.xyz;
  const vec3 c0 = cross(r1, r2);
  const float orientation = dot(r0, c0) < 0 ? -1 : 1;
  return orientation * vec3(dot(c0, n), dot(cross(r2, r0), n), dot(cross(r0, r1), n));
}

// The same up to its length; cheaper where the transform is known to scale uniformly.
vec3 normal_direction(AffineRows m, uint node_facts, vec3 n) {
  return (node_facts & FIRE3DV_NODE_EVEN) != 0 ? transform_direction(m, n) : transform_normal(m, n);
}

bool is_mirroring(AffineRows m) { return dot(m.row0.xyz, cross(m.row1.xyz, m.row2.xyz)) < 0; }

bool scales_evenly(AffineRows m) {
  const vec3 x = vec3(m.row0.x, m.row1.x, m.row2.x), y = vec3(m.row0.y, m.row1.y, m.row2.y),
             z = vec3(m.row0.z, m.row1.z, m.row2.z);
  const vec3 size2 = vec3(dot(x, x), dot(y, y), dot(z, z));
  const float tolerance = 1e-4 * max(size2.x, max(size2.y, size2.z));
  return all(lessThan(abs(size2 - size2.yzx), vec3(tolerance))) &&
         all(lessThan(abs(vec3(dot(x, y), dot(y, z), dot(z, x))), vec3(tolerance)));
}

// Upper bound of the transform's largest stretch; exact for uniform scale.
float largest_stretch(AffineRows m) {
  const vec3 x = vec3(m.row0.x, m.row1.x, m.row2.x), y = vec3(m.row0.y, m.row1.y, m.row2.y),
             z = vec3(m.row0.z, m.row1.z, m.row2.z);
  const float xx = dot(x, x), yy = dot(y, y), zz = dot(z, z);
  // Gershgorin's bound on the eigenvalues of the transform's square.
  const float xy = abs(dot(x, y)), xz = abs(dot(x, z)), yz = abs(dot(y, z));
  return sqrt(max(xx + xy + xz, max(yy + xy + yz, zz + xz + yz)));
}

AffineRows multiply(AffineRows a, AffineRows b) {
  const vec4 last = vec4(0, 0, 0, 1);
  AffineRows c;
  c.row0 = a.row0.x * b.row0 + a.row0.y * b.row1 + a.row0.z * b.row2 + a.row0.w * last;
  c.row1 = a.row1.x * b.row0 + a.row1.y * b.row1 + a.row1.z * b.row2 + a.row1.w * last;
  c.row2 = a.row2.x * b.row0 + a.row2.y * b.row1 + a.row2.z * b.row2 + a.row2.w * last;
  return c;
}

#endif
