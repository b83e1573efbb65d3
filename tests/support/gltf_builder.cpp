// In-memory glTF and GLB writer.
#include "tests/support/gltf_builder.h"

#include <unistd.h>

#include <atomic>
#include <fstream>

#include "base/glb.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#include <stb/stb_image_write.h>

namespace fire3dv::test {
namespace {

using nlohmann::json;

}  // namespace

GltfBuilder::GltfBuilder() {
  root["asset"]["version"] = "2.0";
  root["scene"] = 0;
  root["scenes"] = json::array({{{"nodes", json::array()}}});
}

size_t GltfBuilder::append(json& array, json value) {
  array.push_back(std::move(value));
  return array.size() - 1;
}

size_t GltfBuilder::add_view(std::span<const std::byte> bytes, size_t byte_stride) {
  bin.resize((bin.size() + 3) / 4 * 4);
  json view{{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", bytes.size()}};
  if (byte_stride != 0) view["byteStride"] = byte_stride;
  bin.insert(bin.end(), bytes.begin(), bytes.end());
  return append(root["bufferViews"], std::move(view));
}

size_t GltfBuilder::add_accessor(size_t view, size_t count, const char* type, ComponentType component,
                                 bool normalized) {
  json accessor{
      {"bufferView", view}, {"count", count}, {"type", type}, {"componentType", static_cast<int>(component)}};
  if (normalized) accessor["normalized"] = true;
  return append(root["accessors"], std::move(accessor));
}

size_t GltfBuilder::add_mesh(json primitive) {
  return append(root["meshes"], {{"primitives", json::array({std::move(primitive)})}});
}

size_t GltfBuilder::add_triangle_mesh() {
  const size_t positions = add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
  const size_t indices = add_indices({0, 1, 2});
  return add_mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}});
}

size_t GltfBuilder::add_node(const std::string& name, json members) {
  members["name"] = name;
  const size_t node = append(root["nodes"], std::move(members));
  root["scenes"][0]["nodes"].push_back(node);
  return node;
}

size_t GltfBuilder::add_child(size_t parent, const std::string& name, json members) {
  members["name"] = name;
  const size_t node = append(root["nodes"], std::move(members));
  root["nodes"][parent]["children"].push_back(node);
  return node;
}

size_t GltfBuilder::add_textured_material(const std::vector<std::byte>& image) {
  const size_t source = append(root["images"], {{"bufferView", add_view(image)}, {"mimeType", "image/png"}});
  const size_t texture = append(root["textures"], {{"source", source}});
  return append(root["materials"], {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}}});
}

json GltfBuilder::whole() const {
  json copy = root;
  if (!bin.empty() && !copy.contains("buffers"))
    copy["buffers"] = json::array({{{"byteLength", bin.size()}}});
  return copy;
}

std::vector<std::byte> GltfBuilder::glb() const {
  return base::make_glb(whole().dump(), bin);
}

std::string GltfBuilder::gltf(std::string_view buffer_uri) const {
  json copy = whole();
  copy["buffers"][0]["uri"] = buffer_uri;
  return copy.dump();
}

GltfBuilder triangle_file() {
  GltfBuilder builder;
  builder.add_node("triangle", {{"mesh", builder.add_triangle_mesh()}});
  return builder;
}

std::vector<std::byte> png(int width, int height, uint32_t rgba) {
  const std::vector<uint32_t> pixels(static_cast<size_t>(width) * static_cast<size_t>(height), rgba);
  std::vector<std::byte> bytes;
  stbi_write_png_to_func(
      [](void* to, void* data, int size) {
        const auto* first = static_cast<const std::byte*>(data);
        static_cast<std::vector<std::byte>*>(to)->insert(static_cast<std::vector<std::byte>*>(to)->end(),
                                                         first, first + size);
      },
      &bytes, width, height, 4, pixels.data(), width * 4);
  return bytes;
}

std::string data_uri(std::span<const std::byte> bytes) {
  static constexpr std::string_view kAlphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text = "data:application/octet-stream;base64,";
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<uint32_t>(bytes[i + k]) : 0);
    for (size_t k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? kAlphabet[group >> (18 - 6 * k) & 63] : '=';
    }
  }
  return text;
}

ScratchFolder::ScratchFolder() {
  static std::atomic<int> next{0};
  path_ = std::filesystem::temp_directory_path() /
          ("fire3dv-test-" + std::to_string(getpid()) + "-" + std::to_string(next++));
  std::filesystem::create_directories(path_);
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::filesystem::path ScratchFolder::write(const std::string& name, std::span<const std::byte> bytes) const {
  const std::filesystem::path file = path_ / name;
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return file;
}

std::filesystem::path ScratchFolder::write(const std::string& name, std::string_view text) const {
  return write(name, std::as_bytes(std::span(text)));
}

}  // namespace fire3dv::test
