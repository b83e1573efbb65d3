#include "tools/record/recorder.h"

#include <cstdio>
#include <string>

#include "protocol/base/clock.h"
#include "protocol/wire/encode.h"

namespace fire3dv::record {

using transport::LinkEvent;

void Recorder::poll(transport::ListenerLink& link, uint32_t link_number, bool answers) {
  link.poll([&](const LinkEvent& event) {
    const uint64_t peer = uint64_t{link_number} << 48 | event.peer;
    const int64_t at_ns = event.received_ns != 0 ? event.received_ns : fire3dv::monotonic_ns();
    switch (event.kind) {
      case LinkEvent::Kind::note:
        std::fprintf(stderr, "fire3dv-record: %s\n", std::string(event.text).c_str());
        break;
      case LinkEvent::Kind::disconnected:
        log_.end_peer(peer, at_ns);
        break;
      case LinkEvent::Kind::pose:
      case LinkEvent::Kind::control:
        if (answers && event.kind == LinkEvent::Kind::control) answer(link, event.peer, event.message);
        log_.take(peer, event.message, at_ns, event.kind == LinkEvent::Kind::pose);
        break;
      case LinkEvent::Kind::connected:
        break;
    }
  });
}

// Answers a publisher that has no other peer, so that it knows its stream is recorded. No frame is
// acknowledged, since none is shown.
void Recorder::answer(transport::ListenerLink& link, transport::PeerId peer,
                      std::span<const std::byte> message) {
  const auto decoded = decoder_.decode(message);
  if (!decoded) return;
  if (const auto* description = std::get_if<wire::StreamDescription>(&*decoded)) {
    wire::Welcome welcome;
    welcome.renderer_name = "fire3dv-record";
    welcome.epoch = description->epoch;
    if (description->protocol_major != wire::kProtocolMajor)
      welcome.status = wire::WelcomeStatus::version_mismatch;
    else
      link.accept(peer);
    link.send(peer, wire::encode(welcome));
  } else if (const auto* ping = std::get_if<wire::Ping>(&*decoded)) {
    link.send(peer, wire::encode(wire::Pong{ping->id, ping->sender_time_ns,
                                            static_cast<uint64_t>(fire3dv::monotonic_ns())}));
  }
}

}  // namespace fire3dv::record
