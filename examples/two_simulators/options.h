// The command line of both programs.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace two_simulators {

struct Options {
  std::vector<std::string> to;
  std::string key_file, tls_ca, tls_certificate, tls_key;  // files, for links that keep strangers out
  double seconds = 0;                                      // 0: until interrupted
  uint32_t publish_every = 1;
  bool lockstep = false;
  double ack_timeout_s = 60;
};

// Nothing: leave with *exit_code, which is 0 after --help and 2 after a mistake; the text has been printed.
std::optional<Options> parse_options(int argc, char** argv, const char* program, const char* about,
                                     int* exit_code);

}  // namespace two_simulators
