#include "renderer/offline/stream_frames.h"

namespace fire3dv::offline {
namespace {

constexpr int64_t kMostSimTimeNs = int64_t{1} << 60;  // 36 years: sums of a few such times do not overflow

const scene::Scene& no_scene() {
  static const scene::Scene scene;
  return scene;
}

}  // namespace

StreamFrames::StreamFrames() : frames_(no_scene()) {}

StreamFrames::Taken StreamFrames::take(const record::Played& played) {
  Taken taken;
  auto decoded = decoder_.decode(played.message);
  if (!decoded) {
    ++unusable_;
    return taken;
  }
  if (const auto* description = std::get_if<wire::StreamDescription>(&*decoded)) {
    if (id_ && description->epoch == epoch_) return taken;  // repeated description
    if (description->protocol_major != wire::kProtocolMajor) {
      ++unusable_;
      return taken;
    }
    if (id_) frames_.remove_stream(*id_);
    id_ = frames_.add_stream(*description);
    epoch_ = description->epoch;
    sim_time_ns_.reset();
    taken.began = true;
    return taken;
  }
  if (!id_) {
    ++unusable_;
    return taken;
  }
  if (const auto* frame = std::get_if<wire::PoseFrameView>(&*decoded)) {
    const bool sound =
        frame->header.sim_time_ns > -kMostSimTimeNs && frame->header.sim_time_ns < kMostSimTimeNs;
    if (!sound) ++unusable_;
    taken.frame = sound && frames_.push(*id_, *frame);
  } else if (auto* edit = std::get_if<wire::SceneEdit>(&*decoded)) {
    taken.edited = true;
    taken.frame = frames_.apply(*id_, std::move(*edit));
    (void)frames_.take_scene_changes();  // only the frames are used
  } else if (const auto* unknown = std::get_if<wire::UnknownEdit>(&*decoded)) {
    taken.edited = true;
    taken.frame = frames_.apply(*id_, *unknown);
  } else if (std::holds_alternative<wire::Goodbye>(*decoded)) {
    frames_.remove_stream(*id_);
    id_.reset();
    taken.ended = true;
  }
  if (taken.frame) {
    taken.segment = !sim_time_ns_ || header().sim_time_ns < *sim_time_ns_;
    sim_time_ns_ = header().sim_time_ns;
  }
  return taken;
}

}  // namespace fire3dv::offline
