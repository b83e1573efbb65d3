#include "renderer/offline/stream_frames.h"

namespace fire3dv::offline {
namespace {

constexpr int64_t kMaxSimTimeNs = int64_t{1} << 60;  // 36 years: sums of a few such times do not overflow

}  // namespace

StreamFrames::Taken StreamFrames::take(const record::Played& played) {
  Taken taken;
  auto decoded = decoder_.decode(played.message);
  if (!decoded) {
    ++unusable_;
    return taken;
  }
  if (const auto* description = std::get_if<wire::StreamDescription>(&*decoded)) {
    if (receiver_ && description->epoch == receiver_->epoch) return taken;  // repeated description
    if (description->protocol_major != wire::kProtocolMajor) {
      ++unusable_;
      return taken;
    }
    receiver_.emplace(description->epoch, description->node_names.size());
    sim_time_ns_.reset();
    taken.began = true;
    return taken;
  }
  if (!receiver_) {
    ++unusable_;
    return taken;
  }
  if (const auto* frame = std::get_if<wire::PoseFrameView>(&*decoded)) {
    const bool sound =
        frame->header.sim_time_ns > -kMaxSimTimeNs && frame->header.sim_time_ns < kMaxSimTimeNs;
    if (!sound) ++unusable_;
    taken.frame = sound && receiver_->push(*frame);
  } else if (auto* edit = std::get_if<wire::SceneEdit>(&*decoded)) {
    taken.edited = true;
    taken.frame = receiver_->apply(std::move(*edit));
    (void)receiver_->take_edits();  // only the frames are used
  } else if (const auto* unknown = std::get_if<wire::UnknownEdit>(&*decoded)) {
    taken.edited = true;
    taken.frame = receiver_->apply(*unknown);
  } else if (std::holds_alternative<wire::Goodbye>(*decoded)) {
    receiver_.reset();
    taken.ended = true;
  }
  if (taken.frame) {
    taken.segment = !sim_time_ns_ || header().sim_time_ns < *sim_time_ns_;
    sim_time_ns_ = header().sim_time_ns;
  }
  return taken;
}

}  // namespace fire3dv::offline
