// Intermediate model between description readers (readers.h) and the glTF writer (write_glb.h): nodes,
// meshes, materials, source files. Frames and units are the description's, usually Z up and metres.
// gltf_from_model rotates the whole to glTF's frame (right-handed, Y up, metres). Plain data without internal
// synchronisation. Helpers of the readers for lights, names and colours are at the end.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "convert/joints.h"
#include "renderer/scene/cache_files.h"

namespace fire3dv::convert {

// Source files of a model with their time stamps. A stamp is taken before the file is read, so that a change
// during the read is detected at the next start.
class Sources {
 public:
  using Source = scene::ConversionRecord::Source;

  // Adds a file before it is read or looked for, with its current stamp. The first stamp counts.
  void add(const std::filesystem::path& file) {
    if (known_.insert(file).second) all_.push_back({file, scene::stamp_of(file)});
  }
  // Adds a file that another process has stamped.
  void add(const Source& seen) {
    if (known_.insert(seen.file).second) all_.push_back(seen);
  }

  // In order of addition.
  const std::vector<Source>& all() const { return all_; }
  bool contains(const std::filesystem::path& file) const { return known_.contains(file); }

 private:
  std::vector<Source> all_;
  std::set<std::filesystem::path> known_;
};

// Encoded image file: PNG or JPEG; the writer converts other formats to PNG.
struct Image {
  std::string name;
  std::vector<std::byte> bytes;
};

enum class Wrap : uint8_t { repeat, mirror, clamp };

// Channel of an image that holds an opacity. automatic: the image's own opacity if it has any, else its
// brightness.
enum class OpacityChannel : uint8_t { automatic, brightness, opacity, red, green, blue };

// Texture transform and wrap modes: texture coordinates, v downwards, are multiplied with scale, then moved
// by offset.
struct ImagePlacement {
  glm::vec2 scale{1}, offset{0};
  Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
  bool operator==(const ImagePlacement&) const = default;
};

struct Material {
  std::string name;
  glm::vec4 base_color{1};  // linear RGB; a: opacity
  float metallic = 0;
  float roughness = 0.5f;
  glm::vec3 emission{0};                   // linear
  std::optional<size_t> base_color_image;  // index into Model::images; multiplied with base_color
  std::optional<size_t> normal_image;      // tangent space, +Y up
  std::optional<size_t> emission_image;    // multiplied with emission
  // G: roughness, B: metalness, as in glTF; multiplied with both.
  std::optional<size_t> metallic_roughness_image;
  std::optional<size_t> occlusion_image;  // R: share of ambient light
  std::optional<float> alpha_cutoff;      // opacities below are invisible, others opaque; replaces blended
  bool double_sided = true;               // meshes of descriptions are often not closed
  bool blended = false;                   // any opacity below 1
  ImagePlacement base_color_placement, normal_placement, emission_placement, metallic_roughness_placement;
};

// Joints that move a vertex, as indices into the skin of its node, and their weights, whose sum is 1. Unused
// slots have the weight 0.
struct Influences {
  std::array<uint16_t, 8> joints{};
  std::array<float, 8> weights{};
  bool operator==(const Influences&) const = default;
};

// Triangles of one material, counter-clockwise seen from outside, in the node's frame.
struct Surface {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;  // empty, or one unit vector per position
  std::vector<glm::vec2> uvs;      // empty, or one per position; v grows downwards in the image, as in glTF
  std::vector<glm::vec4> colors;   // empty, or one per position: linear RGB and opacity, from 0 to 1
  std::vector<uint32_t> indices;   // three per triangle
  size_t material = 0;             // index into Model::materials
  std::vector<Influences> influences;  // empty, or one per position of a mesh with a skin
  bool operator==(const Surface&) const = default;
};

struct Mesh {
  std::string name;
  std::vector<Surface> surfaces;
  bool unbounded = false;  // stands for an infinite surface, which is not framed
};

// Camera that looks along -Z of its node, +Y up, as in glTF.
struct Camera {
  std::string name;
  float vertical_fov_rad = 0.8f;
  float near_m = 0.01f;
  std::optional<float> far_m;
  std::optional<float> aspect;   // of the angles of view: width / height of the view at any distance
  float pixel_aspect = 1;        // width of a pixel over its height: fy / fx
  glm::vec2 principal_point{0};  // from the image's centre, right and down, in heights of the image
  // Orthographic: height of the view, which replaces the field of view; far_m is needed.
  std::optional<float> height_m;
};

// Light that shines along -Z of its node, as in glTF (KHR_lights_punctual).
struct Light {
  enum class Type { directional, point, spot };
  std::string name;
  Type type = Type::spot;
  glm::vec3 color{1};   // linear
  float intensity = 1;  // candela; lux for directional lights
  float inner_cone_rad = 0;
  float outer_cone_rad = 0.7853982f;  // half angle
};

struct Node {
  std::string name;              // name for streams
  std::optional<size_t> parent;  // precedes its children; empty: child of the root node
  glm::dvec3 translation{0};
  glm::dquat rotation{1, 0, 0, 0};
  glm::dvec3 scale{1};
  std::optional<size_t> mesh, camera, light;
  std::optional<size_t> skin;  // of the mesh, which then ignores the pose of the node
};

struct Skin {
  struct Joint {
    size_t node = 0;          // index into Model::nodes
    glm::dmat4 from_mesh{1};  // inverse of the node's pose in the frame of the mesh in the bind pose
  };
  std::string name;
  std::vector<Joint> joints;
};

// Default view of robots, which face +X and have +Z up: from three-quarter front and above.
inline const glm::dvec3 kThreeQuarterFront{1, -0.75, 0.45};

struct Model {
  std::string name;                                                           // name of the root node
  glm::dquat gltf_from_model{0.7071067811865476, -0.7071067811865476, 0, 0};  // Z up to Y up
  std::vector<Node> nodes;
  std::vector<Mesh> meshes;
  std::vector<Material> materials;
  std::vector<Image> images;
  std::vector<Camera> cameras;
  std::vector<Light> lights;
  Kinematics kinematics;
  std::vector<Skin> skins;
  // Direction towards the eye of the default view; empty: the viewer's own.
  std::optional<glm::dvec3> view_from;
  std::optional<size_t> sky_image;  // background: equirectangular, in the frame of glTF
  // Problems that cost a part of the scene: one message each, with file and field.
  std::vector<std::string> warnings;
  // All files read or looked for. While they are unchanged, the model is, too.
  Sources sources;
};

// Rotation from -Z, the direction of glTF lights, to `direction`, which must not be 0.
glm::dquat shining(const glm::dvec3& direction);

// Adds a directional light to a model without lights, from above and from the side of a viewer at +X, -Y.
// Without shadows, depth is hard to judge. A directional light suits every scene size.
void add_light_if_none(Model& model);

// Sanitises untrusted text for node names and messages: replaces invalid UTF-8, control characters and
// bidirectional controls by '?'. Truncates at a character boundary.
std::string sanitize_text(std::string_view text, size_t max_bytes = 1024);  // default: limit of stream names

// Converts sRGB, as description files use it, to linear light.
inline glm::vec3 linear_from_srgb(const glm::vec3& displayed) {
  glm::vec3 linear;
  for (int i = 0; i < 3; ++i) {
    const float c = std::clamp(displayed[i], 0.0f, 1.0f);
    linear[i] = c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
  }
  return linear;
}

// a: opacity, unchanged.
inline glm::vec4 linear_from_srgb(const glm::vec4& displayed) {
  return {linear_from_srgb(glm::vec3(displayed)), std::clamp(displayed.a, 0.0f, 1.0f)};
}

}  // namespace fire3dv::convert
