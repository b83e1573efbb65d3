#include "renderer/scene/load_gltf.h"

#include <exception>
#include <limits>
#include <new>

#include "renderer/scene/gltf_document.h"
#include "renderer/scene/gltf_lights_cameras.h"
#include "renderer/scene/gltf_materials.h"
#include "renderer/scene/gltf_meshes.h"
#include "renderer/scene/gltf_nodes.h"
#include "renderer/scene/images.h"

namespace fire3dv::scene {
namespace {

Result<std::vector<Image>> load_images(GltfDocument& document, const std::vector<uint32_t>& used,
                                       const LoadLimits& limits, const LoadProgress& progress) {
  std::vector<Bytes> files;
  std::vector<EncodedImage> encoded;
  for (const uint32_t index : used) {
    const ImageSource& source = document.images[index];
    EncodedImage image{source.name, element("images", index), {}};
    if (!source.uri.empty()) {
      auto file = document.folder.read(source.uri, limits.max_file_bytes);
      if (!file) return Error{image.where + ": " + file.error().message};
      files.push_back(std::move(*file));
      image.bytes = files.back().view();
    } else {
      auto bytes = buffer_view_bytes(document, source.buffer_view, image.where);
      if (!bytes) return bytes.error();
      image.bytes = *bytes;
    }
    encoded.push_back(std::move(image));
  }
  return decode_images(encoded, limits.max_image_pixels, [&](size_t done) {
    if (progress) progress("images", done, encoded.size());
  });
}

void find_world_bounds(Scene& scene) {
  glm::vec3 low(std::numeric_limits<float>::max()), high(std::numeric_limits<float>::lowest());
  bool any = false;
  for (const Node& node : scene.nodes) {
    if (node.mesh == kNone) continue;
    const Mesh& mesh = scene.meshes[node.mesh];
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
      const Primitive& primitive = scene.primitives[p];
      for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 local((corner & 1) ? primitive.bounds_max.x : primitive.bounds_min.x,
                              (corner & 2) ? primitive.bounds_max.y : primitive.bounds_min.y,
                              (corner & 4) ? primitive.bounds_max.z : primitive.bounds_min.z);
        const glm::vec3 world(node.world_from_node * glm::vec4(local, 1));
        low = glm::min(low, world);
        high = glm::max(high, world);
        any = true;
      }
    }
  }
  if (!any) return;
  scene.bounds_min = low;
  scene.bounds_max = high;
}

Result<Scene> load(const std::filesystem::path& path, const LoadLimits& limits,
                   const LoadProgress& progress) {
  auto document = open_gltf(path, limits);
  if (!document) return document.error();
  Scene scene;
  scene.source = path;
  scene.warnings = std::move(document->warnings);
  auto used_images = add_materials(*document, scene);
  if (!used_images) return used_images.error();
  if (auto done = add_meshes(*document, limits, progress, scene); !done) return done.error();
  if (auto done = add_lights(*document, scene); !done) return done.error();
  if (auto done = add_cameras(*document, scene); !done) return done.error();
  if (auto done = add_nodes(*document, limits, scene); !done) return done.error();
  auto images = load_images(*document, *used_images, limits, progress);
  if (!images) return images.error();
  scene.images = std::move(*images);
  find_world_bounds(scene);
  return scene;
}

}  // namespace

Result<Scene> load_gltf(const std::filesystem::path& path, const LoadLimits& limits,
                        const LoadProgress& progress) {
  const std::string file = path.string();
  // The libraries below throw, and so does the allocator for a file that is too large for this machine.
  try {
    auto scene = load(path, limits, progress);
    if (scene) return scene;
    return Error{file + ": " + scene.error().message};
  } catch (const std::bad_alloc&) {
    return Error{file + ": it does not fit into memory"};
  } catch (const std::exception& error) {
    return Error{file + ": it cannot be read: " + error.what()};
  }
}

}  // namespace fire3dv::scene
