// Fixture of TLS and keyed UDP links, with credentials generated for the test.
#pragma once

#include "tests/support/certificates.h"
#include "tests/unit/protocol/transport/link_fixture.h"

namespace fire3dv::transport::test {

struct Secured {
  fire3dv::test::Credentials credentials;
  fire3dv::test::Credentials::Identity authority = credentials.authority("authority");
  fire3dv::test::Credentials::Identity server =
      credentials.identity("server", "IP:127.0.0.1,IP:::1,DNS:localhost", authority);

  ListenerOptions tls_listener() const {
    ListenerOptions options;
    options.tls.certificate_file = server.certificate_file;
    options.tls.key_file = server.key_file;
    return options;
  }
  PublisherOptions tls_publisher() const {
    PublisherOptions options;
    options.tls.ca_file = authority.certificate_file;
    return options;
  }
  ListenerOptions keyed_listener(char digit) const {
    ListenerOptions options;
    options.key_file = credentials.key(std::string("listener-") + digit, digit);
    return options;
  }
  PublisherOptions keyed_publisher(char digit) const {
    PublisherOptions options;
    options.key_file = credentials.key(std::string("publisher-") + digit, digit);
    return options;
  }
};

inline uint64_t rejected(const LinkStats& stats, Cause cause) {
  return stats.rejected_by_cause[static_cast<size_t>(cause)];
}

// Waits until the publisher reports a problem.
inline std::string struct_error(PublisherLink& publisher) {
  const auto until = std::chrono::steady_clock::now() + kHangLimit;
  while (publisher.problem().empty() && std::chrono::steady_clock::now() < until) ::usleep(1000);
  return publisher.problem();
}

}  // namespace fire3dv::transport::test
