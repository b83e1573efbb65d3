// Digest of a scene's content.
#pragma once

#include <string>

#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// Equal scenes have equal digests: 32 hexadecimal digits over all members and arrays.
std::string content_digest(const Scene& scene);

}  // namespace fire3dv::scene
