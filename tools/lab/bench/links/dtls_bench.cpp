#include "tools/lab/bench/links/link_benches.h"

#include <malloc.h>
#include <openssl/crypto.h>
#include <sys/socket.h>
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <functional>
#include <memory>
#include <numeric>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "protocol/transport/udp/udp_session.h"
#include "tools/lab/bench/report/statistics.h"
#include "tools/lab/bench/served_link.h"

namespace fire3dv::bench {
namespace {

namespace udp = transport::udp;
using fire3dv::monotonic_ns;
using udp::Session;

constexpr size_t kJumboBytes = 8192;

using Payloads = std::vector<std::vector<std::byte>>;

// Returns the plaintext of each datagram of a frame: pose header and message.
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

struct Variant {
  std::string name;
  std::function<bool()> send;                                  // sends one frame
  std::function<bool(std::span<const std::byte>)> check_next;  // opens a datagram and compares it with the
                                                               // argument
  std::function<void()> drain;
  int fd = -1;             // receiving socket; -1: not accessible
  size_t added_bytes = 0;  // bytes added to a datagram's plaintext
  std::vector<double> us, ratio;
};

void discard(int fd) {
  std::byte byte;
  while (::recv(fd, &byte, 1, MSG_DONTWAIT) >= 0) {
  }
}

// Same steps as a publisher: copy behind a header, seal in place, send.
Result<Variant> session_way(const Payloads& payloads, size_t datagram_bytes, bool sealed) {
  struct Ends {
    SocketPair sockets;
    SessionPair sessions;
  };
  auto sockets = make_socket_pair();
  if (!sockets) return sockets.error();
  auto sessions = make_session_pair(sealed, datagram_bytes);
  if (!sessions) return sessions.error();
  const auto ends = std::make_shared<Ends>(Ends{std::move(*sockets), std::move(*sessions)});
  Variant way;
  way.name = sealed ? "udp:// with a key: seal, send" : "udp:// without a key: send";
  way.fd = ends->sockets.to.get();
  way.send = [ends, &payloads] {
    bool sent = true;
    for (const auto& payload : payloads) {
      Session::Buffer datagram;
      ends->sessions.from->start(datagram, udp::Type::pose);
      std::memcpy(datagram.data() + udp::kHeaderBytes, payload.data(), payload.size());
      const auto whole = ends->sessions.from->finish(datagram, udp::kHeaderBytes + payload.size());
      sent &= ::send(ends->sockets.from.get(), whole.data(), whole.size(), MSG_DONTWAIT | MSG_NOSIGNAL) >= 0;
    }
    return sent;
  };
  way.check_next = [ends, sealed](std::span<const std::byte> expected) {
    std::byte buffer[udp::kMaxDatagramBytes];
    const ssize_t got = ::recv(ends->sockets.to.get(), buffer, sizeof buffer, 0);
    const std::span<std::byte> datagram(buffer, got > 0 ? static_cast<size_t>(got) : 0);
    Session& session = *ends->sessions.to;
    udp::Header header;
    std::span<const std::byte> payload;
    const auto received =
        sealed ? session.open(udp::inspect_records(datagram), datagram, monotonic_ns(), header.type, payload)
        : udp::read_header(datagram, header) ? session.receive(header, datagram, monotonic_ns(), payload)
                                             : Session::Received::forged;
    return received == Session::Received::payload && header.type == udp::Type::pose &&
           std::equal(payload.begin(), payload.end(), expected.begin(), expected.end());
  };
  way.drain = [fd = way.fd] { discard(fd); };
  return way;
}

Result<Variant> link_way(size_t poses, size_t datagram_bytes, bool sealed) {
  const auto link = std::make_shared<ServedLink>();
  if (auto opened = link->open(poses, datagram_bytes, sealed); !opened) return opened.error();
  Variant way;
  way.name = std::string(sealed ? "udp:// with a key" : "udp:// without a key") + ": check, encode, publish";
  way.send = [link] {
    link->publish();
    return true;
  };
  way.drain = [link] { link->serve(); };
  way.added_bytes = link->added_bytes();
  return way;
}

// Verifies that one frame arrives whole, and measures the wire size of its first datagram.
Result<void> check(Variant& way, const Payloads& payloads) {
  if (way.fd < 0) return {};
  bool arrived = way.send();
  const ssize_t wire_bytes = ::recv(way.fd, nullptr, 0, MSG_PEEK | MSG_TRUNC);
  for (const auto& payload : payloads) arrived = arrived && way.check_next(payload);
  if (!arrived || wire_bytes < 0) return Error{way.name + ": a frame does not arrive as it was sent"};
  way.added_bytes = static_cast<size_t>(wire_bytes) - payloads.front().size();
  return {};
}

// All variants alternate in a random order per round, so that other load and warm caches affect all of them.
// Ratios are taken per round.
Result<void> measure(size_t poses, size_t datagram_bytes, const DtlsOptions& options) {
  const Payloads payloads = make_payloads(poses, datagram_bytes);
  std::vector<Result<Variant>> opened;
  for (const bool sealed : {false, true}) opened.push_back(session_way(payloads, datagram_bytes, sealed));
  for (const bool sealed : {false, true}) opened.push_back(link_way(poses, datagram_bytes, sealed));
  std::vector<Variant> ways;
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
      Variant& way = ways[turn];
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
    for (Variant& way : ways) way.ratio.push_back(way.us.back() / ways[0].us.back());
  }
  for (const Variant& way : ways) {
    const Summary us = summarise(way.us), ratio = summarise(way.ratio);
    std::printf("| %zu | %zu | %zu | %s | %zu | %.1f (%.1f to %.1f) | %.2f (%.2f to %.2f) |\n", poses,
                payloads.size(), payloads.front().size(), way.name.c_str(), way.added_bytes, us.median,
                us.p10, us.p90, ratio.median, ratio.p10, ratio.p90);
  }
  return {};
}

Result<void> count_handshakes() {
  std::printf(
      "| handshake, with a cookie | datagrams | bytes | round trips before the description "
      "|\n|---|---|---|---|\n");
  for (const bool sealed : {false, true}) {
    ServedLink link;
    if (auto opened = link.open(1, udp::kDatagramBytes, sealed); !opened) return opened;
    const HandshakeCount& count = link.handshake();
    std::printf("| udp:// %s a key | %zu | %zu | %zu |\n", sealed ? "with" : "without", count.datagrams,
                count.bytes, count.round_trips);
  }
  return {};
}

size_t heap_bytes() {
  const struct mallinfo2 use = ::mallinfo2();
  return use.uordblks + use.hblkhd;
}

// Of a listener's end, which is what strangers can make a renderer hold.
Result<void> measure_memory() {
  constexpr size_t kSessions = 64;
  std::printf("\n| a listener's end | bytes each, of %zu |\n|---|---|\n", kSessions);
  for (const bool established : {false, true}) {
    const size_t before = heap_bytes();
    std::vector<std::unique_ptr<udp::Session>> sessions;
    std::vector<std::unique_ptr<udp::Dtls>> pending;
    for (size_t i = 0; i < kSessions; ++i) {
      if (established) {
        auto pair = make_session_pair(true, udp::kDatagramBytes);
        if (!pair) return pair.error();
        sessions.push_back(std::move(pair->to));
      } else {
        auto handshake = make_pending_handshake();
        if (!handshake) return handshake.error();
        pending.push_back(std::move(*handshake));
      }
    }
    std::printf("| %s | %zu |\n", established ? "session" : "handshake", (heap_bytes() - before) / kSessions);
  }
  return {};
}

Result<void> run(const DtlsOptions& options) {
  std::printf(
      "Sealed datagrams on loopback, %s; medians of %d turns, in brackets the 10th and 90th percentile.\n\n",
      ::OpenSSL_version(OPENSSL_VERSION), options.rounds);
  if (auto counted = count_handshakes(); !counted) return counted;
  if (auto memory = measure_memory(); !memory) return memory;
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
