#include "examples/two_simulators/options.h"

#include <CLI/CLI.hpp>
#include <iostream>

namespace two_simulators {

std::optional<Options> parse_options(int argc, char** argv, const char* program, const char* about,
                                     int* exit_code) {
  Options options;
  CLI::App app{about, program};
  examples::set_help(app, "--to URI [OPTIONS]");
  examples::add_link_options(app, options)->required();
  constexpr const char* kSimulation = "Simulation";
  app.add_option("--seconds", options.seconds, "simulated duration; 0: until interrupted")
      ->type_name("S")
      ->group(kSimulation)
      ->check(examples::in_range(0.0, 86400.0))
      ->capture_default_str();
  app.add_option("--publish-every", options.publish_every, "publish every N-th of 240 steps per second")
      ->type_name("N")
      ->group(kSimulation)
      ->check(examples::in_range(1u, 1'000'000u))
      ->capture_default_str();
  app.add_flag("--lockstep", options.lockstep, "wait until a renderer has drawn each frame")
      ->group(kSimulation);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error, std::cout, std::cerr) == 0 ? 0 : 2;
    return std::nullopt;
  }
  return options;
}

}  // namespace two_simulators
