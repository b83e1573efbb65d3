// Factories of links by scheme. open.h selects one by URI.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "base/error.h"
#include "protocol/transport/core/address.h"
#include "protocol/transport/link.h"
#include "protocol/transport/open.h"

namespace fire3dv::transport::shm {

// Owns one segment, which any number of readers attach to.
Result<std::unique_ptr<PublisherLink>> make_publisher(const std::string& name,
                                                      const PublisherOptions& options);
// Reads the segment of one publisher at a time.
Result<std::unique_ptr<ListenerLink>> make_listener(const std::string& name, const ListenerOptions& options);

}  // namespace fire3dv::transport::shm

// tcp:// and tls://
namespace fire3dv::transport::tcp {

// Connects to one listener, with retries.
Result<std::unique_ptr<PublisherLink>> make_publisher(const Uri& uri, const PublisherOptions& options);

// Test hooks.
struct ListenerHooks {
  std::function<void()> before_handshake_step;  // on the TLS handshake thread
};
Result<std::unique_ptr<ListenerLink>> make_listener(const Uri& uri, const ListenerOptions& options,
                                                    ListenerHooks hooks = {});

}  // namespace fire3dv::transport::tcp

namespace fire3dv::transport::udp {

// Both also accept multicast groups.
Result<std::unique_ptr<PublisherLink>> make_publisher(const Uri& uri, const PublisherOptions& options);
Result<std::unique_ptr<ListenerLink>> make_listener(const Uri& uri, const ListenerOptions& options);

// Sends to a multicast group; there is no back channel. max_number: see Carousel.
Result<std::unique_ptr<PublisherLink>> make_group_publisher(const Uri& uri, const Address& group,
                                                            const PublisherOptions& options,
                                                            uint32_t max_number = uint32_t{1} << 31);
// Joins a multicast group and never sends.
Result<std::unique_ptr<ListenerLink>> make_group_listener(const Uri& uri, const Address& group,
                                                          const ListenerOptions& options);

}  // namespace fire3dv::transport::udp
