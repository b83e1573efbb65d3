// The part of a tool's command line that says who may publish to it: for tools that stand where a renderer
// would.
#pragma once

#include <CLI/CLI.hpp>

#include "protocol/transport/open.h"

namespace fire3dv {

inline void add_listener_options(CLI::App& app, transport::ListenerOptions& options) {
  app.add_flag("--insecure", options.insecure, "listen on addresses other than loopback, without protection");
  app.add_option("--key-file", options.key_file, "file of the key that udp:// publishers must have");
  app.add_option("--tls-cert", options.tls.certificate_file, "certificate for tls://, a PEM file");
  app.add_option("--tls-key", options.tls.key_file, "file of that certificate's key");
  app.add_option("--tls-client-ca", options.tls.client_ca_file,
                 "file of certificates that publishers' must be signed by");
}

}  // namespace fire3dv
