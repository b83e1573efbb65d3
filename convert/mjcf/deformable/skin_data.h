// Skin as in a file or in elements, before its bones are found, and its parsers. Errors are sentence ends
// about the skin.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "convert/mjcf/xml/mjcf_element.h"
#include "convert/model.h"

namespace fire3dv::convert {

// All indices are in bounds, all numbers finite, quaternions have unit length.
struct SkinData {
  struct Bone {
    std::string body;
    glm::dvec3 position{0};           // of the body in the bind pose
    glm::dquat rotation{1, 0, 0, 0};  // of the body in the bind pose
    std::vector<uint32_t> vertices;
    std::vector<float> weights;  // as many
  };
  std::vector<glm::vec3> vertices;
  std::vector<glm::vec2> uvs;  // empty, or one per vertex; v grows downwards in the image
  std::vector<std::array<uint32_t, 3>> faces;
  std::vector<Bone> bones;  // at most 65,535
};

// MuJoCo's binary format.
Result<SkinData> parse_skn(std::string_view bytes);
// Attributes and bone elements of a skin element.
Result<SkinData> parse_inline_skin(const MjcfElement& element);

// Vertices and triangles in the bind pose, inflated along smooth normals, with the influences of the bones.
struct BoundSkin {
  Surface surface;
  bool is_rigid = true;       // each vertex follows one bone
  bool has_all_bones = true;  // no vertex had more than eight bones, or negative weights
};
// The error says that a vertex has no bone.
Result<BoundSkin> bind_skin(const SkinData& data, double inflate);

// Smooth normals, weighted by area, and vertices moved along them.
void inflate(double distance, Surface& surface);

}  // namespace fire3dv::convert
