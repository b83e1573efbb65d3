// Factory of the listener of tcp:// and tls:// links.
#pragma once

#include <functional>
#include <memory>

#include "protocol/base/error.h"
#include "protocol/transport/core/uri.h"
#include "protocol/transport/link.h"
#include "protocol/transport/open.h"

namespace fire3dv::transport::tcp {

// Test hooks.
struct ListenerHooks {
  std::function<void()> before_handshake_step;  // on the TLS handshake thread
};

Result<std::unique_ptr<ListenerLink>> make_listener(const Uri& uri, const ListenerOptions& options,
                                                    ListenerHooks hooks = {});

}  // namespace fire3dv::transport::tcp
