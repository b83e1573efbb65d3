#include "renderer/scene/gltf/specular_glossiness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "base/color/srgb.h"
#include "base/parallel.h"
#include "renderer/scene/model/scene_fields.h"

namespace fire3dv::scene {
namespace {

constexpr float kDielectric = 0.04f;  // reflectance of metallic-roughness dielectrics
constexpr float kSmallestFactor = 1e-6f;

float perceived_brightness(const glm::vec3& color) {
  return std::sqrt(glm::dot(glm::vec3(0.299f, 0.587f, 0.114f), color * color));
}

// diffuse (1 - max specular) = base (1 - 0.04) (1 - metallic)
// specular = 0.04 (1 - metallic) + base metallic
float solve_metallic(float diffuse, float specular, float diffuse_share) {
  if (specular < kDielectric) return 0;
  const float b = diffuse * diffuse_share / (1 - kDielectric) + specular - 2 * kDielectric;
  const float c = kDielectric - specular;
  const float root = std::sqrt(std::max(b * b - 4 * kDielectric * c, 0.0f));
  return std::clamp((root - b) / (2 * kDielectric), 0.0f, 1.0f);
}

uint8_t unit_byte(float value) {
  return static_cast<uint8_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255));
}

uint8_t srgb_byte(float linear) {
  return unit_byte(srgb_from_linear(linear));
}

const std::array<float, 256>& linear_of_byte() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> values{};
    for (size_t i = 0; i < values.size(); ++i) values[i] = linear_from_srgb(static_cast<float>(i) / 255);
    return values;
  }();
  return table;
}

// RGBA of an image at a texel of a larger grid; white without an image. RGB becomes linear.
glm::vec4 texel(const Image* image, uint32_t x, uint32_t y, uint32_t width, uint32_t height) {
  if (image == nullptr) return glm::vec4(1);
  const size_t column = uint64_t{x} * image->width / width, row = uint64_t{y} * image->height / height;
  const uint8_t* rgba = image->rgba8.data() + (row * image->width + column) * 4;
  const auto& linear = linear_of_byte();
  return {linear[rgba[0]], linear[rgba[1]], linear[rgba[2]], static_cast<float>(rgba[3]) / 255};
}

bool same_coordinates(const TextureRef& a, const TextureRef& b, const Scene& scene) {
  return a.uv_set == b.uv_set && a.uv_offset == b.uv_offset && a.uv_rotation_rad == b.uv_rotation_rad &&
         a.uv_scale == b.uv_scale && scene.textures[a.texture].sampler == scene.textures[b.texture].sampler;
}

// Empties images that only converted materials used.
void release_unused_images(size_t original_images, Scene& scene) {
  std::vector<bool> is_used(scene.images.size(), false);
  if (scene.sky_texture != kNone) is_used[scene.textures[scene.sky_texture].image] = true;
  for (const Material& material : scene.materials) {
    visit_textures(material, [&](const TextureRef& ref) {
      if (ref.texture != kNone) is_used[scene.textures[ref.texture].image] = true;
    });
  }
  for (size_t i = 0; i < original_images; ++i) {
    if (!is_used[i]) scene.images[i] = Image{scene.images[i].name, 1, 1, std::vector<uint8_t>(4, 255)};
  }
}

class Converter {
 public:
  Converter(const LoadLimits& limits, Scene& scene)
      : limits_(limits), scene_(scene), pixels_left_(limits.max_image_pixels) {}

  Result<void> convert(const SpecularGlossinessMaterial& source) {
    Material& material = scene_.materials[source.material];
    const MetallicRoughness factors = to_metallic_roughness(source.factors);
    material.base_color = factors.base_color;
    material.metallic = factors.metallic;
    material.roughness = factors.roughness;
    material.base_color_texture = source.diffuse;
    const bool is_dielectric = perceived_brightness(source.factors.specular) < kDielectric;
    if (source.specular_glossiness.texture == kNone && (source.diffuse.texture == kNone || is_dielectric))
      return {};  // exact with the diffuse texture as base colour
    const Image* diffuse = image_of(source.diffuse);
    const Image* specular = image_of(source.specular_glossiness);
    const bool can_be_combined = source.diffuse.texture == kNone ||
                                 source.specular_glossiness.texture == kNone ||
                                 same_coordinates(source.diffuse, source.specular_glossiness, scene_);
    if (can_be_combined && (diffuse != nullptr || specular != nullptr))
      return combine(source, diffuse, specular);
    return {};
  }

 private:
  struct ConvertedTextures {
    uint32_t diffuse, specular;  // textures
    SpecularGlossiness factors;
    uint32_t base_color, metallic_roughness;
  };

  const Image* image_of(const TextureRef& ref) const {
    if (ref.texture == kNone) return nullptr;
    const Image& image = scene_.images[scene_.textures[ref.texture].image];
    const bool is_rgba8 = image.width > 0 && image.rgba8.size() == size_t{image.width} * image.height * 4;
    return is_rgba8 ? &image : nullptr;
  }

  uint32_t add_texture(Image image, const Sampler& sampler, bool srgb) {
    scene_.images.push_back(std::move(image));
    scene_.textures.push_back({static_cast<uint32_t>(scene_.images.size() - 1), sampler, srgb});
    return static_cast<uint32_t>(scene_.textures.size() - 1);
  }

