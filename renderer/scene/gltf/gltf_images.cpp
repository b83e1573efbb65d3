#include <span>
#include <string>
#include <utility>
#include <vector>

#include "renderer/scene/gltf/gltf_document.h"
#include "renderer/scene/gltf/gltf_parts.h"
#include "renderer/scene/model/scene_fields.h"
#include "renderer/scene/textures/images.h"

namespace fire3dv::scene {
namespace {

// Example: images[2] "wood.png".
std::string name_in_messages(const ImageSource& source, uint32_t index) {
  const bool is_file = !source.uri.empty() && !source.uri.starts_with("data:");
  const std::string& name = is_file ? source.uri : source.name;
  return element("images", index) + (name.empty() ? "" : " " + quote(name));
}

// Reads the bytes into `image`, or the reason why they are not there into its read_error. files: storage.
void read_bytes(const GltfDocument& document, const ImageSource& source, const LoadLimits& limits,
                EncodedImage& image, std::vector<FileBytes>& files) {
  if (source.buffer_view >= 0) {
    const auto bytes = buffer_view_bytes(document, source.buffer_view, "its bytes");
    if (bytes) {
      image.bytes = *bytes;
    } else {
      image.read_error = bytes.error().message;
    }
  } else if (source.uri.empty()) {
    image.read_error = "it has neither a uri nor a bufferView";
  } else if (auto file = document.folder.read(source.uri, limits.max_file_bytes); file) {
    files.push_back(std::move(*file));
    image.bytes = files.back().view();
  } else {
    image.read_error = file.error().message;
  }
}

// Takes a placeholder out of materials where it is no colour: as a normal map or a factor it would only look
// like another material.
void leave_out_data(const std::vector<bool>& is_placeholder, Scene& scene) {
  for (Material& material : scene.materials) {
    visit_textures(material, [&](TextureRef& ref) {
      if (ref.texture == kNone) return;
      const Texture& texture = scene.textures[ref.texture];
      if (!texture.srgb && is_placeholder[texture.image]) ref = TextureRef{};
    });
  }
}

}  // namespace

int image_of(const tinygltf::Texture& texture) {
  for (const char* name : kImageExtensions) {
    const auto extension = texture.extensions.find(name);
    if (extension == texture.extensions.end()) continue;
    if (const int image = index_or(extension->second, "source", -1); image >= 0) return image;
  }
  return texture.source;
}

Result<void> add_images(const GltfDocument& document, std::span<const uint32_t> used,
                        const LoadLimits& limits, const LoadProgress& progress, Scene& scene) {
  std::vector<FileBytes> files;
  std::vector<EncodedImage> encoded;
  for (const uint32_t index : used) {
    const ImageSource& source = document.images[index];
    EncodedImage& image = encoded.emplace_back();
    image.name = source.name;
    image.where = name_in_messages(source, index);
    read_bytes(document, source, limits, image, files);
  }
  for (const Texture& texture : scene.textures)
    (texture.srgb ? encoded[texture.image].is_color : encoded[texture.image].is_data) = true;
  const auto reserve = [&limits](uint64_t bytes) -> Result<void> {
    if (bytes > limits.max_decoded_image_bytes)
      return Error{"decoded they take more than " + std::to_string(limits.max_decoded_image_bytes >> 20) +
                   " MiB: make them smaller, or raise the limit (fire3dv-drake --max-images)"};
    return limits.reserve ? limits.reserve(bytes) : Result<void>();
  };
  auto decoded =
      decode_images(encoded, {limits.max_image_pixels, reserve, limits.stop_requested}, [&](size_t done) {
        if (progress) progress("images", done, encoded.size());
      });
  if (!decoded) return decoded.error();
  scene.images = std::move(decoded->images);
  for (std::string& warning : decoded->warnings) scene.warnings.push_back(std::move(warning));
  leave_out_data(decoded->is_placeholder, scene);
  return {};
}

}  // namespace fire3dv::scene
