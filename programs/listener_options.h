// Command-line options for tools that listen like a renderer: access control for publishers.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "protocol/transport/open.h"

namespace fire3dv {

inline void add_listener_options(CLI::App& app, transport::ListenerOptions& options) {
  constexpr const char* kGroup = "Security";
  const auto add_file = [&](const char* name, std::string& file, const char* text) {
    app.add_option(name, file, text)->type_name("FILE")->group(kGroup);
  };
  app.add_flag("--insecure", options.insecure, "allow unprotected links beyond loopback")->group(kGroup);
  add_file("--key-file", options.key_file, "udp: pre-shared key, 64 hexadecimal digits");
  add_file("--tls-cert", options.tls.certificate_file, "tls: certificate of this listener (PEM)");
  add_file("--tls-key", options.tls.key_file, "tls: private key of that certificate (PEM)");
  add_file("--tls-client-ca", options.tls.client_ca_file, "tls: require client certificates of this CA");
}

}  // namespace fire3dv
