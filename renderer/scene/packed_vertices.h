// A scene's vertices beside their positions, in a quarter of the bytes that files have them in: 16 for most.
// Shaders read the same bytes (shaders/common/vertices.glsl unpacks them the same way).
//
// Normals are three signed 16-bit numbers of 1 / 32767: off by 0.002 degrees at most, and in need of no
// square root. A tangent is perpendicular to its normal, so that one number says where it points: the place
// along a square around the normal, whose corners are the axes of a basis that follows from the normal (Duff
// et al., Building an Orthonormal Basis, Revisited, 2017), as 15 bits; off by 0.01 degrees at most. The last
// bit is the bitangent's sign.
#pragma once

#include <span>

#include "renderer/scene/scene.h"

namespace fire3dv::scene {

// Of any lengths; of a tangent that is not perpendicular to the normal, the part that is. Where there is
// none, any perpendicular one.
TangentFrame packed_frame(const glm::vec3& normal, const glm::vec4& tangent);
glm::vec3 normal_of(const TangentFrame& frame);
glm::vec4 tangent_of(const TangentFrame& frame);

// All of vertex v; the normal and tangent are those that are shown.
VertexAttributes attributes_of(const Scene& scene, uint32_t v);

bool has_color(const Scene& scene, uint32_t v);  // another than white

// Behind those that the scene has; positions are the caller's.
void append_attributes(Scene& scene, std::span<const VertexAttributes> attributes);

}  // namespace fire3dv::scene
