// MuJoCo simulator of the example: a carousel whose gondolas hang on chains.
#include <cstdio>

#include "examples/two_simulators/carousel_model.h"
#include "examples/two_simulators/run.h"

int main(int argc, char** argv) {
  int exit_code = 0;
  const auto options = two_simulators::parse_options(
      argc, argv, "two_simulators_mujoco",
      "A carousel simulated by MuJoCo, published to FIRE-3DV renderers beside another simulator", &exit_code);
  if (!options) return exit_code;
  std::string error;
  const auto carousel = two_simulators::CarouselModel::make(&error);
  if (!carousel) {
    std::fprintf(stderr, "two_simulators_mujoco: %s\n", error.c_str());
    return 1;
  }
  return two_simulators::run(*carousel, "two_simulators_mujoco", *options);
}
