#include <sys/mman.h>

#include <array>
#include <asio/ip/tcp.hpp>
#include <asio/ip/udp.hpp>
#include <asio/read.hpp>
#include <asio/write.hpp>
#include <cstring>
#include <vector>

#include "protocol/base/clock.h"
#include "protocol/transport/udp/udp_datagram.h"
#include "protocol/wire/encode.h"
#include "tools/lab/bench/links/one_way.h"
#include "tools/lab/bench/processes.h"

namespace fire3dv::bench {
namespace {

using asio::ip::tcp;
using asio::ip::udp;
using fire3dv::monotonic_ns;

constexpr size_t kSlots = 8;

// Same slot count as the shared-memory link's ring, so that both write to equally cold cache lines.
struct SlotRing {
  alignas(64) std::atomic<uint64_t> published;
  alignas(64) std::byte slots[kSlots][kOneWayBytes];
};

struct SlotSender final : Sender {
  std::shared_ptr<Shared<SlotRing>> ring;
  std::array<std::byte, kOneWayBytes> frame{};
  uint64_t number = 0;
  // Volatile pointer, so that the compiler cannot inline the copy: the baseline is the library's memcpy.
  void* (*volatile copy)(void*, const void*, size_t) = std::memcpy;

  void prepare(uint32_t index) override { std::memcpy(frame.data(), &index, sizeof index); }
  void send() override {
    copy((*ring)->slots[number % kSlots], frame.data(), frame.size());
    (*ring)->published.store(++number, std::memory_order_release);
  }
};

struct SlotReceiver final : Receiver {
  std::shared_ptr<Shared<SlotRing>> ring;
  std::array<std::byte, kOneWayBytes> frame{};
  uint64_t seen = 0;

  void receive(WayBoard& board) override {
    const uint64_t published = (*ring)->published.load(std::memory_order_acquire);
    if (published == seen) return;
    seen = published;
    std::memcpy(frame.data(), (*ring)->slots[(published - 1) % kSlots], frame.size());
    const int64_t now = monotonic_ns();
    uint32_t index = 0;
    std::memcpy(&index, frame.data(), sizeof index);
    board.came[index % kMaxFrames] = board.seen[index % kMaxFrames] = now;
  }
};

void send_port(WayBoard& board, unsigned short port) {
  std::snprintf(board.address, sizeof board.address, "%u", static_cast<unsigned>(port));
}
unsigned short received_port(const WayBoard& board) {
  return static_cast<unsigned short>(std::strtoul(board.address, nullptr, 10));
}

// One write and one read per frame, of the same size as tcp:// apart from 100 bytes of encoding.
struct TcpSender final : Sender {
  asio::io_context io;
  tcp::socket socket{io};
  std::array<std::byte, kOneWayBytes> frame{};

  void prepare(uint32_t index) override { std::memcpy(frame.data(), &index, sizeof index); }
  void send() override {
    asio::error_code error;
    asio::write(socket, asio::buffer(frame), error);
  }
};

struct TcpReceiver final : Receiver {
  asio::io_context io;
  tcp::acceptor acceptor{io, tcp::endpoint(asio::ip::address_v4::loopback(), 0)};
  tcp::socket socket{io};
  std::array<std::byte, kOneWayBytes> frame{};

  void receive(WayBoard& board) override {
    asio::error_code error;
    if (!socket.is_open()) acceptor.accept(socket, error);
    asio::read(socket, asio::buffer(frame), error);
    if (error) return;
    const int64_t now = monotonic_ns();
    uint32_t index = 0;
    std::memcpy(&index, frame.data(), sizeof index);
    board.came[index % kMaxFrames] = board.seen[index % kMaxFrames] = now;
  }
};

// Same datagram count and size as udp:// per frame.
size_t datagrams_a_frame() {
  static const size_t poses =
      wire::poses_per_part(transport::udp::pose_bytes_of(transport::udp::kDatagramBytes));
  return (kOneWayPoses + poses - 1) / poses;
}
using Datagram = std::array<std::byte, transport::udp::kDatagramBytes - transport::udp::kTagBytes>;

struct UdpSender final : Sender {
  asio::io_context io;
  udp::socket socket{io};
  Datagram datagram{};

