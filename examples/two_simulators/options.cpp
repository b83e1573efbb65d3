#include "examples/two_simulators/options.h"

#include <CLI/CLI.hpp>
#include <iostream>

namespace two_simulators {

std::optional<Options> parse_options(int argc, char** argv, const char* program, const char* about,
                                     int* exit_code) {
  Options options;
  CLI::App app{about, program};
  app.add_option(
         "--to", options.to,
         "Where to publish: shm://NAME, tcp://HOST:PORT, tls://HOST:PORT or udp://HOST:PORT; repeatable")
      ->type_name("URI")
      ->allow_extra_args(false)
      ->required();
  app.add_option("--key-file", options.key_file, "File of the key that udp:// renderers ask for")
      ->type_name("FILE");
  app.add_option("--tls-ca", options.tls_ca, "File of the certificates to trust for tls://")
      ->type_name("FILE");
  app.add_option("--tls-cert", options.tls_certificate,
                 "Own certificate, for tls:// renderers that ask for one")
      ->type_name("FILE");
  app.add_option("--tls-key", options.tls_key, "File of that certificate's key")->type_name("FILE");
  app.add_option("--seconds", options.seconds, "Simulated time to run for; 0: until interrupted")
      ->check(CLI::Range(0.0, 86400.0))
      ->capture_default_str();
  app.add_option("--publish-every", options.publish_every, "Publish every n-th of 240 steps a second only")
      ->check(CLI::Range(1u, 1'000'000u))
      ->capture_default_str();
  app.add_flag("--lockstep", options.lockstep,
               "Wait until a renderer has shown each frame, instead of keeping to the clock on the wall");
  app.add_option("--ack-timeout", options.ack_timeout_s, "Seconds that --lockstep waits for one image")
      ->check(CLI::Range(0.1, 86400.0))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error, std::cout, std::cerr) == 0 ? 0 : 2;
    return std::nullopt;
  }
  return options;
}

}  // namespace two_simulators
