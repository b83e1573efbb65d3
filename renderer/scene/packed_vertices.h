// A scene's vertices beside their positions, in 16 bytes for most, 20 where there are normal maps. Shaders
// read the same bytes (shaders/common/vertices.glsl unpacks them the same way).
//
// Directions are three signed numbers, which need no square root to be unpacked: of 16 bits, steps of 1 /
// 32767; a tangent's z of 15, steps of 1 / 16383, above the bitangent's sign (1: positive). Normals are off
// by 0.002 degrees at most, tangents by 0.003.
#pragma once

#include <span>

#include "renderer/scene/scene.h"

namespace fire3dv::scene {

// Normals and tangents may have any length; what has none becomes (0, 0, 1) and (1, 0, 0).
TangentFrame packed_frame(const glm::vec3& normal, const glm::vec4& tangent);
TangentXy packed_tangent(const glm::vec4& tangent);

glm::vec3 normal_of(const TangentFrame& frame);
glm::vec4 tangent_of(const Scene& scene, uint32_t v);

// All of vertex v; the normal and tangent are those that are shown.
VertexAttributes attributes_of(const Scene& scene, uint32_t v);

bool has_color(const Scene& scene, uint32_t v);  // another than white

// Behind those that the scene has; positions are the caller's.
void append_attributes(Scene& scene, std::span<const VertexAttributes> attributes);

}  // namespace fire3dv::scene
