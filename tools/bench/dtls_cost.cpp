#include "tools/bench/dtls_cost.h"

#include <sys/socket.h>
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <functional>
#include <numeric>
#include <random>
#include <vector>

#include "protocol/transport/clock.h"
#include "protocol/transport/udp_session.h"
#include "tools/bench/dtls_loopback.h"
#include "tools/bench/sealed_link.h"
#include "tools/bench/statistics.h"

namespace fire3dv::bench {
namespace {

namespace udp = transport::udp;
using transport::monotonic_ns;
using udp::Session;

constexpr const char* kSuites[] = {"PSK-AES128-GCM-SHA256", "PSK-AES256-GCM-SHA384", "PSK-CHACHA20-POLY1305"};
constexpr const char* kForwardSecretSuite = "ECDHE-PSK-CHACHA20-POLY1305";
constexpr size_t kJumboBytes = 8192;

void sleep_until(int64_t until_ns) {
  const timespec until{until_ns / transport::kSecondNs, until_ns % transport::kSecondNs};
  ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

using Payloads = std::vector<std::vector<std::byte>>;

// The plaintext of each datagram of a frame: pose header and message.
Payloads make_payloads(size_t poses, size_t datagram_bytes) {
  const std::vector<wire::Affine3x4> all(poses);
  const size_t poses_a_part = wire::poses_per_part(udp::pose_bytes_of(datagram_bytes));
  wire::PoseFrameEncoder encoder;
  wire::PoseFrameView frame;
  frame.header.epoch = frame.header.sequence = 1;
  frame.node_count = static_cast<uint32_t>(poses);
  Payloads payloads;
  for (size_t first = 0; first < poses; first += poses_a_part) {
    frame.first_node = static_cast<uint32_t>(first);
    frame.poses = std::span(all).subspan(first, std::min(poses_a_part, poses - first));
    const wire::MessagePieces message = encoder.encode(frame);
    const udp::PoseHeader header{1, static_cast<uint16_t>(payloads.size()), first + poses_a_part >= poses};
    std::vector<std::byte>& payload = payloads.emplace_back(udp::kPoseHeaderBytes);
    udp::write_pose_header(payload.data(), header);
    payload.insert(payload.end(), message.head.begin(), message.head.end());
    payload.insert(payload.end(), message.body.begin(), message.body.end());
  }
  return payloads;
}

struct Way {
  std::string name;
  std::function<bool()> send;                                  // one frame
  std::function<bool(std::span<const std::byte>)> check_next;  // opens a datagram, which holds this
  std::function<void()> drain;
  int fd = -1;             // where datagrams arrive; -1: out of sight
  size_t added_bytes = 0;  // to the plaintext of a datagram
  std::vector<double> us, ratio;
};

void discard(int fd) {
  std::byte byte;
  while (::recv(fd, &byte, 1, MSG_DONTWAIT) >= 0) {
  }
}

// As a publisher sends poses: copied behind a header, sealed in place, sent.
Result<Way> session_way(const Payloads& payloads, size_t datagram_bytes, bool sealed) {
  struct Ends {
    SocketPair sockets;
    std::unique_ptr<Session> from, to;
  };
  auto sockets = make_socket_pair();
  if (!sockets) return sockets.error();
  const auto ends = std::make_shared<Ends>();
  ends->sockets = std::move(*sockets);
  const udp::Random publishers = udp::make_random(), listeners = udp::make_random();
  using Side = udp::PreSharedKey::Side;
  for (const Side side : {Side::publisher, Side::listener})
    (side == Side::publisher ? ends->from : ends->to) =
        sealed ? make_sealed_session(side, publishers, listeners, datagram_bytes)
               : std::make_unique<Session>(kBenchSession, monotonic_ns(), nullptr, datagram_bytes);
  Way way;
  way.name = sealed ? "udp:// with a key: seal, send" : "udp:// without a key: send";
  way.fd = ends->sockets.to.get();
  way.send = [ends, &payloads] {
    bool sent = true;
    for (const auto& payload : payloads) {
      Session::Buffer datagram;
      ends->from->start(datagram, udp::Type::pose);
      std::memcpy(datagram.data() + udp::kHeaderBytes, payload.data(), payload.size());
      const auto whole = ends->from->finish(datagram, udp::kHeaderBytes + payload.size());
      sent &= ::send(ends->sockets.from.get(), whole.data(), whole.size(), MSG_DONTWAIT | MSG_NOSIGNAL) >= 0;
    }
    return sent;
  };
  way.check_next = [ends](std::span<const std::byte> expected) {
    std::byte buffer[udp::kMaxDatagramBytes];
    const ssize_t got = ::recv(ends->sockets.to.get(), buffer, sizeof buffer, 0);
    const std::span<std::byte> datagram(buffer, got > 0 ? static_cast<size_t>(got) : 0);
    udp::Header header;
    std::span<const std::byte> payload;
    return udp::read_header(datagram, header) &&
           ends->to->hear(header, datagram, monotonic_ns(), payload) == Session::Heard::payload &&
           std::equal(payload.begin(), payload.end(), expected.begin(), expected.end());
  };
  way.drain = [fd = way.fd] { discard(fd); };
  return way;
}

Result<Way> dtls_way(const Payloads& payloads, const char* suite) {
  auto opened = DtlsLoopback::open(suite);
  if (!opened) return opened.error();
  const std::shared_ptr<DtlsLoopback> dtls(std::move(*opened));
  Way way;
  way.name = std::string("DTLS 1.2, ") + suite + ": SSL_write";
  way.fd = dtls->receiving_fd();
  way.send = [dtls, &payloads] {
    bool sent = true;
    for (const auto& payload : payloads) sent &= dtls->send(payload);
    return sent;
  };
  way.check_next = [dtls](std::span<const std::byte> expected) { return dtls->receive(expected); };
  way.drain = [fd = way.fd] { discard(fd); };
  return way;
}

Result<Way> link_way(size_t poses, size_t datagram_bytes) {
  const auto link = std::make_shared<SealedLink>();
  if (auto opened = link->open(poses, datagram_bytes); !opened) return opened.error();
  Way way;
  way.name = "udp:// with a key: check, encode, publish";
  way.send = [link] {
    link->publish();
    return true;
  };
  way.drain = [link] { link->serve(); };
  way.added_bytes = link->added_bytes();
  return way;
}

// One frame of each way arrives whole; how long its first datagram is on the wire.
Result<void> check(Way& way, const Payloads& payloads) {
  if (way.fd < 0) return {};
  bool arrived = way.send();
  const ssize_t wire_bytes = ::recv(way.fd, nullptr, 0, MSG_PEEK | MSG_TRUNC);
  for (const auto& payload : payloads) arrived = arrived && way.check_next(payload);
  if (!arrived || wire_bytes < 0) return Error{way.name + ": a frame does not arrive as it was sent"};
  way.added_bytes = static_cast<size_t>(wire_bytes) - payloads.front().size();
  return {};
}

// All ways take turns, in a new order in each round, so that other load and caches left warm by one library
// fall on all of them. A ratio is of one round.
Result<void> measure(size_t poses, size_t datagram_bytes, const DtlsOptions& options) {
  const Payloads payloads = make_payloads(poses, datagram_bytes);
  std::vector<Result<Way>> opened;
  opened.push_back(session_way(payloads, datagram_bytes, true));
  opened.push_back(session_way(payloads, datagram_bytes, false));
  for (const char* suite : kSuites) opened.push_back(dtls_way(payloads, suite));
  opened.push_back(link_way(poses, datagram_bytes));
  std::vector<Way> ways;
  for (auto& way : opened) {
    if (!way) return way.error();
    if (auto checked = check(*way, payloads); !checked) return checked.error();
    ways.push_back(std::move(*way));
  }
  std::vector<size_t> order(ways.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::mt19937 generator(1);
  int64_t due_ns = monotonic_ns();
  for (int round = 0; round < options.rounds; ++round) {
    std::shuffle(order.begin(), order.end(), generator);
    for (const size_t turn : order) {
      Way& way = ways[turn];
      if (options.rate_hz > 0) {
        due_ns = std::max(due_ns + static_cast<int64_t>(1e9 / options.rate_hz), monotonic_ns());
        sleep_until(due_ns);
      }
      const int64_t begin_ns = monotonic_ns();
      const bool sent = way.send();
      way.us.push_back(static_cast<double>(monotonic_ns() - begin_ns) / 1000);
      if (!sent) return Error{way.name + ": a frame was not sent"};
      way.drain();
    }
    for (Way& way : ways) way.ratio.push_back(way.us.back() / ways[0].us.back());
  }
  for (const Way& way : ways) {
    const Summary us = summarise(way.us), ratio = summarise(way.ratio);
    std::printf("| %zu | %zu | %zu | %s | %zu | %.1f (%.1f to %.1f) | %.2f (%.2f to %.2f) |\n", poses,
                payloads.size(), payloads.front().size(), way.name.c_str(), way.added_bytes, us.median,
                us.p10, us.p90, ratio.median, ratio.p10, ratio.p90);
  }
  return {};
}

void print_handshake(const std::string& name, const HandshakeCount& count) {
  std::printf("| %s | %zu | %zu | %zu |\n", name.c_str(), count.datagrams, count.bytes, count.round_trips);
}

Result<void> count_handshakes() {
  std::printf(
      "| handshake, with a cookie | datagrams | bytes | round trips before the first pose "
      "|\n|---|---|---|---|\n");
  SealedLink link;
  if (auto opened = link.open(1, udp::kDatagramBytes); !opened) return opened;
  print_handshake("udp:// with a key", link.handshake());
  for (const char* suite : {kSuites[0], kSuites[1], kSuites[2], kForwardSecretSuite}) {
    auto dtls = DtlsLoopback::open(suite);
    if (!dtls) return dtls.error();
    print_handshake(std::string("DTLS 1.2, ") + suite, (*dtls)->handshake());
  }
  return {};
}

Result<void> run(const DtlsOptions& options) {
  std::printf(
      "Sealed datagrams on loopback, %s; medians of %d turns, in brackets the 10th and 90th percentile.\n\n",
      ::OpenSSL_version(OPENSSL_VERSION), options.rounds);
  if (auto counted = count_handshakes(); !counted) return counted;
  std::printf(
      "\n| poses | datagrams | plaintext bytes in the first | way | added bytes a datagram | us a frame | "
      "ratio |\n"
      "|---|---|---|---|---|---|---|\n");
  const auto full = [](size_t datagram_bytes) {
    return wire::poses_per_part(udp::pose_bytes_of(datagram_bytes));
  };
  for (const auto& [poses, datagram_bytes] : {std::pair<size_t, size_t>{1, udp::kDatagramBytes},
                                              {full(udp::kDatagramBytes), udp::kDatagramBytes},
                                              {100, udp::kDatagramBytes},
                                              {full(kJumboBytes), kJumboBytes}})
    if (auto measured = measure(poses, datagram_bytes, options); !measured) return measured;
  return {};
}

}  // namespace

int dtls_cost(const DtlsOptions& options) {
  const auto done = run(options);
  if (!done) std::fprintf(stderr, "fire3dv-bench: %s\n", done.error().message.c_str());
  return done ? 0 : 1;
}

}  // namespace fire3dv::bench
