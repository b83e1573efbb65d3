// fire3dv-mujoco MODEL.xml --to URI: a MuJoCo model, stepped and published to renderers.
#include <cstdio>
#include <exception>
#include <new>

#include "adapters/mujoco/run.h"

int main(int argc, char** argv) {
  int exit_code = 0;
  const auto options = fire3dv::mujoco::parse_options(argc, argv, &exit_code);
  if (!options) return exit_code;
  try {
    const fire3dv::Result<void> done = fire3dv::mujoco::run(*options);
    if (done) return 0;
    std::fprintf(stderr, "fire3dv-mujoco: %s\n", done.error().message.c_str());
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "fire3dv-mujoco: the model does not fit into memory\n");
  } catch (const std::exception& fault) {  // of a library
    std::fprintf(stderr, "fire3dv-mujoco: %s\n", fault.what());
  }
  return 1;
}
