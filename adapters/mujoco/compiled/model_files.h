// Files of an MJCF model, resolved and validated before libmujoco opens them itself: dependencies, element
// counts and indices.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "convert/model.h"

namespace fire3dv::convert {

// Refuses pipes and devices, which would block, and files outside the allowed folders.
// Returns all paths where libmujoco may look for files: the model, its includes, then others. Fails where an
// existing one lies, with links resolved, outside the model's folder and `folders`.
Result<Sources> mjcf_files(const std::filesystem::path& model,
                           const std::vector<std::filesystem::path>& folders = {});

// Validation of contents, in file_checks.cpp. libmujoco multiplies counts in 32 bits and uses mesh faces
// before it checks them; inputs that would make it access memory out of bounds are refused. Errors are
// sentence ends about the file.

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

// OBJ meshes. libmujoco's OBJ parser does not check the indices of faces, lines
// and points and would read out of bounds. It also opens material files (MTL), though it needs none of them.

// text: contents of the file.
Result<void> check_obj_faces(std::string_view text);

// Returns the names in the text. Parsers differ on a backslash before a blank, so both readings are included.
Result<std::vector<std::string>> obj_material_files(std::string_view text);

// Returns the paths that the parser tries for a mesh at `mesh`: in the folder before the last slash or
// backslash, which it splits at colons.
std::vector<std::filesystem::path> obj_material_paths(const std::string& mesh, const std::string& name);

}  // namespace fire3dv::convert
