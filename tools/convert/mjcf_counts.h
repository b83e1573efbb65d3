// Counts that an MJCF model, or a file that it names, gives of what it holds. libmujoco multiplies them in 32
// bits, then reads and writes by the product, and by faces of meshes before it looks at them. What it would
// leave its memory for is refused here. Errors are the end of a sentence about the file.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "protocol/error.h"

namespace fire3dv::convert {

// Meshes and skins in MuJoCo's own formats.
Result<void> check_msh(std::string_view bytes);
Result<void> check_skn(std::string_view bytes);

// What a mesh or skin of the model has for `vertex` and `face`.
Result<void> check_own_faces(const std::string& vertex, const std::string& face);

// All height fields and textures of a model together.
class MjcfAmounts {
 public:
  enum class Texture { flat, cube, further_side };  // the last: of a cube that was counted already

  // A file that is used so often; MuJoCo's own format where it is no PNG.
  Result<void> add_field(std::string_view bytes, bool is_png, uint64_t times);
  Result<void> add_texture(std::string_view bytes, bool is_png, Texture kind, uint64_t times);
  // What the model itself is to make.
  Result<void> add_field(int64_t rows, int64_t columns);
  Result<void> add_texture(int64_t width, int64_t height, Texture kind);

 private:
  uint64_t cells_ = 0, texture_bytes_ = 0;
};

}  // namespace fire3dv::convert
