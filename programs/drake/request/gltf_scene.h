// Scene of a render request, split into constant content and the transforms of one image.
//
// Drake sends a whole glTF file for each image. From image to image only the transforms of nodes and the
// camera change. The content's digest is therefore the key under which a loaded scene is cached.
//
// Drake's world is Z up although glTF is Y up. Root nodes and the camera are turned so that Z points to this
// renderer's up direction, +Y; the turn is exact.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/digest.h"
#include "base/error.h"
#include "programs/drake/request/form.h"

namespace fire3dv::drake {

using Rgb8 = std::array<uint8_t, 3>;

class GltfScene {
 public:
  // Only data: URIs are accepted. Depth and label scenes lose their materials. Materials are double-sided, as
  // Drake's own renderer draws them.
  static Result<GltfScene> read(std::string_view gltf, ImageType type);

  const Digest& content() const { return content_; }
  uint64_t bytes() const { return bytes_; }  // of the file
  // By index of the glTF node. Roots are turned.
  const std::vector<glm::dmat4>& parent_from_node() const { return parent_from_node_; }
  const glm::dmat4& world_from_camera() const { return world_from_camera_; }
  // Label images: colour of each glTF node's mesh; white, Drake's "don't care", where it has none.
  const std::vector<Rgb8>& label_of_node() const { return label_of_node_; }

  // A .glb of content and transforms, once. Each node's name is its index.
  std::vector<std::byte> take_glb();

 private:
  Result<void> read_transforms();
  Result<void> read_labels();
  Result<void> read_uris(const std::vector<std::string_view>& data_uris);
  Result<void> find_camera();
  void simplify_materials(ImageType type);

  nlohmann::json document_;        // without transforms, names, cameras and URIs
  std::vector<std::string> uris_;  // of buffers, then of images, in order
  Digest content_{};
  uint64_t bytes_ = 0;
  std::vector<glm::dmat4> parent_from_node_;
  glm::dmat4 world_from_camera_{1};
  std::vector<Rgb8> label_of_node_;
};

}  // namespace fire3dv::drake
