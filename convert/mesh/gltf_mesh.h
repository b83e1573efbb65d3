// glTF files as meshes of descriptions, by the renderer's loader: all that it supports of compression,
// textures, instancing and vertex colours.
#pragma once

#include <filesystem>

#include "base/error.h"
#include "convert/mesh/mesh_import.h"

namespace fire3dv::convert {

// file: regular file; the files that it names lie below its folder. Positions are metres, +Y up as in glTF,
// or +Z up with GltfUp::apply: (x, y, z) becomes (x, -z, y). Skins are in their rest pose. The error has no
// name of the file.
Result<ImportedMesh> import_gltf(const std::filesystem::path& file, const ImportRequest& request);

}  // namespace fire3dv::convert
