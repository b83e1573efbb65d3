// Writer of binary glTF 2.0 files (GLB): the binary buffer with its views, and the container. Callers write
// the JSON.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

namespace fire3dv::base {

class GlbBuffer {
 public:
  enum class Target : int { none = 0, array_buffer = 34962, element_array_buffer = 34963 };
  struct View {
    size_t offset = 0, bytes = 0;  // offset: a multiple of 4
    Target target = Target::none;
  };

  // Appends the bytes and returns the index of their view.
  size_t add_view(std::span<const std::byte> bytes, Target target = Target::none);

  const std::vector<View>& views() const { return views_; }
  const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  std::vector<View> views_;
  std::vector<std::byte> bytes_;
};

// Assembles a file from its JSON and the contents of buffer 0. Pads both chunks to 4 bytes; without buffer
// contents the file has no binary chunk. The file must be smaller than 4 GiB.
std::vector<std::byte> make_glb(std::string_view json, std::span<const std::byte> buffer);

}  // namespace fire3dv::base
