// Depths with a frame generation in their two top bits, so that targets need not be cleared every frame; see
// passes::ClusterTarget. Depths of earlier generations compare lower than all current ones and decode as 0.
#ifndef FIRE3DV_GENERATIONS_GLSL
#define FIRE3DV_GENERATIONS_GLSL

const float kMostKept = 1.99;  // larger values would carry into the generation's bits

// depth: from 0 to kMostKept.
uint kept_depth(float depth, uint generation) { return floatBitsToUint(depth) + generation; }
// Depths of an earlier generation decode as 0.
float depth_kept(uint kept, uint generation) { return uintBitsToFloat(max(kept, generation) - generation); }
vec4 depth_kept(uvec4 kept, uint generation) { return uintBitsToFloat(max(kept, uvec4(generation)) - generation); }

#endif
