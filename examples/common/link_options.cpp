#include "examples/common/link_options.h"

#include <CLI/CLI.hpp>

namespace examples {

CLI::Option* add_link_options(CLI::App& app, LinkOptions& options) {
  const auto add_file = [&](const char* name, std::string& file, const char* help) {
    app.add_option(name, file, help)->type_name("FILE");
  };
  CLI::Option* to =
      app.add_option(
             "--to", options.to,
             "Where to publish: shm://NAME, tcp://HOST:PORT, tls://HOST:PORT or udp://HOST:PORT; repeatable")
          ->type_name("URI")
          ->allow_extra_args(false);
  add_file("--key-file", options.security.key_file, "File of the key that udp:// renderers ask for");
  add_file("--tls-ca", options.security.tls_ca_file, "File of the certificates to trust for tls://");
  add_file("--tls-cert", options.security.tls_certificate_file,
           "Own certificate, for tls:// renderers that ask for one");
  add_file("--tls-key", options.security.tls_key_file, "File of that certificate's key");
  app.add_option("--ack-timeout", options.ack_timeout_s, "Seconds that --lockstep waits for one image")
      ->check(CLI::Range(0.1, 86400.0))
      ->capture_default_str();
  return to;
}

}  // namespace examples
