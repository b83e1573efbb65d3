// Inspection program: fire3dv-inspect URI... shows statistics of live streams, FILE.mcap those of recordings.
// Over shared memory it reads in parallel with renderers; on other links it is the listener that simulators
// connect to.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <iostream>
#include <memory>
#include <vector>

#include "protocol/base/clock.h"
#include "protocol/base/command_line.h"
#include "protocol/base/text.h"
#include "protocol/transport/open.h"
#include "tools/inspect/observer.h"
#include "tools/inspect/recording.h"
#include "tools/listener_options.h"

namespace {

volatile std::sig_atomic_t stop_requested = 0;

// Returns 1 when a recording is unreadable or damaged; its readable part is still reported.
int inspect_recordings(const std::vector<std::string>& files, bool as_json, uint64_t memory_mb) {
  int result = 0;
  for (const std::string& file : files) {
    const auto recording = fire3dv::inspect::inspect_recording(file, {memory_mb << 20});
    if (!recording) {
      std::cerr << "fire3dv-inspect: " << fire3dv::terminal_text(recording.error().message) << '\n';
      result = 1;
      continue;
    }
    std::cout << (as_json ? recording->json : fire3dv::terminal_text(recording->text));
    if (!recording->sound) result = 1;
  }
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace fire3dv;
  CLI::App app{"Prints streams of links or recordings: rates, losses and ages of frames.", "fire3dv-inspect"};
  app.formatter(std::make_shared<HelpFormatter>("URI|FILE.mcap... [OPTIONS]"));
  app.footer("Details: man fire3dv-inspect.");
  app.set_help_flag("-h,--help", "print this help and exit");
  std::vector<std::string> uris;
  transport::ListenerOptions options;
  options.delivery = transport::Delivery::all;
  double seconds = 2;
  bool as_json = false;
  uint64_t memory_mb = 64;
  app.add_option("uri", uris, "shm://NAME, or tcp, tls, udp://HOST:PORT; or recordings")->required();
  app.add_option("--seconds", seconds, "duration of the measurement")
      ->check(number_between(0.1, 86400))
      ->type_name("N")
      ->capture_default_str();
  app.add_flag("--json", as_json, "print one JSON object for each URI, one a line");
  app.add_option("--memory-mb", memory_mb, "memory for the index of a recording, in MB")
      ->check(CLI::Range(16u, 16'384u).description(""))
      ->type_name("N")
      ->capture_default_str();
  add_listener_options(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  std::signal(SIGINT, [](int) { stop_requested = 1; });
  std::signal(SIGTERM, [](int) { stop_requested = 1; });

  const auto is_link = [](const std::string& name) { return name.find("://") != std::string::npos; };
  const auto links = std::count_if(uris.begin(), uris.end(), is_link);
  if (links == 0) return inspect_recordings(uris, as_json, memory_mb);
  if (static_cast<size_t>(links) != uris.size()) {
    std::cerr << "fire3dv-inspect: name links or recordings, not both\n";
    return 2;
  }

  struct Look {
    std::unique_ptr<transport::ListenerLink> link;
    inspect::Observer observer;
  };
  std::vector<Look> looks;
  for (const std::string& uri : uris) {
    auto link = transport::open_listener(uri, options);
    if (!link) {
      std::cerr << "fire3dv-inspect: " << link.error().message << '\n';
      return 1;
    }
    looks.push_back({std::move(*link), {}});
  }
  const auto share =
      std::chrono::nanoseconds(std::chrono::milliseconds(20)) / static_cast<int64_t>(looks.size());
  const int64_t until_ns = fire3dv::monotonic_ns() + static_cast<int64_t>(seconds * 1e9);
  while (!stop_requested && fire3dv::monotonic_ns() < until_ns) {
    for (Look& look : looks) {
      look.link->wait(share);
      look.observer.poll(*look.link);
    }
  }
  for (const Look& look : looks)
    std::cout << (as_json ? look.observer.json(*look.link) : look.observer.text(*look.link));
  return 0;
}
