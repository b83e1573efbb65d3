// Depths with a frame generation in their two top bits, so that targets need not be cleared every frame; see
// passes::ClusterTarget. Depths of earlier generations compare lower than all current ones and decode as 0.
#ifndef FIRE3DV_GENERATIONS_GLSL
#define FIRE3DV_GENERATIONS_GLSL

const float kMaxDepth = 1.99;  // larger values would carry into the generation's bits

// depth: from 0 to kMaxDepth.
uint encode_depth(float depth, uint generation) { return floatBitsToUint(depth) + generation; }
// Depths of an earlier generation decode as 0.
float decode_depth(uint encoded, uint generation) { return uintBitsToFloat(max(encoded, generation) - generation); }
vec4 decode_depth(uvec4 encoded, uint generation) { return uintBitsToFloat(max(encoded, uvec4(generation)) - generation); }

#endif
