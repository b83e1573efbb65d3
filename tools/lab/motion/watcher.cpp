#include "tools/lab/motion/watcher.h"

#include <cstdio>
#include <utility>

namespace fire3dv::motion {

using transport::LinkEvent;

Watcher::Watcher(size_t most_frames) : most_frames_(most_frames) {
  recording_.assign(most_frames, {});  // touches the pages, so that they are resident
  recording_.clear();
}

void Watcher::poll(transport::ListenerLink& link, int64_t now_ns) {
  link.poll([&](const LinkEvent& event) {
    if (event.kind == LinkEvent::Kind::note)
      std::fprintf(stderr, "fire3dv-motion: %s\n", std::string(event.text).c_str());
    if (event.kind == LinkEvent::Kind::pose || event.kind == LinkEvent::Kind::control)
      take(event.peer, event.message, event.received_ns != 0 ? event.received_ns : now_ns);
    if (stream_ != state::kNone && event.peer == peer_) link.accept(peer_);
  });
  if (stream_ == state::kNone) return;
  (void)poses_.advance(now_ns);
  note_condition();
}

void Watcher::note_condition() {
  using state::Condition;
  const Condition was = std::exchange(condition_, poses_.streams()[stream_].condition);
  if (was == condition_) return;
  std::fprintf(stderr, "fire3dv-motion: %s\n", state::condition_name(condition_));
  times_lost_ += condition_ == Condition::lost;
  times_late_ += was == Condition::live;
}

void Watcher::take(transport::PeerId peer, std::span<const std::byte> message, int64_t received_ns) {
  const auto decoded = decoder_.decode(message);
  if (!decoded) return;
  if (const auto* description = std::get_if<wire::StreamDescription>(&*decoded)) {
    if (stream_ != state::kNone && description->epoch != epoch_) return;  // only the first stream is watched
    peer_ = peer;
    if (stream_ != state::kNone) return;
    stream_ = poses_.add_stream(*description);
    epoch_ = description->epoch;
    return;
  }
  if (stream_ == state::kNone || peer != peer_) return;
  const auto* frame = std::get_if<wire::PoseFrameView>(&*decoded);
  if (frame == nullptr || !poses_.push(stream_, *frame, received_ns, received_ns)) return;
  const wire::PoseFrameHeader& whole = poses_.streams()[stream_].header;
  if (!has_begun()) std::fprintf(stderr, "fire3dv-motion: frames come\n");
  if (has_begun()) frames_missing_ += whole.sequence - recording_.back().sequence - 1;
  if (recording_.size() < most_frames_)
    recording_.push_back({whole.sequence, whole.sim_time_ns, whole.publish_time_ns, received_ns});
}

}  // namespace fire3dv::motion
