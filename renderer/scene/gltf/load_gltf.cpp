#include "renderer/scene/gltf/load_gltf.h"

#include <exception>
#include <new>

#include "renderer/scene/edits/deformed_vertices.h"
#include "renderer/scene/gltf/gltf_document.h"
#include "renderer/scene/gltf/gltf_parts.h"
#include "renderer/scene/gltf/meshes/gltf_skins.h"
#include "renderer/scene/model/bounds.h"
#include "renderer/scene/textures/images.h"

namespace fire3dv::scene {
namespace {

Result<std::vector<Image>> load_images(GltfDocument& document, const std::vector<uint32_t>& used,
                                       const LoadLimits& limits, const LoadProgress& progress) {
  std::vector<FileBytes> files;
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
  return decode_images(encoded, {limits.max_image_pixels, limits.reserve, limits.stop_requested},
                       [&](size_t done) {
                         if (progress) progress("images", done, encoded.size());
                       });
}

Result<Scene> load(Result<GltfDocument> document, const std::filesystem::path& source,
                   const LoadLimits& limits, const LoadProgress& progress) {
  if (!document) return document.error();
  Scene scene;
  scene.source = source;
  scene.warnings = std::move(document->warnings);
  auto used_images = add_materials(*document, scene);
  if (!used_images) return used_images.error();
  if (auto done = add_meshes(*document, limits, progress, scene); !done) return done.error();
  if (auto done = add_lights(*document, scene); !done) return done.error();
  if (auto done = add_cameras(*document, scene); !done) return done.error();
  auto node_of_source = add_nodes(*document, limits, scene);
  if (!node_of_source) return node_of_source.error();
  if (auto done = add_skins(*document, limits, *node_of_source, scene); !done) return done.error();
  if (auto done = add_animations(*document, limits, *node_of_source, scene); !done) return done.error();
  if (auto done = check_deformed_copies(scene); !done) return done.error();
  auto images = load_images(*document, *used_images, limits, progress);
  if (!images) return images.error();
  scene.images = std::move(*images);
  bound_deformed_primitives(scene);
  find_world_bounds(scene);
  return scene;
}

// Libraries and the allocator (for files that exceed this machine's memory) throw; converts to errors.
template <typename Load>
Result<Scene> guarded(const std::string& file, const Load& load_it) {
  try {
    Result<Scene> scene = load_it();
    if (scene) return scene;
    return Error{file + ": " + scene.error().message};
  } catch (const std::bad_alloc&) {
    return Error{file + ": it does not fit into memory"};
  } catch (const std::exception& error) {
    return Error{file + ": it cannot be read: " + error.what()};
  }
}

}  // namespace

Result<Scene> load_glb(std::span<const std::byte> file, const std::string& name, const LoadLimits& limits) {
  return guarded(name, [&] { return load(read_glb(file, limits), name, limits, {}); });
}

Result<Scene> load_gltf(const std::filesystem::path& path, const LoadLimits& limits,
                        const LoadProgress& progress, std::vector<SourceFile>* sources,
                        const StampedDigest* known) {
  return guarded(path.string(),
                 [&] { return load(open_gltf(path, limits, sources, known), path, limits, progress); });
}

}  // namespace fire3dv::scene
