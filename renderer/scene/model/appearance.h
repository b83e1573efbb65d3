// Appearance of a scene's data model: materials with textures and images, lights and cameras. Indices refer
// to the arrays of Scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace fire3dv::scene {

constexpr uint32_t kNone = UINT32_MAX;  // invalid index

struct TextureRef {
  uint32_t texture = kNone;
  uint32_t uv_set = 0;  // 0 or 1
  glm::vec2 uv_offset{0};
  float uv_rotation_rad = 0;
  glm::vec2 uv_scale{1};
};

enum class AlphaMode : uint8_t { opaque, mask, blend };

// glTF 2.0 metallic-roughness material. Factors are linear.
struct Material {
  std::string name;
  glm::vec4 base_color{1};
  float metallic = 1;
  float roughness = 1;
  glm::vec3 emissive{0};  // times KHR_materials_emissive_strength
  float normal_scale = 1;
  float occlusion_strength = 1;
  float alpha_cutoff = 0.5f;
  AlphaMode alpha_mode = AlphaMode::opaque;
  bool double_sided = false;
  bool unlit = false;
  TextureRef base_color_texture, metallic_roughness_texture, normal_texture, occlusion_texture,
      emissive_texture;

  float ior = 1.5f;    // KHR_materials_ior
  float specular = 1;  // KHR_materials_specular
  glm::vec3 specular_color{1};
  float clearcoat = 0;  // KHR_materials_clearcoat
  float clearcoat_roughness = 0;
  float clearcoat_normal_scale = 1;
  glm::vec3 sheen_color{0};  // KHR_materials_sheen
  float sheen_roughness = 0;
  float transmission = 0;  // KHR_materials_transmission
  float thickness = 0;     // KHR_materials_volume; 0: thin wall
  glm::vec3 attenuation_color{1};
  float attenuation_distance_m = 0;  // 0: infinite
  float dispersion = 0;              // KHR_materials_dispersion: 20 / Abbe number
  float diffuse_transmission = 0;    // KHR_materials_diffuse_transmission
  glm::vec3 diffuse_transmission_color{1};
  TextureRef diffuse_transmission_texture, diffuse_transmission_color_texture;          // A; RGB
  TextureRef specular_texture, specular_color_texture;                                  // A; RGB
  TextureRef clearcoat_texture, clearcoat_roughness_texture, clearcoat_normal_texture;  // R; G; normal
  TextureRef sheen_color_texture, sheen_roughness_texture;                              // RGB; A
  TextureRef transmission_texture;                                                      // R

  float anisotropy = 0;               // KHR_materials_anisotropy, strength
  float anisotropy_rotation_rad = 0;  // from the tangent to the bitangent
  TextureRef anisotropy_texture;      // RG: direction; B: strength

  float iridescence = 0;  // KHR_materials_iridescence
  float iridescence_ior = 1.3f;
  float iridescence_thickness_min_nm = 100, iridescence_thickness_max_nm = 400;
  TextureRef iridescence_texture, iridescence_thickness_texture;  // R; G
};

// True if shading depends on the direction of tangents.
inline bool needs_tangents(const Material& material) {
  return material.normal_texture.texture != kNone || material.clearcoat_normal_texture.texture != kNone ||
         (material.anisotropy > 0 && !material.unlit);
}

// Effective alpha mode: transmissive materials are blended.
inline AlphaMode drawn_alpha_mode(const Material& material) {
  return material.transmission > 0 && !material.unlit ? AlphaMode::blend : material.alpha_mode;
}

// Refracts light where rays are traced; an ior of 0 reflects all of it.
inline bool is_volume(const Material& material) {
  return !material.unlit && (material.transmission > 0 || material.diffuse_transmission > 0) &&
         material.thickness > 0 && material.ior > 0;
}

enum class Wrap : uint8_t { repeat, mirrored_repeat, clamp_to_edge };
struct Sampler {
  Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
  bool nearest_mag = false, nearest_min = false, nearest_mip = false, use_mips = true;
  bool operator==(const Sampler&) const = default;
};

// Pixels of an image, shared by copies: a copy costs nothing, and its identity tells whoever keeps something
// made of the pixels that they are the same. Safe to read and copy on several threads.
class Pixels {
 public:
  Pixels() = default;
  Pixels(std::vector<uint8_t> bytes) : bytes_(std::make_shared<std::vector<uint8_t>>(std::move(bytes))) {}

