// Scene exporter of the example: two_simulators_scene FILE.glb writes the scene that both simulators move.
#include <cstdio>

#include "examples/two_simulators/scene_file.h"

int main(int argc, char** argv) {
  if (argc != 2 || argv[1][0] == '-') {
    std::fprintf(stderr, "two_simulators_scene: name the file to write: two_simulators_scene FILE.glb\n");
    return 2;
  }
  if (const auto error = two_simulators::write_scene(argv[1])) {
    std::fprintf(stderr, "two_simulators_scene: %s\n", error->c_str());
    return 1;
  }
  return 0;
}
