// glTF texture references of materials, with samplers and KHR_texture_transform.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "protocol/base/error.h"
#include "renderer/scene/gltf/gltf_document.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// Creates one Texture per glTF texture and use (colour or data).
class Textures {
 public:
  Textures(const GltfDocument& document, Scene& scene) : document_(document), scene_(scene) {}

  // Resolves a textureInfo, including KHR_texture_transform. The result has no texture, and a warning is
  // added, if its image or texture coordinates are unavailable.
  Result<TextureRef> refer(int texture, int uv_set, const tinygltf::ExtensionMap& extensions, bool srgb,
                           const std::string& where);

  // Used images as indices into the document's images; Texture::image indexes this list.
  std::vector<uint32_t> take_used_images() { return std::move(used_images_); }

 private:
  Result<uint32_t> find_or_add(int index, bool srgb, const std::string& where);
  Result<uint32_t> add(const tinygltf::Texture& source, bool srgb, const std::string& where);

  const GltfDocument& document_;
  Scene& scene_;
  std::map<std::pair<int, bool>, uint32_t> texture_of_use_;
  std::map<int, uint32_t> slot_of_image_;
  std::vector<uint32_t> used_images_;
};

}  // namespace fire3dv::scene