  size_t size() const { return bytes_ ? bytes_->size() : 0; }
  bool empty() const { return size() == 0; }
  const uint8_t* data() const { return bytes_ ? bytes_->data() : nullptr; }
  const uint8_t* begin() const { return data(); }
  const uint8_t* end() const { return data() + size(); }
  uint8_t operator[](size_t i) const { return data()[i]; }
  bool operator==(const Pixels& other) const {
    return bytes_ == other.bytes_ || (size() == other.size() && std::equal(begin(), end(), other.begin()));
  }

  // To be changed: copies keep what they have.
  std::vector<uint8_t>& edit() {
    if (!bytes_ || bytes_.use_count() > 1) bytes_ = std::make_shared<std::vector<uint8_t>>(begin(), end());
    return *bytes_;
  }
  // As they are stored, whoever shares them: for lists of members, of which writers of files change nothing
  // and readers fill new ones.
  std::vector<uint8_t>& stored() {
    if (!bytes_) bytes_ = std::make_shared<std::vector<uint8_t>>();
    return *bytes_;
  }
  // The same for copies alone. Null: there are no pixels.
  std::shared_ptr<const void> identity() const { return bytes_; }

 private:
  std::shared_ptr<std::vector<uint8_t>> bytes_;
};

struct Image {
  std::string name;
  uint32_t width = 0, height = 0;
  Pixels rgba8;  // rows from the top, 4 bytes a pixel
};

// One use of an image: an image used both as colour and as data has two textures.
struct Texture {
  uint32_t image = 0;
  Sampler sampler;
  bool srgb = false;
};

enum class LightType : uint8_t { directional, point, spot };
// KHR_lights_punctual. The light shines along its node's -Z.
struct Light {
  std::string name;
  LightType type = LightType::point;
  glm::vec3 color{1};            // linear
  float intensity = 1;           // candela (point, spot) or lux (directional)
  float range_m = 0;             // 0 = infinite
  float radius_m = 0;            // point, spot: radius of the emitting sphere; above 0: soft shadows
  float angular_radius_rad = 0;  // directional: half the subtended angle
  float inner_cone_rad = 0;
  float outer_cone_rad = 0.7853981634f;
  // Point: intensity times exp(-spread * (1 - cos)) of the angle off the node's -Z, as of lamps of endoscopes
  // (Modrzejewski et al. 2020). 0: the same in all directions.
  float spread = 0;
  bool casts_shadow = true;
  bool is_default = false;  // see key_light.h
  bool operator==(const Light&) const = default;
};

constexpr float kMaxLightSpread = 100;

// Thin lens of a perspective camera with a sensor that is 24 mm high. The focal length is that of the
// vertical field of view, 12 mm / tan(fov / 2); the aperture's diameter is the focal length over the
// f-number. The image keeps its field of view, wherever the focus is.
struct ThinLens {
  float f_number = 0;          // 0: a pinhole
  float focus_distance_m = 0;  // along the view direction; 0: a pinhole
  bool of_stream = false;      // set by a stream: settings do not replace it
  bool is_pinhole() const { return !(f_number > 0 && focus_distance_m > 0); }
  bool operator==(const ThinLens&) const = default;
};
constexpr float kSensorHeightM = 0.024f;
constexpr ThinLens kUsualLens{2.8f, 2};
// Bounds of files and options.
constexpr float kMinFNumber = 0.1f, kMaxFNumber = 1000;
constexpr float kMinFocusDistanceM = 1e-3f, kMaxFocusDistanceM = 1e6f;

// Bounds of a camera's pixel aspect and of the coordinates of its principal point.
constexpr float kMinPixelAspect = 1e-3f, kMaxPixelAspect = 1e3f, kMaxPrincipalPoint = 1e3f;

struct Camera {
  std::string name;
  bool orthographic = false;
  float vertical_fov_rad = 0.8f;  // of a centred camera with the same vertical focal length
  float aspect = 0;               // 0 = aspect of the image
  float near_m = 0.01f;
  float far_m = 0;             // 0 = infinite
  glm::vec2 half_extent_m{1};  // orthographic
  float exposure = 0;          // factor on linear colour; 0 = from the settings
  ThinLens lens;
  // Perspective: width of a pixel over its height, which is fy over fx of a camera matrix.
  float pixel_aspect = 1;
  // Perspective: from the image's centre, right and down, in heights of the image.
  glm::vec2 principal_point{0};
  bool operator==(const Camera&) const = default;
};

}  // namespace fire3dv::scene
