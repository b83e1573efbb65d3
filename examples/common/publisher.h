// Publisher that sends the same frames to several streams. One thread.
#pragma once

#include <fire3dv/client.hpp>

#include <CLI/App.hpp>
#include <CLI/Validators.hpp>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace examples {

struct LinkOptions {
  std::vector<std::string> to;  // URIs
  fire3dv::Security security;
  double ack_timeout_s = 60;  // lockstep timeout
};

// Sets the format of --help: one line per option, in groups, at most 100 columns. usage: the arguments.
void set_help(CLI::App& app, const std::string& usage);

// A range that --help does not print.
template <typename T>
CLI::Validator in_range(T least, T most) {
  return CLI::Range(least, most).description("");
}

// Returns --to.
CLI::Option* add_link_options(CLI::App& app, LinkOptions& options);

class Publisher {
 public:
  // Functions return an error message, or nothing on success; client exceptions are converted.
  std::optional<std::string> open(const std::string& adapter_name, const std::vector<std::string>& uris,
                                  const fire3dv::Security& security);
  std::optional<std::string> describe(const fire3dv::Description& description);
  std::optional<std::string> publish(int64_t sim_time_ns, const std::vector<float>& poses,
                                     bool discontinuity);
  // Waits until every stream's last frame was shown. Returns early, without an error, once stop is set.
  std::optional<std::string> wait_shown(double timeout_s, const std::atomic<bool>& stop);

  struct Link {
    std::string uri;
    fire3dv_status status{};
  };
  std::vector<Link> poll();

 private:
  struct Target {
    std::string uri;
    fire3dv::Stream stream;
  };
  std::vector<Target> targets_;
  uint64_t sequence_ = 0;  // starts at 1 in the description's epoch, as in the library
};

}  // namespace examples
