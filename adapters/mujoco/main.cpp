// MuJoCo simulator for renderers: fire3dv-mujoco MODEL.xml --to URI steps and publishes a model.
#include <exception>
#include <new>

#include "adapters/mujoco/run.h"

int main(int argc, char** argv) {
  using namespace fire3dv::mujoco;
  int exit_code = 0;
  const auto options = parse_options(argc, argv, &exit_code);
  if (!options) return exit_code;
  try {
    const fire3dv::Result<void> done = run(*options);
    if (done) return 0;
    log_line(done.error().message);
  } catch (const std::bad_alloc&) {
    log_line("the model does not fit into memory");
  } catch (const std::exception& fault) {  // thrown by a library
    log_line(fault.what());
  }
  return 1;
}
