#include <cstring>

#include "protocol/base/clock.h"
#include "protocol/transport/open.h"
#include "protocol/wire/decode.h"
#include "tools/lab/bench/links/one_way.h"
#include "tools/lab/bench/links/simulator.h"

namespace fire3dv::bench {
namespace {

using fire3dv::monotonic_ns;

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
