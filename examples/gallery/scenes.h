// The scenes of docs/gallery.md: materials side by side, edges at every angle, shadows of two lights.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace gallery {

struct SceneFile {
  std::string name;  // of the file, with its extension
  std::vector<uint8_t> bytes;
};

std::vector<SceneFile> make_scenes();

}  // namespace gallery
