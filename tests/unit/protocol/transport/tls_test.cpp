// Test of tls:// links: authentication of both sides, refusals with reasons, and pending handshakes.
#include <sys/wait.h>
#include <unistd.h>

#include <condition_variable>
#include <mutex>

#include "protocol/transport/core/address.h"
#include "protocol/transport/core/link_factories.h"
#include "tests/unit/protocol/transport/raw_socket.h"
#include "tests/unit/protocol/transport/secure_fixture.h"

namespace fire3dv::transport::test {
namespace {

constexpr const char* kAnyPort = "tls://127.0.0.1:0";

struct Tls : testing::Test {
  Secured secured;

  // Expects no peer, and one counted refusal cause.
  void expect_refused(Listener& listener, PublisherLink& publisher, std::string_view why) {
    EXPECT_NE(struct_error(publisher).find(why), std::string::npos) << publisher.problem();
    EXPECT_TRUE(listener.poll_until([&] { return listener.link->stats().rejected > 0; }));
    EXPECT_EQ(listener.link->stats().peers, 0u);
    EXPECT_EQ(listener.count(Kind::pose), 0u);
  }
};

TEST_F(Tls, UntrustedCertificateIsRefused) {
  Listener listener(kAnyPort, secured.tls_listener());
  PublisherOptions options;
  options.tls.ca_file = secured.credentials.authority("stranger").certificate_file;
  auto publisher = open_publisher_or_fail(listener.link->uri(), options);
  publisher->publish(message_of("secret"));
  expect_refused(listener, *publisher, "certificate is not trusted");
  EXPECT_GT(rejected(publisher->stats(), Cause::bad_key), 0u);
}

TEST_F(Tls, ForeignHostCertificateIsRefused) {
  ListenerOptions options = secured.tls_listener();
  const auto other = secured.credentials.identity("other", "DNS:renderer.example", secured.authority);
  options.tls.certificate_file = other.certificate_file;
  options.tls.key_file = other.key_file;
  Listener listener(kAnyPort, options);
  auto publisher = open_publisher_or_fail(listener.link->uri(), secured.tls_publisher());
  expect_refused(listener, *publisher, "certificate is not trusted");
}

TEST_F(Tls, ClientCertificateIsRequired) {
  ListenerOptions options = secured.tls_listener();
  options.tls.client_ca_file = secured.authority.certificate_file;
  Listener listener(kAnyPort, options);
  const auto own = secured.credentials.identity("client", "DNS:simulator", secured.authority);
  const auto foreign =
      secured.credentials.identity("foreign", "DNS:simulator", secured.credentials.authority("stranger"));
  {
    auto nameless = open_publisher_or_fail(listener.link->uri(), secured.tls_publisher());
    nameless->publish(message_of("pose"));
    expect_refused(listener, *nameless, "TLS failed");
  }
  {
    PublisherOptions with_foreign = secured.tls_publisher();
    with_foreign.tls.certificate_file = foreign.certificate_file;
    with_foreign.tls.key_file = foreign.key_file;
    auto stranger = open_publisher_or_fail(listener.link->uri(), with_foreign);
    expect_refused(listener, *stranger, "TLS failed");
  }
  EXPECT_GT(rejected(listener.link->stats(), Cause::bad_key), 0u);
  EXPECT_TRUE(listener.poll_until([&] { return listener.saw_part(Kind::note, "certificate"); }));
  PublisherOptions with_own = secured.tls_publisher();
  with_own.tls.certificate_file = own.certificate_file;
  with_own.tls.key_file = own.key_file;
  auto welcome = open_publisher_or_fail(listener.link->uri(), with_own);
  ASSERT_TRUE(welcome->set_description(bytes_of("d")));
  EXPECT_TRUE(publish_until_seen(*welcome, listener, "pose"));
  EXPECT_EQ(welcome->problem(), "");
}

// A child that says goodbye and ends normally shares the socket and the keys of its parent.
TEST_F(Tls, ForkedChildLeavesConnectionAlone) {
  Listener listener(kAnyPort, secured.tls_listener());
  auto publisher = open_publisher_or_fail(listener.link->uri(), secured.tls_publisher());
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  ASSERT_TRUE(publish_until_seen(*publisher, listener, "before"));
  const pid_t child = ::fork();
  if (child == 0) {
    publisher->publish(message_of("of the child"));
    publisher->send_control(bytes_of("goodbye"));
    const bool is_refused = !publisher->set_description(bytes_of("of the child"));
    publisher.reset();
    ::_exit(is_refused ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0) << "the child's calls must be refused";
  EXPECT_TRUE(publish_until_seen(*publisher, listener, "after"));
  EXPECT_EQ(listener.count(Kind::connected), 1u);
  EXPECT_EQ(listener.count(Kind::disconnected), 0u);
  EXPECT_FALSE(listener.saw(Kind::control, "goodbye"));
  EXPECT_FALSE(listener.saw(Kind::pose, "of the child"));
}

TEST_F(Tls, PlainTcpIsNotLetIn) {
  Listener listener(kAnyPort, secured.tls_listener());
  const std::string uri = listener.link->uri();
  auto publisher = open_publisher_or_fail("tcp" + uri.substr(3));
  publisher->publish(message_of("pose"));
  EXPECT_TRUE(listener.poll_until([&] { return rejected(listener.link->stats(), Cause::bad_key) > 0; }));
  EXPECT_EQ(listener.count(Kind::connected), 0u);
}

TEST_F(Tls, PlainListenerGetsNothing) {
  Listener listener("tcp://127.0.0.1:0");
  const std::string uri = listener.link->uri();
  auto publisher = open_publisher_or_fail("tls" + uri.substr(3), secured.tls_publisher());
  publisher->publish(message_of("pose"));
  EXPECT_TRUE(listener.poll_until([&] { return rejected(listener.link->stats(), Cause::malformed) > 0; }));
  EXPECT_EQ(listener.count(Kind::connected), 0u);
}

TEST_F(Tls, RandomBytesEndTheirConnectionAlone) {
  Listener listener(kAnyPort, secured.tls_listener());
  std::string uri = listener.link->uri();
  uri.replace(0, 3, "tcp");
  auto publisher = open_publisher_or_fail(listener.link->uri(), secured.tls_publisher());
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  ASSERT_TRUE(publish_until_seen(*publisher, listener, "before"));
  for (uint32_t seed = 0; seed < 50; ++seed) {
    RawSocket socket(uri, SOCK_STREAM);
    ASSERT_TRUE(socket.connected());
    socket.send(random_bytes(1000, seed));
    EXPECT_TRUE(socket.closed_by_peer());
  }
  EXPECT_TRUE(listener.poll_until([&] { return rejected(listener.link->stats(), Cause::bad_key) == 50; }));
  EXPECT_TRUE(publish_until_seen(*publisher, listener, "after"));
  EXPECT_EQ(listener.count(Kind::connected), 1u);
}

// Blocks or releases handshake steps.
class Gate {
 public:
  void pass() {
    std::unique_lock lock(mutex_);
    ++waiting_;
    opened_.wait(lock, [this] { return is_open_; });
    --waiting_;
  }
  void set_open(bool is_open) {
    const std::lock_guard lock(mutex_);
    is_open_ = is_open;
    opened_.notify_all();
  }
  int waiting() {
    const std::lock_guard lock(mutex_);
    return waiting_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable opened_;
  bool is_open_ = true;
  int waiting_ = 0;
};

TEST_F(Tls, PendingHandshakesDelayNoEstablishedPeer) {
  constexpr size_t kPending = 20;
  Gate gate;
  auto made = tcp::make_listener(*parse_uri(kAnyPort), secured.tls_listener(), {[&gate] { gate.pass(); }});
  ASSERT_TRUE(made.ok());
  Listener listener(kAnyPort, secured.tls_listener());
  listener.link = std::move(*made);
  auto publisher = open_publisher_or_fail(listener.link->uri(), secured.tls_publisher());
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  ASSERT_TRUE(publish_until_seen(*publisher, listener, "before"));

  gate.set_open(false);
  std::vector<std::unique_ptr<PublisherLink>> pending;
  for (size_t i = 0; i < kPending; ++i)
    pending.push_back(open_publisher_or_fail(listener.link->uri(), secured.tls_publisher()));
  ASSERT_TRUE(listener.poll_until([&] { return gate.waiting() > 0; }));
  for (int i = 0; i < 10; ++i)
    EXPECT_TRUE(publish_until_seen(*publisher, listener, "during " + std::to_string(i)));
  listener.link->send(listener.events[0].peer, bytes_of("reply"));
  EXPECT_TRUE(poll_until_reply(*publisher, "reply"));
  EXPECT_EQ(listener.count(Kind::connected), 1u) << "no handshake is over yet";
  gate.set_open(true);
  EXPECT_TRUE(listener.poll_until([&] { return listener.count(Kind::connected) == 1 + kPending; }));
}

// Connections without a greeting: the address with the most of them loses one.
TEST_F(Tls, UnfinishedHandshakesAreLimitedPerHost) {
  ListenerOptions options = secured.tls_listener();
  options.max_peers = 16;
  Listener listener(kAnyPort, options);
  const Uri uri = *parse_uri(listener.link->uri());
  const auto connect_from = [&](const char* source) {
    UniqueFd fd(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in from{}, to{};
    from.sin_family = to.sin_family = AF_INET;
    ::inet_pton(AF_INET, source, &from.sin_addr);
    ::inet_pton(AF_INET, "127.0.0.1", &to.sin_addr);
    to.sin_port = htons(uri.port);
    EXPECT_EQ(::bind(fd.get(), reinterpret_cast<sockaddr*>(&from), sizeof from), 0);
    EXPECT_EQ(::connect(fd.get(), reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
    return fd;
  };
  const UniqueFd first = connect_from("127.0.0.7");
  std::vector<UniqueFd> flood;
  for (int i = 0; i < 40; ++i) flood.push_back(connect_from("127.0.0.9"));
  ASSERT_TRUE(listener.poll_until([&] { return rejected(listener.link->stats(), Cause::silent) >= 25; }));
  std::byte byte;
  EXPECT_EQ(::recv(first.get(), &byte, 1, MSG_DONTWAIT), -1) << "still open";
  EXPECT_EQ(errno, EAGAIN);
}

TEST_F(Tls, InvalidFilesAreNamed) {
  const auto error_of = [](const ListenerOptions& options) {
    const auto opened = open_listener(kAnyPort, options);
    EXPECT_FALSE(opened.ok());
    return opened.ok() ? std::string() : opened.error().message;
  };
  EXPECT_NE(error_of({}).find("needs a certificate"), std::string::npos);
  ListenerOptions options = secured.tls_listener();
  options.tls.key_file = "";
  EXPECT_NE(error_of(options).find("key is missing"), std::string::npos);
  options.tls.key_file = "/nowhere/at all";
  EXPECT_NE(error_of(options).find("'/nowhere/at all' cannot be read"), std::string::npos)
      << error_of(options);
  options.tls.key_file = secured.credentials.file("text.key", "this is no key", 0600);
  EXPECT_NE(error_of(options).find("cannot be read; it has to be PEM"), std::string::npos)
      << error_of(options);
  options.tls.key_file = secured.authority.key_file;
  EXPECT_NE(error_of(options).find("does not belong to the certificate"), std::string::npos)
      << error_of(options);
  std::filesystem::permissions(secured.server.key_file, std::filesystem::perms(0640));
  options.tls.key_file = secured.server.key_file;
  EXPECT_NE(error_of(options).find("chmod 600"), std::string::npos) << error_of(options);
}

TEST_F(Tls, OtherAddressesNeedNoInsecure) {
  ListenerOptions options = secured.tls_listener();
  EXPECT_TRUE(open_listener("tls://0.0.0.0:0", options).ok());
  EXPECT_FALSE(open_listener("tcp://0.0.0.0:0", options).ok());
}

}  // namespace
}  // namespace fire3dv::transport::test
