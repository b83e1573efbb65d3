// fire3dv-inspect URI: what publishes there. Stands where a renderer would: over shared memory it looks on
// beside others, elsewhere it is the listener that simulators connect to.
#include <CLI/CLI.hpp>
#include <csignal>
#include <iostream>

#include "protocol/transport/clock.h"
#include "protocol/transport/open.h"
#include "tools/inspect/observer.h"

namespace {

volatile std::sig_atomic_t stop_requested = 0;

}  // namespace

int main(int argc, char** argv) {
  using namespace fire3dv;
  CLI::App app{
      "Says which streams are published at a URI: rates, what was lost, how old frames are when they come.",
      "fire3dv-inspect"};
  std::string uri;
  transport::ListenerOptions options;
  options.delivery = transport::Delivery::all;
  double seconds = 2;
  bool as_json = false;
  app.add_option("uri", uri, "shm://NAME, tcp://HOST:PORT, tls://HOST:PORT or udp://HOST:PORT")->required();
  app.add_option("--seconds", seconds, "how long to look")
      ->check(CLI::Range(0.1, 86400.0))
      ->capture_default_str();
  app.add_flag("--json", as_json, "one JSON object instead of text");
  app.add_flag("--insecure", options.insecure, "listen on addresses other than loopback, without protection");
  app.add_option("--key-file", options.key_file, "file of the key that udp:// publishers must have");
  app.add_option("--tls-cert", options.tls.certificate_file, "certificate for tls://, a PEM file");
  app.add_option("--tls-key", options.tls.key_file, "file of that certificate's key");
  app.add_option("--tls-client-ca", options.tls.client_ca_file,
                 "file of certificates that publishers' must be signed by");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  std::signal(SIGINT, [](int) { stop_requested = 1; });
  std::signal(SIGTERM, [](int) { stop_requested = 1; });

  auto link = transport::open_listener(uri, options);
  if (!link) {
    std::cerr << "fire3dv-inspect: " << link.error().message << '\n';
    return 1;
  }
  inspect::Observer observer;
  const int64_t until_ns = transport::monotonic_ns() + static_cast<int64_t>(seconds * 1e9);
  while (!stop_requested && transport::monotonic_ns() < until_ns) {
    (*link)->wait(std::chrono::milliseconds(20));
    observer.poll(**link);
  }
  std::cout << (as_json ? observer.json(**link) : observer.text(**link));
  return 0;
}
