// Bullet simulator of the example: a tray of objects that a blade stirs.
#include "examples/two_simulators/heap.h"
#include "examples/two_simulators/run.h"

int main(int argc, char** argv) {
  int exit_code = 0;
  const auto options = two_simulators::parse_options(
      argc, argv, "two_simulators_bullet",
      "A heap simulated by Bullet, published to FIRE-3DV renderers beside another simulator", &exit_code);
  if (!options) return exit_code;
  two_simulators::Heap heap;
  return two_simulators::run(heap, "two_simulators_bullet", *options);
}
