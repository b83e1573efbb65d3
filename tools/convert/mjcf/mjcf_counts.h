// Validation of element counts in MJCF models and their files. libmujoco multiplies counts in 32 bits and
// uses mesh faces before it checks them; inputs that would make it access memory out of bounds are refused.
// Errors are sentence ends about the file.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "protocol/base/error.h"

namespace fire3dv::convert {

// Meshes and skins in MuJoCo's binary formats.
Result<void> check_msh(std::string_view bytes);
Result<void> check_skn(std::string_view bytes);

// Checks inline `vertex` and `face` attributes of a mesh or skin.
Result<void> check_inline_faces(const std::string& vertex, const std::string& face);

// Totals of all height fields and textures of a model.
class MjcfTotals {
 public:
  enum class Texture {
    flat,
    cube,
    further_side
  };  // further_side: another face of a cube that was counted
      // already

  // Adds a file that is used `times` times: PNG, or MuJoCo's own format.
  Result<void> add_field(std::string_view bytes, bool is_png, uint64_t times);
  Result<void> add_texture(std::string_view bytes, bool is_png, Texture kind, uint64_t times);
  // Adds fields and textures that the model generates.
  Result<void> add_field(int64_t rows, int64_t columns);
  Result<void> add_texture(int64_t width, int64_t height, Texture kind);

 private:
  uint64_t cells_ = 0, texture_bytes_ = 0;
};

}  // namespace fire3dv::convert
