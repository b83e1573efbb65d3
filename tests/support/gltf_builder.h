// Builder of small glTF files in memory. Tests can edit the JSON directly to produce invalid files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fire3dv::test {

enum ComponentType { kByte = 5120, kUnsignedByte, kShort, kUnsignedShort, kUnsignedInt = 5125, kFloat };

class GltfBuilder {
 public:
  GltfBuilder();

  nlohmann::json root;         // everything except for the buffer's length
  std::vector<std::byte> bin;  // buffers[0]

  // Each returns the index of the added element.
  size_t add_view(std::span<const std::byte> bytes, size_t byte_stride = 0);
  size_t add_accessor(size_t view, size_t count, const char* type, ComponentType component,
                      bool normalized = false);
  template <typename T>
  size_t add_data(const std::vector<T>& values, const char* type, ComponentType component, size_t components,
                  bool normalized = false) {
    return add_accessor(add_view(std::as_bytes(std::span(values))), values.size() / components, type,
                        component, normalized);
  }
  size_t add_positions(const std::vector<float>& xyz) { return add_data(xyz, "VEC3", kFloat, 3); }
  size_t add_indices(const std::vector<uint16_t>& indices) {
    return add_data(indices, "SCALAR", kUnsignedShort, 1);
  }
  // Adds a mesh of one primitive.
  size_t add_mesh(nlohmann::json primitive);
  // Adds the triangle (0,0,0), (1,0,0), (0,1,0).
  size_t add_triangle_mesh();
  // Adds a node to the scene, with "name" and the given members.
  size_t add_node(const std::string& name, nlohmann::json members = nlohmann::json::object());
  // Adds a child node that is not in the scene's list.
  size_t add_child(size_t parent, const std::string& name, nlohmann::json members = nlohmann::json::object());
  // Adds a material with this image as base colour; the image is in a buffer view.
  size_t add_textured_material(const std::vector<std::byte>& image);

  std::vector<std::byte> glb() const;
  std::string gltf(std::string_view buffer_uri) const;

 private:
  nlohmann::json whole() const;
  static size_t append(nlohmann::json& array, nlohmann::json value);
};

// One triangle in one node: a valid file.
GltfBuilder triangle_file();

// A PNG of one colour.
std::vector<std::byte> png(int width, int height, uint32_t rgba);

std::string data_uri(std::span<const std::byte> bytes);

// A temporary folder that is removed with the object.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path write(const std::string& name, std::span<const std::byte> bytes) const;
  std::filesystem::path write(const std::string& name, std::string_view text) const;

 private:
  std::filesystem::path path_;
};

}  // namespace fire3dv::test