  void prepare(uint32_t index) override { std::memcpy(datagram.data(), &index, sizeof index); }
  void send() override {
    asio::error_code error;
    for (size_t i = 0; i < datagrams_a_frame(); ++i) socket.send(asio::buffer(datagram), 0, error);
  }
};

struct UdpReceiver final : Receiver {
  asio::io_context io;
  udp::socket socket{io, udp::endpoint(asio::ip::address_v4::loopback(), 0)};
  Datagram datagram{};
  uint32_t index = 0;
  size_t came = 0;

  void receive(WayBoard& board) override {
    asio::error_code error;
    socket.receive(asio::buffer(datagram), 0, error);
    if (error) return;
    uint32_t of = 0;
    std::memcpy(&of, datagram.data(), sizeof of);
    if (of != index) came = 0;
    index = of;
    if (++came == datagrams_a_frame())
      board.came[index % kMaxFrames] = board.seen[index % kMaxFrames] = monotonic_ns();
  }
};

// Converts Asio's exceptions to errors; without a socket there is nothing to measure.
template <typename Make>
auto caught(const char* what, Make make) -> decltype(make()) {
  try {
    return make();
  } catch (const std::exception& failure) {
    return Error{std::string(what) + ": " + failure.what()};
  }
}

}  // namespace

Way bare_slot() {
  const auto ring = std::make_shared<Shared<SlotRing>>();
  return {"memcpy into a slot", true,
          [ring](WayBoard&) -> Result<std::unique_ptr<Receiver>> {
            auto receiver = std::make_unique<SlotReceiver>();
            receiver->ring = ring;
            return std::unique_ptr<Receiver>(std::move(receiver));
          },
          [ring](WayBoard&) -> Result<std::unique_ptr<Sender>> {
            auto sender = std::make_unique<SlotSender>();
            sender->ring = ring;
            return std::unique_ptr<Sender>(std::move(sender));
          }};
}

Way bare_tcp() {
  return {"Asio: TCP socket", true,
          [](WayBoard& board) {
            return caught("TCP", [&]() -> Result<std::unique_ptr<Receiver>> {
              auto receiver = std::make_unique<TcpReceiver>();
              send_port(board, receiver->acceptor.local_endpoint().port());
              return std::unique_ptr<Receiver>(std::move(receiver));
            });
          },
          [](WayBoard& board) {
            return caught("TCP", [&]() -> Result<std::unique_ptr<Sender>> {
              auto sender = std::make_unique<TcpSender>();
              sender->socket.connect({asio::ip::address_v4::loopback(), received_port(board)});
              sender->socket.set_option(tcp::no_delay(true));
              return std::unique_ptr<Sender>(std::move(sender));
            });
          }};
}

Way bare_udp() {
  return {"Asio: UDP socket, " + std::to_string(datagrams_a_frame()) + " datagrams", true,
          [](WayBoard& board) {
            return caught("UDP", [&]() -> Result<std::unique_ptr<Receiver>> {
              auto receiver = std::make_unique<UdpReceiver>();
              send_port(board, receiver->socket.local_endpoint().port());
              return std::unique_ptr<Receiver>(std::move(receiver));
            });
          },
          [](WayBoard& board) {
            return caught("UDP", [&]() -> Result<std::unique_ptr<Sender>> {
              auto sender = std::make_unique<UdpSender>();
              sender->socket.connect({asio::ip::address_v4::loopback(), received_port(board)});
              return std::unique_ptr<Sender>(std::move(sender));
            });
          }};
}

}  // namespace fire3dv::bench
