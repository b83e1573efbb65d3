// Recognition of files that are no glTF: names the format and the remedy.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "base/error.h"

namespace fire3dv::scene {

// Name of a format with its article, such as "a PNG image", and what to do with such a file.
struct FileFormat {
  std::string name;  // empty: unknown
  std::string remedy;
};

// Format of a file that is no glTF, by its first bytes, else by its name. Nothing for a GLB and for text that
// begins like JSON.
std::optional<FileFormat> foreign_format(std::span<const std::byte> bytes, const std::filesystem::path& file);

// True if the file begins as a binary glTF file. False for a file that cannot be read.
bool is_binary_gltf(const std::filesystem::path& file);

// A file that is no glTF by its first bytes: "an STL mesh, not glTF; ..." Nothing for a GLB and for text
// that begins like JSON, whatever the name is. file: the name, for formats without a signature; may be empty.
std::optional<std::string> describe_foreign_file(std::span<const std::byte> bytes,
                                                 const std::filesystem::path& file);

// Reads the first bytes only: an error for a file that cannot be opened or is no glTF, with its name.
Result<void> check_is_gltf(const std::filesystem::path& file);

}  // namespace fire3dv::scene
