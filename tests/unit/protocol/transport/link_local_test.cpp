// Test of IPv6 link-local addresses (fe80::) with their interface name (scope id).
#include <ifaddrs.h>
#include <netinet/in.h>

#include "protocol/transport/core/address.h"
#include "tests/unit/protocol/transport/network_namespace.h"
#include "tests/unit/protocol/transport/secure_fixture.h"

namespace fire3dv::transport::test {
namespace {

TEST(LinkLocal, LinksAcceptInterfaceSuffix) {
  const Secured secured;
  const std::string host = "[" + std::string(OwnNetwork::kLinkLocal) + "%" + OwnNetwork::interface() + "]";
  if (OwnNetwork::interface() != "f3d0") GTEST_SKIP() << "needs a namespace with a network of its own";
  for (const std::string scheme : {"tcp", "udp"}) {
    SCOPED_TRACE(scheme);
    EXPECT_FALSE(open_listener(scheme + "://" + host + ":0").ok()) << "it is no loopback address";
    ListenerOptions options;
    options.insecure = true;
    Listener listener(scheme + "://" + host + ":0", options);
    EXPECT_NE(listener.link->uri().find(host), std::string::npos) << listener.link->uri();
    auto publisher = open_publisher_or_fail(listener.link->uri());
    ASSERT_TRUE(publisher->set_description(bytes_of("d")));
    EXPECT_TRUE(publish_until_seen(*publisher, listener, "pose"));
    listener.link->send(listener.peer(), bytes_of("reply"));
    EXPECT_TRUE(poll_until_reply(*publisher, "reply"));
  }
}

TEST(LinkLocal, SameAddressOnTwoLinks) {
  const auto address = [](uint32_t scope) {
    Address made;
    auto& v6 = reinterpret_cast<sockaddr_in6&>(made.storage);
    v6.sin6_family = AF_INET6;
    v6.sin6_addr.s6_addr[0] = 0xfe;
    v6.sin6_addr.s6_addr[1] = 0x80;
    v6.sin6_port = htons(7);
    v6.sin6_scope_id = scope;
    made.length = sizeof v6;
    return made;
  };
  EXPECT_TRUE(address(2) == address(2));
  EXPECT_FALSE(address(2) == address(3));
  EXPECT_EQ(address(3).text(), "[fe80::%3]:7");
}

}  // namespace
}  // namespace fire3dv::transport::test
