// Depths in what clusters are drawn into: with the generation of the drawing in their upper bits, see
// passes::ClusterTarget. What earlier generations left is less than any depth of this one, and read as nothing.
#ifndef FIRE3DV_GENERATIONS_GLSL
#define FIRE3DV_GENERATIONS_GLSL

const float kMostKept = 1.99;  // what reaches the generation's bits would belong to the next one

// depth: from 0 to kMostKept.
uint kept_depth(float depth, uint generation) { return floatBitsToUint(depth) + generation; }
// Of an earlier generation: 0.
float depth_kept(uint kept, uint generation) { return uintBitsToFloat(max(kept, generation) - generation); }
vec4 depth_kept(uvec4 kept, uint generation) { return uintBitsToFloat(max(kept, uvec4(generation)) - generation); }

#endif