  Result<void> combine(const SpecularGlossinessMaterial& source, const Image* diffuse,
                       const Image* specular) {
    const uint32_t diffuse_texture = source.diffuse.texture;
    const uint32_t specular_texture = source.specular_glossiness.texture;
    const TextureRef& coordinates = diffuse != nullptr ? source.diffuse : source.specular_glossiness;
    auto known = std::find_if(made_.begin(), made_.end(), [&](const ConvertedTextures& made) {
      return made.diffuse == diffuse_texture && made.specular == specular_texture &&
             made.factors == source.factors;
    });
    if (known == made_.end()) {
      const uint32_t width = std::max(diffuse ? diffuse->width : 0, specular ? specular->width : 0);
      const uint32_t height = std::max(diffuse ? diffuse->height : 0, specular ? specular->height : 0);
      const uint64_t pixels = uint64_t{width} * height;
      if (pixels > pixels_left_) return {};
      pixels_left_ -= pixels;
      if (limits_.reserve) {
        if (auto room = limits_.reserve(pixels * 8); !room)
          return Error{"the textures of \"KHR_materials_pbrSpecularGlossiness\": " + room.error().message};
      }
      const Sampler sampler = scene_.textures[coordinates.texture].sampler;
      auto [base_color, metallic_roughness] = images_of(source.factors, diffuse, specular, width, height);
      const uint32_t base_color_texture = add_texture(std::move(base_color), sampler, true);
      made_.push_back({diffuse_texture, specular_texture, source.factors, base_color_texture,
                       add_texture(std::move(metallic_roughness), sampler, false)});
      known = made_.end() - 1;
    }
    Material& material = scene_.materials[source.material];
    material.base_color = glm::vec4(1);
    material.metallic = material.roughness = 1;
    material.base_color_texture = material.metallic_roughness_texture = coordinates;
    material.base_color_texture.texture = known->base_color;
    material.metallic_roughness_texture.texture = known->metallic_roughness;
    return {};
  }

  std::pair<Image, Image> images_of(const SpecularGlossiness& factors, const Image* diffuse,
                                    const Image* specular, uint32_t width, uint32_t height) const {
    const size_t bytes = size_t{width} * height * 4;
    std::vector<uint8_t> base_color(bytes), metallic_roughness(bytes);
    parallel_for(height, [&](size_t row) {
      if (limits_.stop_requested && limits_.stop_requested()) return;
      const auto y = static_cast<uint32_t>(row);
      size_t to = row * width * 4;
      for (uint32_t x = 0; x < width; ++x, to += 4) {
        SpecularGlossiness at = factors;
        at.diffuse *= texel(diffuse, x, y, width, height);
        const glm::vec4 reflection = texel(specular, x, y, width, height);
        at.specular *= glm::vec3(reflection);
        at.glossiness *= reflection.a;
        const MetallicRoughness converted = to_metallic_roughness(at);
        for (int c = 0; c < 3; ++c)
          base_color[to + static_cast<size_t>(c)] = srgb_byte(converted.base_color[c]);
        base_color[to + 3] = unit_byte(converted.base_color.a);
        metallic_roughness[to] = metallic_roughness[to + 3] = 255;
        metallic_roughness[to + 1] = unit_byte(converted.roughness);
        metallic_roughness[to + 2] = unit_byte(converted.metallic);
      }
    });
    return {Image{"base colour of specular-glossiness", width, height, std::move(base_color)},
            Image{"metallic-roughness of specular-glossiness", width, height, std::move(metallic_roughness)}};
  }

  const LoadLimits& limits_;
  Scene& scene_;
  uint64_t pixels_left_;  // of converted images; many materials may share two large images
  std::vector<ConvertedTextures> made_;
};

}  // namespace

MetallicRoughness to_metallic_roughness(const SpecularGlossiness& source) {
  const glm::vec3 diffuse(source.diffuse), specular = source.specular;
  const float diffuse_share = 1 - std::max({specular.r, specular.g, specular.b});
  const float metallic =
      solve_metallic(perceived_brightness(diffuse), perceived_brightness(specular), diffuse_share);
  const glm::vec3 from_diffuse =
      diffuse * (diffuse_share / (1 - kDielectric) / std::max(1 - metallic, kSmallestFactor));
  const glm::vec3 from_specular =
      (specular - kDielectric * (1 - metallic)) / std::max(metallic, kSmallestFactor);
  const glm::vec3 color = glm::clamp(glm::mix(from_diffuse, from_specular, metallic * metallic), 0.0f, 1.0f);
  return {glm::vec4(color, source.diffuse.a), metallic, 1 - source.glossiness};
}

Result<void> convert_specular_glossiness(std::span<const SpecularGlossinessMaterial> materials,
                                         const LoadLimits& limits, Scene& scene) {
  if (materials.empty()) return {};
  const size_t original_images = scene.images.size();
  Converter converter(limits, scene);
  for (const SpecularGlossinessMaterial& material : materials) {
    if (auto done = converter.convert(material); !done) return done;
  }
  release_unused_images(original_images, scene);
  return {};
}

}  // namespace fire3dv::scene
