#include "examples/common/link_options.h"

#include <CLI/CLI.hpp>

namespace examples {

CLI::Option* add_link_options(CLI::App& app, LinkOptions& options) {
  const auto add_file = [&](const char* name, std::string& file, const char* help) {
    app.add_option(name, file, help)->type_name("FILE");
  };
  CLI::Option* to = app.add_option("--to", options.to, "shm://NAME, or tcp, tls, udp://HOST:PORT; repeatable")
                        ->type_name("URI")
                        ->allow_extra_args(false);
  add_file("--key-file", options.security.key_file, "udp: pre-shared key, 64 hexadecimal digits");
  add_file("--tls-ca", options.security.tls_ca_file, "tls: trusted certificates (PEM)");
  add_file("--tls-cert", options.security.tls_certificate_file, "tls: client certificate (PEM)");
  add_file("--tls-key", options.security.tls_key_file, "tls: private key of that certificate");
  app.add_option("--ack-timeout", options.ack_timeout_s, "Limit of one wait of --lockstep")
      ->check(CLI::Range(0.1, 86400.0))
      ->capture_default_str();
  return to;
}

}  // namespace examples
