// Reader of SDF files through libsdformat, as plain data. It runs in a process of its own first: libsdformat
// dereferences null pointers and overflows the stack on some damaged files.
#pragma once

#include <string>
#include <vector>

#include "base/error.h"
#include "convert/sdf/files/sdf_documents.h"
#include "convert/sdf/sdf_scene.h"

namespace fire3dv::convert {

// copy: path of SdfDocuments::open(). warnings: receives messages of libsdformat and what is left out.
Result<SdfScene> read_sdf_scene(const std::string& copy, const SdfDocuments& documents,
                                std::vector<std::string>& warnings);

}  // namespace fire3dv::convert
