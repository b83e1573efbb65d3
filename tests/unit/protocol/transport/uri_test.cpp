// Test of link URIs: forms, options, and refusals.
#include "protocol/transport/core/address.h"

#include <gtest/gtest.h>

namespace fire3dv::transport {
namespace {

TEST(Uri, SharedMemory) {
  const auto uri = parse_uri("shm://Robot_1.left-arm");
  ASSERT_TRUE(uri.ok());
  EXPECT_EQ(uri->scheme, Uri::Scheme::shm);
  EXPECT_EQ(uri->name, "Robot_1.left-arm");
  EXPECT_TRUE(parse_uri("shm://" + std::string(64, 'a')).ok());
}

TEST(Uri, HostAndPort) {
  const auto tcp = parse_uri("tcp://127.0.0.1:7345");
  ASSERT_TRUE(tcp.ok());
  EXPECT_EQ(tcp->scheme, Uri::Scheme::tcp);
  EXPECT_EQ(tcp->host, "127.0.0.1");
  EXPECT_EQ(tcp->port, 7345);
  const auto udp = parse_uri("udp://[fe80::1%eth0]:65535");
  ASSERT_TRUE(udp.ok());
  EXPECT_EQ(udp->scheme, Uri::Scheme::udp);
  EXPECT_EQ(udp->host, "fe80::1%eth0");
  EXPECT_EQ(udp->port, 65535);
  EXPECT_EQ(parse_uri("tcp://localhost:0")->port, 0);
}

TEST(Uri, OptionsOfUdp) {
  const auto uri = parse_uri("udp://239.1.2.3:7345?mtu=8952&ttl=4&interface=eth0.7");
  ASSERT_TRUE(uri.ok()) << uri.error().message;
  EXPECT_EQ(uri->host, "239.1.2.3");
  EXPECT_EQ(uri->port, 7345);
  EXPECT_EQ(uri->mtu, 8952);
  EXPECT_EQ(uri->ttl, 4);
  EXPECT_EQ(uri->interface, "eth0.7");
  EXPECT_EQ(parse_uri("udp://[ff15::1]:1?mtu=576")->mtu, 576);
  EXPECT_FALSE(uri->parity_percent);
  EXPECT_FALSE(parse_uri("udp://a:1?parity=auto")->parity_percent);
  EXPECT_EQ(parse_uri("udp://a:1?parity=off")->parity_percent, 0);
  EXPECT_EQ(parse_uri("udp://a:1?mtu=576&parity=200&ttl=1")->parity_percent, 200);
  for (const char* text : {"udp://[ff15::1%lo]:1?ttl=255", "udp://a:1?mtu=9000", "udp://a:0",
                           "udp://a:1?parity=off", "udp://a:1?mtu=576&parity=25&ttl=1"})
    EXPECT_EQ(uri_text(*parse_uri(text)), text);
}

TEST(Uri, EveryRefusalNamesUriAndForms) {
  const std::string nul("tcp://a\0b:1", 11);
  for (const std::string& text : {std::string(),
                                  std::string("demo"),
                                  std::string("shm:/demo"),
                                  std::string("shm://"),
                                  std::string("shm://.hidden"),
                                  std::string("shm://a/b"),
                                  std::string("shm://../x"),
                                  std::string("shm://a b"),
                                  "shm://" + std::string(65, 'a'),
                                  std::string("http://a:1"),
                                  std::string("tcp://"),
                                  std::string("tcp://a"),
                                  std::string("tcp://:1"),
                                  std::string("tcp://a:"),
                                  std::string("tcp://a:65536"),
                                  std::string("tcp://a:-1"),
                                  std::string("tcp://a:1x"),
                                  std::string("tcp://a:1/x"),
                                  std::string("tcp://::1:5"),
                                  std::string("udp://[::1:5"),
                                  std::string("udp://[::1]"),
                                  std::string("udp://[]:1"),
                                  std::string("tcp://a;b:1"),
                                  std::string("tcp://a:1?mtu=1000"),
                                  std::string("udp://a:1?parity="),
                                  std::string("udp://a:1?parity=0"),
                                  std::string("udp://a:1?parity=201"),
                                  std::string("udp://a:1?parity=on"),
                                  std::string("udp://a:1?parity=auto&parity=off"),
                                  std::string("udp://a:1?"),
                                  std::string("udp://a:1?mtu"),
                                  std::string("udp://a:1?mtu="),
                                  std::string("udp://a:1?mtu=575"),
                                  std::string("udp://a:1?mtu=9001"),
                                  std::string("udp://a:1?mtu=99999"),
                                  std::string("udp://a:1?mtu=1000&mtu=1000"),
                                  std::string("udp://a:1?mtu=1000&"),
                                  std::string("udp://a:1?ttl=0"),
                                  std::string("udp://a:1?ttl=256"),
                                  std::string("udp://a:1?interface="),
                                  std::string("udp://a:1?interface=a/b"),
                                  std::string("udp://a:1?interface=0123456789abcdef"),
                                  std::string("udp://a:1?\x1b[2J=1"),
                                  nul,
                                  "tcp://" + std::string(600, 'a') + ":1",
                                  std::string("\x1b[2J://x")}) {
    const auto uri = parse_uri(text);
    ASSERT_FALSE(uri.ok()) << text;
    EXPECT_NE(uri.error().message.find("is not a link"), std::string::npos) << uri.error().message;
    EXPECT_NE(uri.error().message.find("shm://NAME"), std::string::npos) << uri.error().message;
    EXPECT_LT(uri.error().message.size(), 300u);
    for (const char c : uri.error().message) EXPECT_TRUE(c >= 0x20 && c <= 0x7e);
  }
}

}  // namespace
}  // namespace fire3dv::transport
