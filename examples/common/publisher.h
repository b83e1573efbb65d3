// Publisher that sends the same frames to several streams, with its command-line options and status line. One
// thread.
#pragma once

#include <fire3dv/markers.h>
#include <fire3dv/scalars.h>
#include <CLI/App.hpp>
#include <CLI/Validators.hpp>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <fire3dv/client.hpp>
#include <optional>
#include <string>
#include <vector>

namespace examples {

struct Image;  // materials.h

struct LinkOptions {
  std::vector<std::string> to;  // URIs
  fire3dv::Security security;
  double ack_timeout_s = 60;  // lockstep timeout
};

// Sets the format of --help (one line per option, in groups, at most 100 columns) and --version. usage: the
// arguments.
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
  // Sets a marker, which the next frame shows. Its arrays are copied.
  std::optional<std::string> set_marker(const char* name, const fire3dv_marker& marker);
  // Declares a group of scalars, and sets its values at a time. Arrays are copied.
  std::optional<std::string> declare_scalars(const char* group, const fire3dv_scalars& scalars);
  std::optional<std::string> set_scalars(const char* group, int64_t sim_time_ns,
                                         const std::vector<double>& values);
  // Replaces vertices and normals of a node's mesh: x y z of each. The arrays are copied.
  std::optional<std::string> set_vertices(const char* node, const std::vector<float>& positions,
                                          const std::vector<float>& normals);
  // Fills an image of the last published frame, by the first stream's renderer. image: has its size.
  std::optional<std::string> request_picture(const std::string& camera, double timeout_s,
                                             const std::atomic<bool>& stop, Image& image);
  // Waits until every stream's last frame was shown. Returns early, without an error, once stop is set. A
  // wait of more than three seconds is logged, once for each stream.
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
    bool has_told_wait = false;
  };
  std::vector<Target> targets_;
  uint64_t sequence_ = 0;  // starts at 1 in the description's epoch, as in the library
};

// Status line of a simulator, printed once a second.

using Clock = std::chrono::steady_clock;

class Report {
 public:
  void add_step(Clock::duration time) { step_us_.push_back(microseconds(time)); }
  void add_publish(Clock::duration time) { publish_us_.push_back(microseconds(time)); }
  bool due() const { return Clock::now() - since_ >= std::chrono::seconds(1); }
  // Prints the statistics since the last call and resets them.
  void print(double sim_time_s, const std::vector<Publisher::Link>& links);

 private:
  static double microseconds(Clock::duration time) {
    return std::chrono::duration<double, std::micro>(time).count();
  }

  Clock::time_point since_ = Clock::now();
  std::vector<double> step_us_;
  std::vector<double> publish_us_;
  std::vector<std::string> printed_messages_;  // last welcome message per link, so that each is printed once
};

}  // namespace examples
