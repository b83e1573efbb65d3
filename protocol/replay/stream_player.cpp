#include "protocol/replay/stream_player.h"

#include <algorithm>
#include <chrono>
#include <fstream>

#include "base/clock.h"
#include "base/random.h"
#include "protocol/wire/limits.h"

namespace fire3dv::replay {
namespace {

constexpr int kMaxRepliesPerPoll = 256;
// The limits of an adapter.

uint64_t now_ns() {
  return static_cast<uint64_t>(monotonic_ns());
}

wire::ClockInfo clocks_now(double sim_seconds_per_second) {
  wire::ClockInfo clock;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> clock.boot_id;
  clock.monotonic_at_open_ns = now_ns();
  clock.realtime_at_open_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(
                                  std::chrono::system_clock::now().time_since_epoch())
                                  .count();
  clock.sim_seconds_per_second = sim_seconds_per_second;
  return clock;
}

}  // namespace

void StreamPlayer::jump(bool new_epoch) {
  jumped_ = true;
  reset_frames();
  fresh_epoch_ = fresh_epoch_ || new_epoch;
  recorded_epoch_ = 0;
}

// Open frames count as incomplete.
void StreamPlayer::reset_frames() {
  counts_.incomplete += assembler_.close_up_to(UINT64_MAX);
  begun_sequence_ = sequence_ = 0;
  gathered_.reset();
}

uint64_t StreamPlayer::publish_time_ns() const {
  return as_of_ns_ != 0 ? as_of_ns_ : now_ns();
}

bool StreamPlayer::publish_assembled() {
  gathering_ = false;
  if (!gathered_) return false;
  wire::PoseFrameView whole;
  whole.header = *gathered_;
  whole.node_count = node_count_;
  gathered_.reset();
  send_whole(whole);
  return true;
}

Result<void> StreamPlayer::play(const record::Played& played) {
  const auto decoded = decoder_.decode(played.message);
  if (!decoded) {
    ++counts_.skipped;
    return {};
  }
  if (const auto* description = std::get_if<wire::StreamDescription>(&*decoded))
    return play_description(*description, played.message);
  if (const auto* frame = std::get_if<wire::PoseFrameView>(&*decoded)) {
    play_frame(*frame, played.message);
  } else if (played.kind == record::Played::Kind::edit) {
    return play_edit(played);
  } else if (played.kind == record::Played::Kind::goodbye) {
    end();
  }
  return {};
}

Result<void> StreamPlayer::play_edit(const record::Played& played) {
  const auto known = edit_bytes_of_key_.find(played.edit_key);
  const bool is_new = known == edit_bytes_of_key_.end();
  const uint64_t rest = edit_bytes_ - (is_new ? 0 : known->second);
  if ((is_new && edit_bytes_of_key_.size() == wire::kMaxSceneEdits) ||
      rest + played.message.size() > wire::kMaxSceneEditBytes) {
    ++counts_.dropped_edits;
    return {};
  }
  edit_bytes_ = rest + played.message.size();
  edit_bytes_of_key_[played.edit_key] = played.message.size();
  auto edit = std::make_shared<wire::Bytes>(played.message.begin(), played.message.end());
  if (epoch_ != recorded_epoch_) wire::set_epoch(*edit, epoch_);
  return link_->put_state(played.edit_key, std::move(edit));
}

void StreamPlayer::end() {
  if (is_live()) link_->send_control(wire::encode(wire::Goodbye{epoch_}));
  ended_ = true;
  reset_frames();
}

Result<void> StreamPlayer::play_description(const wire::StreamDescription& description,
                                            std::span<const std::byte> message) {
  if (description.protocol_major != wire::kProtocolMajor) return {};
  recorded_epoch_ = description.epoch;
  ended_ = false;
  edit_bytes_of_key_.clear();  // the link drops them together with the old description
  edit_bytes_ = 0;
  epoch_ = fresh_epoch_ ? random_id() : description.epoch;
  node_count_ = static_cast<uint32_t>(description.node_names.size());
  reset_frames();
  if (verbatim_ && epoch_ == recorded_epoch_) return link_->set_description(message);
  wire::StreamDescription published = description;
  published.epoch = epoch_;
  if (!verbatim_) published.clock = clocks_now(description.clock.sim_seconds_per_second);
  return link_->set_description(wire::encode(published));
}

void StreamPlayer::play_frame(const wire::PoseFrameView& frame, std::span<const std::byte> message) {
  const bool is_of_stream =
      recorded_epoch_ != 0 && frame.header.epoch == recorded_epoch_ && frame.node_count == node_count_;
  if (!is_of_stream || frame.header.sequence <= sequence_) {
    ++counts_.skipped;
    return;
  }
  if (!frame.node_indices.empty()) return play_partial(frame, message);
  begun_sequence_ = std::max(begun_sequence_, frame.header.sequence);
  if (frame.poses.size() < node_count_) return play_part(frame);
  poses_.assign(frame.poses.begin(), frame.poses.end());
  set_newest(frame.header.sequence);
  if (gathering_) {
    gathered_ = frame.header;
    return;
  }
  const bool as_it_is =
      verbatim_ && !jumped_ && epoch_ == recorded_epoch_ && message.size() <= link_->max_pose_message_bytes();
  if (!as_it_is) return send_whole(frame);
  ++counts_.frames;
  sim_time_ns_ = frame.header.sim_time_ns;
  link_->publish({message, {}});
}

void StreamPlayer::play_part(const wire::PoseFrameView& part) {
  using Outcome = stream::FrameAssembler::Outcome;
  const Outcome outcome = assembler_.add(part);
  counts_.incomplete += assembler_.take_given_up();
  if (outcome == Outcome::stale || outcome == Outcome::refused) ++counts_.skipped;
  if (outcome != Outcome::whole) return;
  poses_.assign(assembler_.poses().begin(), assembler_.poses().end());
  set_newest(part.header.sequence);
  if (gathering_)
    gathered_ = part.header;
  else
    send_whole(part);
}

// Publishes a partial frame only if its base frame is complete; otherwise it would mix the poses of two
// steps.
void StreamPlayer::play_partial(const wire::PoseFrameView& frame, std::span<const std::byte> message) {
  const bool has_base = sequence_ != 0 && begun_sequence_ == sequence_;
  if (sequence_ != 0) begun_sequence_ = std::max(begun_sequence_, frame.header.sequence);
  if (!has_base) {
    ++counts_.skipped;
    return;
  }
  for (size_t i = 0; i < frame.poses.size(); ++i) poses_[frame.node_indices[i]] = frame.poses[i];
  set_newest(frame.header.sequence);
  if (gathering_)
    gathered_ = frame.header;
  else
    send_partial(frame, message);
}

// Marks poses_ as this frame and drops older open frames.
void StreamPlayer::set_newest(uint64_t sequence) {
  sequence_ = sequence;
  begun_sequence_ = std::max(begun_sequence_, sequence);
  counts_.incomplete += assembler_.close_up_to(sequence);
}

void StreamPlayer::send_whole(wire::PoseFrameView frame) {
  cut(frame);
  ++counts_.frames;
  for (size_t i = 0; i < parts_.size(); ++i) link_->publish(parts_[i], i + 1 == parts_.size());
}

void StreamPlayer::send_partial(wire::PoseFrameView frame, std::span<const std::byte> message) {
  if (!link_->takes_partial_frames() || jumped_) {
    send_whole(frame);
    return;
  }
  cut(frame);
  ++counts_.frames;
  wire::Bytes partial(message.begin(), message.end());
  if (!verbatim_ || epoch_ != recorded_epoch_) {
    frame.header.epoch = epoch_;
    if (!verbatim_) frame.header.publish_time_ns = publish_time_ns();
    partial = wire::encode(frame);
  }
  link_->publish_partial({partial, {}}, parts_);
}

// Encodes all of poses_ with the frame's header, in as many messages as the link needs.
void StreamPlayer::cut(wire::PoseFrameView whole) {
  sim_time_ns_ = whole.header.sim_time_ns;
  whole.header.epoch = epoch_;
  if (!verbatim_) whole.header.publish_time_ns = publish_time_ns();
  if (jumped_) whole.header.flags |= wire::kFrameDiscontinuity;
  jumped_ = false;
  whole.node_indices = {};
  const size_t per_part = std::max<size_t>(1, wire::poses_per_part(link_->max_pose_message_bytes()));
  const size_t parts = std::max<size_t>(1, (poses_.size() + per_part - 1) / per_part);
  encoders_.resize(std::max(parts, encoders_.size()));
  parts_.clear();
  for (size_t part = 0; part < parts; ++part) {
    whole.first_node = static_cast<uint32_t>(part * per_part);
    whole.poses = std::span<const wire::Affine3x4>(poses_).subspan(
        part * per_part, std::min(per_part, poses_.size() - part * per_part));
    parts_.push_back(encoders_[part].encode(whole));
  }
}

uint32_t StreamPlayer::poll() {
  for (int i = 0; i < kMaxRepliesPerPoll && link_->poll(reply_); ++i) {
    const auto decoded = reply_decoder_.decode(reply_);
    const auto* ping = decoded ? std::get_if<wire::Ping>(&*decoded) : nullptr;
    if (ping != nullptr)
      link_->send_control(wire::encode(wire::Pong{ping->id, ping->sender_time_ns, now_ns()}));
  }
  return link_->stats().peers;
}

}  // namespace fire3dv::replay
