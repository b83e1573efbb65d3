// Gallery scene exporter: gallery_scenes FOLDER writes the scenes of docs/gallery.md and those with reference
// images to an existing folder.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <utility>
#include <vector>

#include "examples/gallery/reference_scenes.h"
#include "examples/gallery/scenes.h"

int main(int argc, char** argv) {
  if (argc != 2 || !std::filesystem::is_directory(argv[1])) {
    std::fprintf(stderr, "gallery_scenes: name a folder that exists: gallery_scenes FOLDER\n");
    return 2;
  }
  std::vector<gallery::SceneFile> scenes = gallery::make_scenes();
  for (gallery::SceneFile& scene : gallery::make_reference_scenes()) scenes.push_back(std::move(scene));
  for (const gallery::SceneFile& scene : scenes) {
    const std::filesystem::path path = std::filesystem::path(argv[1]) / scene.name;
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(scene.bytes.data()),
               static_cast<std::streamsize>(scene.bytes.size()));
    if (!file.flush()) {
      std::fprintf(stderr, "gallery_scenes: cannot write %s; is there space, and may you?\n", path.c_str());
      return 1;
    }
    std::printf("%s\n", path.c_str());
  }
  return 0;
}
