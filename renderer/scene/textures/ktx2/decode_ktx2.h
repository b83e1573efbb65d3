// Transcoder of KTX 2.0 textures to 8-bit RGBA: ETC1S with BasisLZ, UASTC, R8G8B8 and R8G8B8A8, the latter
// three with or without Zstandard. Reads the largest mip level only.
#pragma once

#include <cstdint>
#include <vector>

#include "base/error.h"
#include "renderer/scene/textures/ktx2/ktx2_file.h"

namespace fire3dv::scene::ktx2 {

// Rows from the top, 4 bytes a texel, after swizzle and orientation. Besides the result it allocates at most
// 4 bytes a texel. Errors are sentences about "it"; std::bad_alloc means exhausted memory.
Result<std::vector<uint8_t>> decode_ktx2(const Ktx2File& file);

}  // namespace fire3dv::scene::ktx2
