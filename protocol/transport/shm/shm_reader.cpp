#include "protocol/transport/shm/shm_reader.h"

#include <algorithm>
#include <utility>

#include "protocol/wire/image.h"

namespace fire3dv::transport::shm {

using Kind = LinkEvent::Kind;
using Outcome = RingReader::Outcome;

Reader::Reader(Found found, Delivery delivery, const Progress* before, LinkCounters& counters, bool replies)
    : segment_(std::move(found.segment)), id_(found.id), delivery_(delivery), counters_(counters) {
  SegmentHeader& header = segment_.header();
  const auto ring = [&](RingIndex i) {
    return RingReader(segment_.mapping.base(), segment_.geometry.rings[i], header.published[i].value);
  };
  poses_ = ring(kPoseRing);
  descriptions_ = ring(kDescriptionRing);
  controls_ = ring(kControlRing);
  states_ = StatesReader(segment_.mapping.base(), segment_.geometry.states, header.states_words);
  // A joiner receives the newest pose, or all poses in the ring; earlier control messages are skipped.
  const uint64_t poses = poses_.published();
  if (delivery_ == Delivery::newest) last_pose_ = poses == 0 ? 0 : poses - 1;
  if (delivery_ == Delivery::all && !before) last_pose_ = poses - std::min(poses, poses_.count() - 1);
  if (!before) last_control_ = controls_.published();
  const bool saw_carried = before && before->poses == segment_.geometry.poses_before + 1;
  if (saw_carried && segment_.geometry.carried_poses == 1 && poses != 0)
    last_pose_ = std::max<uint64_t>(last_pose_, 1);
  for (uint32_t i = 0; i < kReaderCount && replies && !reader_index_; ++i) {
    if (!try_lock_byte(segment_.lock_fd.get(), reader_lock_byte(i))) continue;
    reader_index_ = i;
    ReaderSlot& slot = segment_.reader(i);
    replies_ = ReplyProducer(slot);
    images_ = ImageWriter(segment_.mapping.base(), segment_.geometry.images, i);
    atomic_word(slot.pid).store(static_cast<uint64_t>(::getpid()), std::memory_order_relaxed);
    atomic_word(slot.active).store(1, std::memory_order_release);
  }
}

Reader::~Reader() {
  // A forked child must not release its parent's slot.
  if (!reader_index_ || forked_from_ != fork_generation()) return;
  atomic_word(segment_.reader(*reader_index_).active).store(0, std::memory_order_release);
  unlock_byte(segment_.lock_fd.get(), reader_lock_byte(*reader_index_));
}

bool Reader::send_image(uint64_t request, std::span<const std::byte> head, size_t pixel_bytes,
                        const Fill& fill) {
  if (forked_from_ != fork_generation()) return false;
  const size_t pixels = wire::pixels_at(head.size());
  // Checked first: begin() may drop an image that the publisher has been notified of.
  const auto reservation =
      replies_.has_room_for_notice() ? images_.begin(request, pixels + pixel_bytes) : std::nullopt;
  if (!reservation) {
    counters_.images_dropped.add();
    return false;
  }
  if (reservation->overtakes) counters_.images_dropped.add();
  wire::write_image_block_head(reservation->block, request, head);
  fill(reservation->block.subspan(pixels));
  images_.complete(*reservation);
  if (!replies_.push(ImageNotification{reservation->slot, reservation->ticket})) {
    images_.give_up(*reservation);
    counters_.images_dropped.add();
    return false;
  }
  counters_.images_sent.add();
  counters_.bytes_sent.add(reservation->block.size());
  return true;
}

bool Reader::has_unread() const {
  return poses_.published() != last_pose_ || descriptions_.published() != last_description_ ||
         controls_.published() != last_control_ || states_.has_unread() ||
         segment_.state() != SegmentState::live;
}

std::optional<Reader::End> Reader::end_by_state() const {
  switch (segment_.state()) {
    case SegmentState::live:
      return {};
    case SegmentState::retired:
      return End::retired;
    case SegmentState::closed:
      return End::closed;
  }
  return End::closed;  // unknown value: no publisher writes it, so the segment is closed
}

std::optional<Reader::End> Reader::end_by_file(const std::string& path) {
  if (!byte_held_by_other(segment_.fd.get(), kPublisherLockByte)) return End::dead;
  const FileId named = file_id(path);
  if (named == id_ || segment_.state() != SegmentState::live) return {};
  if (named != FileId{}) return End::replaced;
  has_lost_name_ = true;
  return {};
}

bool Reader::drain(Progress& progress, const OnMessage& on_message) {
  const bool poses_sound = delivery_ == Delivery::newest ? drain_newest_pose(progress, on_message)
                                                         : drain_all_poses(progress, on_message);
  progress.poses = segment_.geometry.poses_before + last_pose_;
  if (!poses_sound) return false;
  if (descriptions_.published() != last_description_ && !drain_description(progress, on_message))
    return false;
  return drain_states(progress, on_message) && drain_controls(on_message);
}

bool Reader::drain_newest_pose(Progress& progress, const OnMessage& on_message) {
  // Bounded retries: a writer that laps this reader during every copy must not block the poll; the next poll
  // retries.
  for (uint64_t tries = 0; tries < poses_.count(); ++tries) {
    const uint64_t newest = poses_.published();
    if (newest == last_pose_) return true;
    if (newest < last_pose_) return false;  // a correct publisher never counts backwards
    uint64_t tag = 0;
    const Outcome outcome = poses_.read(newest, buffer_, tag);
    if (outcome == Outcome::corrupt) return false;
    if (outcome == Outcome::lapped) continue;
    add_overtaken(newest - last_pose_ - 1);
    last_pose_ = newest;
    return deliver_pose(progress, tag, on_message);
  }
  return true;
}

bool Reader::drain_all_poses(Progress& progress, const OnMessage& on_message) {
  const uint64_t until = poses_.published();
  if (until < last_pose_) return false;
  while (last_pose_ < until) {
    uint64_t tag = 0;
    const Outcome outcome = poses_.read(last_pose_ + 1, buffer_, tag);
    if (outcome == Outcome::corrupt) return false;
    if (outcome == Outcome::ok) {
      ++last_pose_;
      if (!deliver_pose(progress, tag, on_message)) return false;
      continue;
    }
    // Lapped: continue in the middle of the ring, so as not to be lapped again immediately.
    const uint64_t newest = std::max(poses_.published(), until);
    const uint64_t behind = std::min(newest, poses_.count() / 2);
    const uint64_t next = std::max(last_pose_ + 1, newest - behind);
    add_overtaken(next - last_pose_);
    last_pose_ = next;
  }
  return true;
}

bool Reader::deliver_pose(Progress& progress, uint64_t tag, const OnMessage& on_message) {
  const bool has_states = states_.has_unread();  // put before the pose was published
  if (tag > last_description_ || has_states) {
    std::vector<std::byte> pose = std::move(buffer_);
    const bool sound = (tag <= last_description_ || drain_description(progress, on_message)) &&
                       drain_states(progress, on_message);
    buffer_ = std::move(pose);
    if (!sound) return false;
  }
  count_received();
  on_message(Kind::pose, buffer_, std::exchange(overtaken_, 0));
  return true;
}

bool Reader::drain_description(Progress& progress, const OnMessage& on_message) {
  for (uint64_t tries = 0; tries < 2; ++tries) {
    const uint64_t newest = descriptions_.published();
    if (newest <= last_description_) return newest == last_description_;
    uint64_t tag = 0;
    const Outcome outcome = descriptions_.read(newest, buffer_, tag);
    if (outcome == Outcome::corrupt) return false;
    if (outcome == Outcome::lapped) continue;
    last_description_ = newest;
    if (buffer_ == progress.description) return true;  // the same description, copied into a larger segment
    progress.description = buffer_;
    count_received();
    on_message(Kind::control, progress.description, 0);
    return true;
  }
  return true;  // changes faster than it can be read; the next poll retries
}

bool Reader::drain_states(Progress& progress, const OnMessage& on_message) {
  const auto deliver = [&](uint64_t tag, std::span<const std::byte> state) {
    if (tag > last_description_ && !drain_description(progress, on_message)) return false;
    if (tag < last_description_) return true;  // of a description that has been replaced
    counters_.messages_received.add();
    counters_.bytes_received.add(state.size());
    on_message(Kind::control, state, 0);
    return true;
  };
  return states_.drain(progress.state, deliver) == StatesReader::Outcome::ok;
}

bool Reader::drain_controls(const OnMessage& on_message) {
  const uint64_t until = controls_.published();
  if (until < last_control_) return false;
  if (until - last_control_ > controls_.count()) {
    counters_.reject(Cause::lapped, until - last_control_ - controls_.count());
    last_control_ = until - controls_.count();
  }
  while (last_control_ < until) {
    uint64_t tag = 0;
    const Outcome outcome = controls_.read(++last_control_, buffer_, tag);
    if (outcome == Outcome::corrupt) return false;
    if (outcome == Outcome::lapped) {
      counters_.reject(Cause::lapped);
      continue;
    }
    count_received();
    on_message(Kind::control, buffer_, 0);
  }
  return true;
}

void Reader::add_overtaken(uint64_t poses) {
  counters_.poses_dropped.add(poses);
  overtaken_ += poses;
}

void Reader::count_received() {
  counters_.messages_received.add();
  counters_.bytes_received.add(buffer_.size());
}

}  // namespace fire3dv::transport::shm
