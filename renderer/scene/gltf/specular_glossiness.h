// KHR_materials_pbrSpecularGlossiness: conversion to metallic-roughness, of factors and of textures.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>

#include "base/error.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

struct SpecularGlossiness {
  glm::vec4 diffuse{1};   // linear; a: opacity
  glm::vec3 specular{1};  // linear
  float glossiness = 1;
  bool operator==(const SpecularGlossiness&) const = default;
};

struct MetallicRoughness {
  glm::vec4 base_color{1};  // linear; a: opacity
  float metallic = 1;
  float roughness = 1;
};

// Chooses the metalness for which a dielectric reflectance of 0.04 reproduces the perceived brightness of
// diffuse and specular colour. Approximation: coloured reflections of dielectrics lose their colour.
MetallicRoughness to_metallic_roughness(const SpecularGlossiness& source);

// A material of the scene whose textures are to be converted. kNone: no such texture.
struct SpecularGlossinessMaterial {
  uint32_t material = 0;
  SpecularGlossiness factors;
  TextureRef diffuse, specular_glossiness;
};

// Sets factors and textures of these materials. Textures are converted per texel to new images, of the larger
// width and height of both; the smaller one is sampled at the nearest texel. Textures with different
// coordinates, and images beyond the limit of pixels, are not combined: only the diffuse texture is used,
// with the factors' metalness and roughness. Requires decoded images.
Result<void> convert_specular_glossiness(std::span<const SpecularGlossinessMaterial> materials,
                                         const LoadLimits& limits, Scene& scene);

}  // namespace fire3dv::scene
