// Test of the network impairment tool: seeded probabilities, queues and outages; TCP streams stay intact
// unless reset.
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>

#include <cmath>
#include <thread>

#include "base/clock.h"
#include "protocol/transport/core/address.h"
#include "tools/lab/impair/impairment.h"
#include "tools/lab/impair/relay.h"

namespace fire3dv::impair {
namespace {

constexpr int64_t kMs = 1'000'000;
constexpr int kHangLimitMs = 120'000;

std::vector<DatagramChannel::Fate> fates(const Impairment& impairment, int count = 20'000) {
  DatagramChannel channel(impairment.seed);
  std::vector<DatagramChannel::Fate> drawn;
  for (int i = 0; i < count; ++i) drawn.push_back(channel.draw(impairment, 500, int64_t{i} * kMs));
  return drawn;
}

TEST(DatagramChannel, SeedRepeatsChances) {
  Impairment impairment;
  impairment.loss = 0.05;
  impairment.duplicate = 0.1;
  impairment.reorder = 0.25;
  impairment.delay_ns = 50 * kMs;
  impairment.jitter_ns = 20 * kMs;
  const auto drawn = fates(impairment), again = fates(impairment);
  double lost = 0, twice = 0, overtakes = 0, least = 1e18, most = 0;
  for (size_t i = 0; i < drawn.size(); ++i) {
    EXPECT_EQ(drawn[i].copies, again[i].copies);
    EXPECT_EQ(drawn[i].due_ns, again[i].due_ns);
    lost += drawn[i].copies == 0;
    twice += drawn[i].copies == 2;
    overtakes += drawn[i].overtakes;
    if (drawn[i].copies == 0 || drawn[i].overtakes) continue;
    const auto late = static_cast<double>(drawn[i].due_ns - static_cast<int64_t>(i) * kMs);
    least = std::min(least, late);
    most = std::max(most, late);
  }
  const auto count = static_cast<double>(drawn.size());
  EXPECT_NEAR(lost / count, 0.05, 0.01);
  EXPECT_NEAR(twice / count, 0.1, 0.01);
  EXPECT_NEAR(overtakes / count, 0.25 * 0.95, 0.02);
  EXPECT_NEAR(least, 30.0 * kMs, 0.5 * kMs);
  EXPECT_NEAR(most, 70.0 * kMs, 0.5 * kMs);
  impairment.seed = 2;
  EXPECT_NE(fates(impairment)[7].due_ns, drawn[7].due_ns);
}

TEST(DatagramChannel, LimitedLinkQueuesThenLoses) {
  Impairment impairment;
  impairment.bits_per_second = 1'000'000;  // 250 datagrams of 500 bytes a second; the test sends 1000
  const auto drawn = fates(impairment, 5000);
  int passed = 0;
  for (size_t i = 0; i < drawn.size(); ++i) {
    passed += drawn[i].copies;
    if (drawn[i].copies != 0) {
      EXPECT_LE(drawn[i].due_ns - static_cast<int64_t>(i) * kMs, 200 * kMs);
    }
  }
  EXPECT_NEAR(passed, 1250 + 50, 3) << "five seconds' worth, and what waits in the queue";
  impairment.down = true;
  EXPECT_EQ(fates(impairment, 1)[0].copies, 0);
}

TEST(StreamImpairment, BytesDecideAndNotSegments) {
  Impairment impairment;
  impairment.stall_after_bytes = 1000;
  impairment.reset_after_bytes = 50'000;
  const auto stalls_of = [&](uint64_t segment) {
    StreamImpairment fate(impairment, 3, true);
    std::vector<uint64_t> at;
    uint64_t passed = 0;
    while (!fate.is_reset()) {
      const uint64_t bytes = std::min(segment, fate.quiet_bytes());
      passed += bytes;
      if (fate.pass(bytes)) at.push_back(passed);
    }
    at.push_back(passed);
    return at;
  };
  EXPECT_GT(stalls_of(7).size(), 5u);
  EXPECT_EQ(stalls_of(7), stalls_of(100'000));
}

TEST(Schedule, OutagesAreReadAndKept) {
  const auto outage = parse_outage("5:2.5");
  ASSERT_TRUE(outage);
  EXPECT_FALSE(is_down({*outage}, 4999 * kMs));
  EXPECT_TRUE(is_down({*outage}, 5000 * kMs));
  EXPECT_TRUE(is_down({*outage}, 7499 * kMs));
  EXPECT_FALSE(is_down({*outage}, 7500 * kMs));
  for (const char* text : {"", "5", "5:", ":5", "a:b", "-1:2", "1:nan", "1:2:3", "inf:1"})
    EXPECT_FALSE(parse_outage(text)) << text;
}

TEST(Relay, SaysWhatItCannotPassOn) {
  const auto error = [](const char* from, const char* to) {
    const auto opened = open_relay(from, to, {}, false);
    return opened ? std::string() : opened.error().message;
  };
  EXPECT_NE(error("udp://127.0.0.1:0", "tcp://127.0.0.1:5").find("one kind"), std::string::npos);
  EXPECT_NE(error("shm://a", "shm://b").find("network"), std::string::npos);
  EXPECT_NE(error("tcp://127.0.0.1:0", "tcp://127.0.0.1:0").find("port"), std::string::npos);
  EXPECT_NE(error("tcp://0.0.0.0:0", "tcp://127.0.0.1:5").find("--insecure"), std::string::npos);
  EXPECT_NE(error("tcp://127.0.0.1:0", "tcp://a.name.invalid:5").find("digits"), std::string::npos);
}

// A server of one connection behind a relay, and its client.
class TcpRelayTest : public ::testing::Test {
 protected:
  void connect(const Impairment& impairment) {
    transport::Uri any{transport::Uri::Scheme::tcp, "", "127.0.0.1", 0};
    auto bound = transport::bind_listener(any, SOCK_STREAM, false);
    ASSERT_TRUE(bound.ok());
    const std::string target = "tcp://" + bound->address.text();
    auto opened = open_relay("tcp://127.0.0.1:0", target, impairment, false);
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    relay_ = std::move(*opened);
    auto uri = transport::parse_uri(relay_->uri());
    transport::Address address = transport::Lookup(*uri).addresses().front();
    client_ = UniqueFd(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    ASSERT_EQ(::connect(client_.get(), address.get(), address.length), 0);
    ASSERT_TRUE(readable(bound->fd));
    server_ = UniqueFd(::accept4(bound->fd.get(), nullptr, nullptr, SOCK_CLOEXEC));
    ASSERT_TRUE(bool(server_));
  }
  static bool readable(const UniqueFd& fd) {
    pollfd polled{fd.get(), POLLIN, 0};
    return ::poll(&polled, 1, kHangLimitMs) == 1;
  }
  // Returns all bytes until the peer closes or resets.
  static std::string read_all(const UniqueFd& fd, bool* reset = nullptr) {
    std::string all;
    char buffer[4096];
    ssize_t got = 0;
    while (readable(fd) && (got = ::recv(fd.get(), buffer, sizeof buffer, 0)) > 0)
      all.append(buffer, static_cast<size_t>(got));
    if (reset) *reset = got < 0 && errno == ECONNRESET;
    return all;
  }
  static std::string text(size_t bytes) {
    std::string text(bytes, ' ');
    for (size_t i = 0; i < bytes; ++i) text[i] = static_cast<char>('a' + i * i % 23);
    return text;
  }

  std::unique_ptr<Relay> relay_;
  UniqueFd client_, server_;
};

TEST_F(TcpRelayTest, DelayedBytesKeepOrder) {
  Impairment impairment;
  impairment.delay_ns = 3 * kMs;
  impairment.jitter_ns = 3 * kMs;
  impairment.stall_after_bytes = 50'000;
  impairment.stall_ns = 5 * kMs;
  connect(impairment);
  const std::string there = text(400'000), back = text(100'000);
  std::thread sender([&] {
    EXPECT_EQ(::send(client_.get(), there.data(), there.size(), 0), static_cast<ssize_t>(there.size()));
    ::shutdown(client_.get(), SHUT_WR);
  });
  EXPECT_EQ(read_all(server_), there);
  sender.join();
  EXPECT_EQ(::send(server_.get(), back.data(), back.size(), 0), static_cast<ssize_t>(back.size()));
  server_ = UniqueFd();
  EXPECT_EQ(read_all(client_), back);
  EXPECT_EQ(relay_->counts().bytes, there.size() + back.size());
  EXPECT_GT(relay_->counts().stalls, 0u);
  EXPECT_EQ(relay_->counts().resets, 0u);
}

TEST_F(TcpRelayTest, ConnectionResetsAfterBytes) {
  Impairment impairment;
  impairment.reset_after_bytes = 20'000;
  connect(impairment);
  const std::string there = text(2'000'000);
  std::thread sender([&] {
    constexpr int kMaxRounds = 500;  // a gigabyte: beyond all buffers on the way
    int rounds = 0;
    while (rounds<kMaxRounds&& ::send(client_.get(), there.data(), there.size(), MSG_NOSIGNAL)> 0) ++rounds;
    EXPECT_LT(rounds, kMaxRounds);
  });
  bool reset = false;
  const std::string came = read_all(server_, &reset);
  sender.join();
  EXPECT_TRUE(reset);
  EXPECT_EQ(came, there.substr(0, came.size()));
  EXPECT_EQ(relay_->counts().resets, 1u);
}

TEST_F(TcpRelayTest, LinkDownLosesNothing) {
  connect({});
  Impairment down;
  down.down = true;
  relay_->set(down);
  const std::string there = text(10'000);
  ASSERT_EQ(::send(client_.get(), there.data(), there.size(), 0), static_cast<ssize_t>(there.size()));
  ::shutdown(client_.get(), SHUT_WR);
  pollfd polled{server_.get(), POLLIN, 0};
  EXPECT_EQ(::poll(&polled, 1, 100), 0);
  relay_->set({});
  EXPECT_EQ(read_all(server_), there);
}

}  // namespace
}  // namespace fire3dv::impair
