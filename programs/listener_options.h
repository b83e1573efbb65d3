// Command-line options for tools that listen like a renderer: access control for publishers.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "base/command_line.h"
#include "protocol/transport/open.h"

namespace fire3dv {

inline void add_listener_options(CLI::App& app, transport::ListenerOptions& options) {
  OptionGroup group(app, "Security");
  group.add_flag("--insecure", options.insecure, "allow unprotected links beyond loopback");
  group.add("--key-file", options.key_file, "FILE", "udp: pre-shared key, 64 hexadecimal digits");
  group.add("--tls-cert", options.tls.certificate_file, "FILE", "tls: certificate of this listener (PEM)");
  group.add("--tls-key", options.tls.key_file, "FILE", "tls: private key of that certificate (PEM)");
  group.add("--tls-client-ca", options.tls.client_ca_file, "FILE",
            "tls: require client certificates of this CA");
}

}  // namespace fire3dv
