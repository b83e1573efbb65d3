#include "tools/lab/bench/links/link_benches.h"

#include <sys/mman.h>

#include <array>
#include <asio/ip/tcp.hpp>
#include <asio/ip/udp.hpp>
#include <asio/read.hpp>
#include <asio/write.hpp>
#include <cstring>
#include <vector>

#include "base/clock.h"
#include "protocol/transport/open.h"
#include "protocol/transport/udp/udp_datagram.h"
#include "protocol/wire/decode.h"
#include "protocol/wire/encode.h"
#include "tools/lab/bench/links/simulator.h"
#include "tools/lab/bench/processes.h"

namespace fire3dv::bench {

namespace {

using AsioUdp = asio::ip::udp;
using AsioTcp = asio::ip::tcp;
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
  AsioTcp::socket socket{io};
  std::array<std::byte, kOneWayBytes> frame{};

  void prepare(uint32_t index) override { std::memcpy(frame.data(), &index, sizeof index); }
  void send() override {
    asio::error_code error;
    asio::write(socket, asio::buffer(frame), error);
  }
};

struct TcpReceiver final : Receiver {
  asio::io_context io;
  AsioTcp::acceptor acceptor{io, AsioTcp::endpoint(asio::ip::address_v4::loopback(), 0)};
  AsioTcp::socket socket{io};
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
  AsioUdp::socket socket{io};
  Datagram datagram{};

  void prepare(uint32_t index) override { std::memcpy(datagram.data(), &index, sizeof index); }
  void send() override {
    asio::error_code error;
    for (size_t i = 0; i < datagrams_a_frame(); ++i) socket.send(asio::buffer(datagram), 0, error);
  }
};

struct UdpReceiver final : Receiver {
  asio::io_context io;
  AsioUdp::socket socket{io, AsioUdp::endpoint(asio::ip::address_v4::loopback(), 0)};
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
              sender->socket.set_option(AsioTcp::no_delay(true));
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

namespace {

class LinkSender final : public Sender {
 public:
  explicit LinkSender(std::unique_ptr<Simulator> simulator) : simulator_(std::move(simulator)) {}
  void prepare(uint32_t index) override {
    simulator_->set_index(index);
    while (simulator_->link().poll(reply_)) {
    }
  }
  void send() override { simulator_->publish(); }

 private:
  std::unique_ptr<Simulator> simulator_;
  std::vector<std::byte> reply_;
};

// Receiver of a link. A frame counts as received when poll() has returned its last part; it is decoded after
// the clock is read.
class LinkReceiver final : public Receiver {
 public:
  LinkReceiver(std::unique_ptr<transport::ListenerLink> link, bool spins)
      : link_(std::move(link)), spins_(spins) {}

  void receive(WayBoard& board) override {
    if (!spins_) link_->wait(std::chrono::milliseconds(20));
    link_->poll([&](const transport::LinkEvent& event) {
      if (event.kind != transport::LinkEvent::Kind::pose) return;
      const int64_t now = monotonic_ns();
      const auto message = decoder_.decode(event.message);
      const auto* frame = message ? std::get_if<wire::PoseFrameView>(&*message) : nullptr;
      if (frame == nullptr || frame->poses.empty()) return;
      if (frame->header.sequence != sequence_) poses_ = 0;
      sequence_ = frame->header.sequence;
      poses_ += frame->poses.size();
      if (poses_ != kOneWayPoses) return;
      const uint32_t index = static_cast<uint32_t>(frame->poses[0].m[0]) % kMaxFrames;
      board.came[index] = event.received_ns != 0 ? event.received_ns : now;
      board.seen[index] = now;
    });
  }

 private:
  std::unique_ptr<transport::ListenerLink> link_;
  bool spins_;
  wire::Decoder decoder_;
  uint64_t sequence_ = 0;
  size_t poses_ = 0;
};

}  // namespace

Way link_way(const std::string& name, const std::string& uri, const LinkSecurity& security) {
  return {name, false,
          [uri, security](WayBoard& board) -> Result<std::unique_ptr<Receiver>> {
            transport::ListenerOptions options;
            options.key_file = security.udp_key_file;
            options.tls.certificate_file = security.tls_certificate_file;
            options.tls.key_file = security.tls_key_file;
            auto link = transport::open_listener(uri, options);
            if (!link) return link.error();
            std::snprintf(board.address, sizeof board.address, "%s", (*link)->uri().c_str());
            return std::unique_ptr<Receiver>(
                std::make_unique<LinkReceiver>(std::move(*link), uri.starts_with("shm")));
          },
          [security](WayBoard& board) -> Result<std::unique_ptr<Sender>> {
            transport::PublisherOptions options;
            options.key_file = security.udp_key_file;
            options.tls.ca_file = security.tls_certificate_file;  // self-signed
            auto simulator = Simulator::open(board.address, kOneWayPoses, options);
            if (!simulator) return simulator.error();
            return std::unique_ptr<Sender>(std::make_unique<LinkSender>(std::move(*simulator)));
          }};
}

}  // namespace fire3dv::bench
