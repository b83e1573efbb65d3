// Listener of tcp:// and tls:// links.
#pragma once

#include <functional>
#include <memory>

#include "protocol/error.h"
#include "protocol/transport/link.h"
#include "protocol/transport/open.h"
#include "protocol/transport/uri.h"

namespace fire3dv::transport::tcp {

// For tests.
struct ListenerHooks {
  std::function<void()> before_handshake_step;  // on the thread that computes TLS handshakes
};

Result<std::unique_ptr<ListenerLink>> make_listener(const Uri& uri, const ListenerOptions& options,
                                                    ListenerHooks hooks = {});

}  // namespace fire3dv::transport::tcp
