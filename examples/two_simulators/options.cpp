#include "examples/two_simulators/options.h"

#include <CLI/CLI.hpp>
#include <iostream>

namespace two_simulators {

std::optional<Options> parse_options(int argc, char** argv, const char* program, const char* about,
                                     int* exit_code) {
  Options options;
  CLI::App app{about, program};
  examples::add_link_options(app, options)->required();
  app.add_option("--seconds", options.seconds, "Simulated time to run for; 0: until interrupted")
      ->check(CLI::Range(0.0, 86400.0))
      ->capture_default_str();
  app.add_option("--publish-every", options.publish_every, "Publish every n-th of 240 steps a second only")
      ->check(CLI::Range(1u, 1'000'000u))
      ->capture_default_str();
  app.add_flag("--lockstep", options.lockstep,
               "Wait until a renderer has shown each frame, instead of keeping to the clock on the wall");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error, std::cout, std::cerr) == 0 ? 0 : 2;
    return std::nullopt;
  }
  return options;
}

}  // namespace two_simulators
