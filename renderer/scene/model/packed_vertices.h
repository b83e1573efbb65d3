// Packed vertex attributes: 16 bytes beside the position, 20 with normal maps. Shaders unpack the same bytes
// (shaders/common/vertices.glsl).
//
// Directions are three signed integers, which unpack without a square root. Normals and tangent xy have 16
// bits, in steps of 1 / 32767. Tangent z has 15 bits, in steps of 1 / 16383, above the bitangent sign bit (1:
// positive). The maximum error is 0.002 degrees for normals and 0.003 degrees for tangents.
#pragma once

#include <span>

#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// Arguments need not be normalised; zero vectors become (0, 0, 1) and (1, 0, 0).
TangentFrame packed_frame(const glm::vec3& normal, const glm::vec4& tangent);
TangentXy packed_tangent(const glm::vec4& tangent);

glm::vec3 normal_of(const TangentFrame& frame);
glm::vec4 tangent_of(const Scene& scene, uint32_t v);

// All attributes of vertex v, with unpacked normal and tangent.
VertexAttributes attributes_of(const Scene& scene, uint32_t v);

bool has_color(const Scene& scene, uint32_t v);  // true unless it is white

// Appends packed attributes; the caller appends positions.
void append_attributes(Scene& scene, std::span<const VertexAttributes> attributes);

}  // namespace fire3dv::scene
