// Scenes of docs/gallery.md: materials side by side, edges at many angles, shadows of two lights.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace gallery {

struct SceneFile {
  std::string name;  // file name with extension
  std::vector<std::byte> bytes;
};

std::vector<SceneFile> make_scenes();

}  // namespace gallery
