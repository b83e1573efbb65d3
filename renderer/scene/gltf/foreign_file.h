// Recognition of files that are no glTF: names the format and the remedy.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "protocol/base/error.h"

namespace fire3dv::scene {

// A file that is no glTF by its first bytes: "an STL mesh, not glTF; ..." Nothing for a GLB and for text
// that begins like JSON, whatever the name is. file: the name, for formats without a signature; may be empty.
std::optional<std::string> describe_foreign_file(std::span<const std::byte> bytes,
                                                 const std::filesystem::path& file);

// Reads the first bytes only: an error for a file that cannot be opened or is no glTF, with its name.
Result<void> check_is_gltf(const std::filesystem::path& file);

}  // namespace fire3dv::scene
