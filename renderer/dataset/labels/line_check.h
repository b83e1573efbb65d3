// Check of a line of frames.jsonl, which another program may have written.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "renderer/dataset/labels/description.h"

namespace fire3dv::dataset {

// True if the line has all members that add_json() writes, with their types and numbers of elements, and
// names instances of the description only.
bool is_image_line(const nlohmann::json& line, const Description& description);

}  // namespace fire3dv::dataset
