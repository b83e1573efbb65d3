#include "tools/motion/watcher.h"

#include <cstdio>
#include <utility>

#include "protocol/wire/encode.h"

namespace fire3dv::motion {

using transport::LinkEvent;

Watcher::Watcher(size_t most_frames) : most_frames_(most_frames) {
  recording_.arrivals.assign(most_frames, {});  // written to, so that it is really there
  recording_.arrivals.clear();
  recording_.pongs.reserve(1 << 16);
}

void Watcher::poll(transport::ListenerLink& link, int64_t now_ns) {
  link.poll([&](const LinkEvent& event) {
    if (event.kind == LinkEvent::Kind::note)
      std::fprintf(stderr, "fire3dv-motion: %s\n", std::string(event.text).c_str());
    if (event.kind == LinkEvent::Kind::pose || event.kind == LinkEvent::Kind::control)
      take(event.peer, event.message, event.received_ns != 0 ? event.received_ns : now_ns);
  });
  if (stream_ == state::kNone) return;
  ask(link, now_ns);
  (void)poses_.advance(now_ns);
  note_condition(now_ns);
}

void Watcher::note_condition(int64_t now_ns) {
  using state::Condition;
  constexpr int64_t kRecoverNs = 2'000'000'000;
  constexpr int64_t kForEver = INT64_MAX;
  const Condition was = std::exchange(condition_, poses_.streams()[stream_].condition);
  if (was == condition_) return;
  std::fprintf(stderr, "fire3dv-motion: %s\n", state::condition_name(condition_));
  times_lost_ += condition_ == Condition::lost;
  if (was == Condition::live) {
    ++times_late_;
    interruptions_.push_back({recording_.arrivals.back().received_ns, kForEver});
  } else if (condition_ == Condition::live) {
    interruptions_.back().end_ns = now_ns + kRecoverNs;
  }
}

void Watcher::take(transport::PeerId peer, std::span<const std::byte> message, int64_t received_ns) {
  const auto decoded = decoder_.decode(message);
  if (!decoded) return;
  if (const auto* description = std::get_if<wire::StreamDescription>(&*decoded)) {
    if (stream_ != state::kNone && description->epoch != epoch_) return;  // one stream is watched, the first
    peer_ = peer;
    if (stream_ != state::kNone) return;
    stream_ = poses_.add_stream(*description);
    epoch_ = description->epoch;
    return;
  }
  if (stream_ == state::kNone || peer != peer_) return;
  if (const auto* pong = std::get_if<wire::Pong>(&*decoded)) {
    const bool asked = pong->id != 0 && pong->id <= pings_ &&
                       pong->ping_sender_time_ns <= static_cast<uint64_t>(received_ns);
    if (asked && recording_.pongs.size() < recording_.pongs.capacity())
      recording_.pongs.push_back(
          {static_cast<int64_t>(pong->ping_sender_time_ns), pong->answer_time_ns, received_ns});
    return;
  }
  const auto* frame = std::get_if<wire::PoseFrameView>(&*decoded);
  if (frame == nullptr || !poses_.push(stream_, *frame, received_ns, received_ns)) return;
  const wire::PoseFrameHeader& whole = poses_.streams()[stream_].header;
  if (!has_begun()) std::fprintf(stderr, "fire3dv-motion: frames come\n");
  if (has_begun()) frames_missing_ += whole.sequence - recording_.arrivals.back().sequence - 1;
  if (recording_.arrivals.size() < most_frames_)
    recording_.arrivals.push_back({whole.sequence, whole.sim_time_ns, whole.publish_time_ns, received_ns});
}

void Watcher::ask(transport::ListenerLink& link, int64_t now_ns) {
  constexpr int64_t kFirstEveryNs = 100'000'000, kLaterEveryNs = 1'000'000'000;
  constexpr uint64_t kFirst = 10;
  if (now_ns < next_ping_ns_) return;
  next_ping_ns_ = now_ns + (pings_ < kFirst ? kFirstEveryNs : kLaterEveryNs);
  link.send(peer_, wire::encode(wire::Ping{++pings_, static_cast<uint64_t>(now_ns)}));
}

}  // namespace fire3dv::motion
