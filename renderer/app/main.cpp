#include <cstdio>
#include <exception>

#include "renderer/app/frame_loop.h"
#include "renderer/app/options.h"
#include "renderer/app/run.h"

int main(int argc, char** argv) {
  const std::variant<fire3dv::app::Options, int> options = fire3dv::app::parse_options(argc, argv);
  if (const int* exit_code = std::get_if<int>(&options)) return *exit_code;
  fire3dv::app::install_stop_signals();
  try {
    return fire3dv::app::run(std::get<fire3dv::app::Options>(options));
  } catch (
      const std::exception& failure) {  // of Vulkan, or out of memory: nothing that could be gone on from
    std::fprintf(stderr, "fire3dv: %s\n", failure.what());
    return 1;
  }
}
