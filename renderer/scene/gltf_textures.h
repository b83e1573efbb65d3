// Textures as materials refer to them.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "protocol/error.h"
#include "renderer/scene/gltf_document.h"
#include "renderer/scene/scene.h"

namespace fire3dv::scene {

// Hands out one Texture for each use of a glTF texture, as colour or as data.
class Textures {
 public:
  Textures(const GltfDocument& document, Scene& scene) : document_(document), scene_(scene) {}

  // What a textureInfo says, KHR_texture_transform included. Without a texture and with a warning where its
  // image or its texture coordinates cannot be had.
  Result<TextureRef> refer(int texture, int uv_set, const tinygltf::ExtensionMap& extensions, bool srgb,
                           const std::string& where);

  // The images that the textures use, as indices into the document's; Texture::image counts these.
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
