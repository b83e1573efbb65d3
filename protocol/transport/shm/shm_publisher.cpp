#include "protocol/transport/core/link_factories.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <deque>

#include "base/clock.h"
#include "base/random.h"
#include "protocol/transport/core/link_counters.h"
#include "protocol/transport/shm/shm_back_channel.h"
#include "protocol/transport/shm/shm_cleanup.h"
#include "protocol/transport/shm/shm_ring.h"
#include "protocol/transport/shm/shm_segment.h"
#include "protocol/transport/shm/shm_states.h"
#include "protocol/wire/image.h"

namespace fire3dv::transport::shm {
namespace {

constexpr uint64_t kFirstPoseBytes = 64 << 10;  // 1,300 poses; a larger first frame creates a larger segment
constexpr uint64_t kFirstDescriptionBytes = 64 << 10;
constexpr uint64_t kFirstStateBytes = 64 << 10;
constexpr int64_t kCountReadersEveryNs = 20 * kMillisecondNs;
constexpr int64_t kKeepReplacedForNs = 2 * kSecondNs;
constexpr int64_t kRetryGrowthAfterNs = kSecondNs;
constexpr int64_t kLookAtNameEveryNs = kSecondNs;
constexpr uint32_t kMaxRingSlots = 1024;
constexpr size_t kMaxUnreadReplies = 1024;
constexpr int kMaxReadAtOnce = 1024;
constexpr uint64_t kFewestImageSlots = 8;
constexpr uint64_t kReservedImageMemory = uint64_t{256} << 20;  // of slots that no request needs
constexpr uint64_t kMaxImageMemory = uint64_t{4} << 30;
constexpr int64_t kFreeImagesEveryNs = kSecondNs;

// One segment and the publisher's state of it.
struct Published {
  Segment segment;
  RingWriter poses, descriptions, controls;
  StatesWriter states;
  std::array<ReplyConsumer, kReaderCount> replies;
  ImageReader images;
  std::vector<uint64_t> notified_owner;  // per image slot: its owner word when its reader sent the notice
  std::atomic<uint32_t> lent_images{0};  // slots that the caller holds
  int64_t forget_at_ns = 0;              // time of release after replacement

  explicit Published(Segment made) : segment(std::move(made)) {
    SegmentHeader& header = segment.header();
    std::byte* base = segment.mapping.base();
    const auto ring = [&](RingIndex i) {
      return RingWriter(base, segment.geometry.rings[i], header.published[i].value);
    };
    poses = ring(kPoseRing);
    descriptions = ring(kDescriptionRing);
    controls = ring(kControlRing);
    states = StatesWriter(base, segment.geometry.states, header.states_words);
    for (uint32_t i = 0; i < kReaderCount; ++i) replies[i] = ReplyConsumer(segment.reader(i));
    images = ImageReader(base, segment.geometry.images);
    notified_owner.resize(segment.geometry.images.count);
  }
  Published(const Published&) = delete;
  Published& operator=(const Published&) = delete;
};

class ShmPublisher final : public PublisherLink {
 public:
  ShmPublisher(std::string name, uint64_t publisher_id, SegmentSizes sizes, std::shared_ptr<Published> first)
      : name_(std::move(name)), publisher_id_(publisher_id), sizes_(sizes), now_(std::move(first)) {}

  ~ShmPublisher() override {
    if (is_inherited()) return;
    now_->segment.set_state(SegmentState::closed);
    drop_name(now_->segment, name_);
  }

  size_t max_pose_message_bytes() const override { return kMaxMessageBytes; }
  Result<void> set_description(std::span<const std::byte> message) override;
  Result<void> put_state(uint64_t key, SharedBytes message) override;
  bool publish(const wire::MessagePieces& message, bool last_part) noexcept override;
  void send_control(std::span<const std::byte> message) noexcept override;
  bool poll(std::vector<std::byte>& message) override;
  Result<void> make_room_for_images(size_t block_bytes, size_t requests) override;
  std::optional<Image> poll_image() override;
  std::string problem() const override { return problem_; }
  LinkStats stats() const override { return counters_.snapshot(); }

 private:
  // True in a child forked without exec(): the ring has a single writer, the parent.
  bool is_inherited() const { return forked_from_ != fork_generation(); }
  enum class Naming { replace, restore };  // restore: the name was removed
  Result<void> grow(const SegmentSizes& sizes, const wire::Bytes& description,
                    Naming naming = Naming::replace);
  void look_at_name(int64_t now_ns) noexcept;
  bool grow_for_pose(size_t bytes) noexcept;
  bool read_replies();
  bool read_replies_of(const std::shared_ptr<Published>& from);
  void note_image(const std::shared_ptr<Published>& from, uint32_t reader, const ImageNotification& notice);
  bool carry_newest_pose(Published& next);
  void give_up_replaced(int64_t now_ns);
  void count_readers(int64_t now_ns);
  void write_description() {
    now_->descriptions.write({description_, {}}, 0);
    ++description_number_;
  }

  std::string name_;
  unsigned forked_from_ = fork_generation();
  uint64_t publisher_id_;
  SegmentSizes sizes_;
  std::shared_ptr<Published> now_;
  std::deque<std::shared_ptr<Published>> before_;  // replaced segments: replies in transit still count
  // Received replies that the caller has not polled.
  std::deque<std::vector<std::byte>> replies_;
  struct NotedImage {
    std::shared_ptr<Published> from;
    uint32_t reader = 0;
    ImageNotification notice;
    std::shared_ptr<const wire::Bytes> copy = {};  // of a segment that was given up; from is null then
  };
  std::deque<NotedImage> noted_images_;
  std::vector<std::byte> reply_;
  wire::Bytes description_;
  uint64_t description_number_ = 0;  // in the current segment
  uint64_t poses_before_ = 0;        // as in the header
  uint64_t tag_of_newest_pose_ = 0;
  KeyedStates states_;
  int64_t next_free_images_ns_ = 0;
  int64_t next_count_ns_ = 0;
  int64_t no_growth_until_ns_ = 0;
  int64_t next_look_at_name_ns_ = 0;
  std::string problem_;
  LinkCounters counters_;
};

// Replaced segments: neither their descriptors nor images that nobody has polled keep them. Images that were
// lent keep the memory until they are released.
void ShmPublisher::give_up_replaced(int64_t now_ns) {
  for (; !before_.empty() && now_ns > before_.front()->forget_at_ns; before_.pop_front()) {
    Published& old = *before_.front();
    for (NotedImage& noted : noted_images_) {
      if (noted.from != before_.front()) continue;
      noted.from = nullptr;
      const auto block = old.images.take(noted.notice, noted.reader);
      if (!block) continue;  // replaced
      noted.copy = std::make_shared<const wire::Bytes>(block->begin(), block->end());
      old.images.let_go(noted.notice.slot);
    }
    std::erase_if(noted_images_, [](const NotedImage& noted) { return !noted.from && !noted.copy; });
    old.segment.fd = UniqueFd();
    old.segment.lock_fd = UnforkableFd();
  }
}

Result<void> ShmPublisher::grow(const SegmentSizes& sizes, const wire::Bytes& description, Naming naming) {
  give_up_replaced(monotonic_ns());
  auto made = create_segment(name_, sizes, publisher_id_);
  if (!made) return made.error();
  auto next = std::make_shared<Published>(std::move(*made));
  const bool is_for_images =
      sizes.image_slots != sizes_.image_slots || sizes.image_bytes != sizes_.image_bytes;
  const bool has_pose = (is_for_images || naming == Naming::restore) && carry_newest_pose(*next);
  const uint64_t poses_before = poses_before_ + now_->poses.written() - (has_pose ? 1 : 0);
  next->segment.header().poses_before = poses_before;
  if (!description.empty()) next->descriptions.write({description, {}}, 0);
  if (states_.count() != 0) next->states.restart_epoch(states_, description.empty() ? 0 : 1);
  if (auto named = take_name(next->segment, name_, naming == Naming::replace); !named) return named;
  now_->segment.set_state(
      SegmentState::retired);  // after the rename: readers that see it find the new segment
  now_->forget_at_ns = monotonic_ns() + kKeepReplacedForNs;
  before_.push_back(std::move(now_));
  now_ = std::move(next);
  poses_before_ = poses_before;
  if (has_pose) tag_of_newest_pose_ = 1;
  description_number_ = description.empty() ? 0 : 1;
  sizes_ = sizes;
  return {};
}

// Somebody may remove the file: systemd-logind at its user's last logout (RemoveIPC), or rm. Connected
// readers go on, but later ones would find nothing: a new segment takes the name, and all readers follow.
void ShmPublisher::look_at_name(int64_t now_ns) noexcept {
  next_look_at_name_ns_ = now_ns + kLookAtNameEveryNs;
  try {
    const FileId named = file_id(segment_path(name_));
    if (named == file_id(now_->segment.fd.get())) return problem_.clear();
    const Result<void> restored = named == FileId{}
                                      ? grow(sizes_, description_, Naming::restore)
                                      : Error{"shm://" + name_ +
                                              ": its file in /dev/shm was replaced by another "
                                              "publisher's; restart this simulator, or give it another name"};
    problem_ = restored ? std::string() : restored.error().message;
  } catch (const std::exception&) {  // out of memory: tried again at the next look
  }
}

bool ShmPublisher::grow_for_pose(size_t bytes) noexcept {
  if (bytes > kMaxMessageBytes || monotonic_ns() < no_growth_until_ns_) return false;
  try {
    SegmentSizes sizes = sizes_;
    sizes.pose_bytes = std::min<uint64_t>(bytes + bytes / 4, kMaxMessageBytes);
    if (grow(sizes, description_)) return true;
  } catch (const std::exception&) {  // out of memory: handled like a full /dev/shm
  }
  no_growth_until_ns_ = monotonic_ns() + kRetryGrowthAfterNs;
  return false;
}

Result<void> ShmPublisher::set_description(std::span<const std::byte> message) {
  if (message.size() > kMaxMessageBytes)
    return Error{"shm://" + name_ + ": the description is larger than 256 MiB; describe fewer nodes"};
  if (is_inherited())
    return Error{"shm://" + name_ + ": the link was opened before fork(); open one in the child"};
  // Strong guarantee: operations that can fail precede all changes.
  wire::Bytes description(message.begin(), message.end());
  KeyedStates earlier = std::move(states_);
  states_ = earlier.cleared();
  if (message.size() > now_->descriptions.capacity()) {
    SegmentSizes sizes = sizes_;
    sizes.description_bytes = std::min<uint64_t>(message.size() + message.size() / 4, kMaxMessageBytes);
    if (auto grown = grow(sizes, description); !grown) {
      states_ = std::move(earlier);
      return grown;
    }
    description_ = std::move(description);
    return {};
  }
  description_ = std::move(description);
  write_description();
  now_->states.restart_epoch(states_, description_number_);
  return {};
}

Result<void> ShmPublisher::put_state(uint64_t key, SharedBytes message) {
  if (message->size() > kMaxMessageBytes)
    return Error{"shm://" + name_ + ": a scene edit is larger than 256 MiB; split it or name a file"};
  if (is_inherited())
    return Error{"shm://" + name_ + ": the link was opened before fork(); open one in the child"};
  // Sized as if nothing were replaced, and doubled, so that growth costs are amortised.
  const size_t needed = state_bytes(states_) + state_record_bytes(message->size()) + 64;
  if (needed > now_->states.capacity()) {
    SegmentSizes sizes = sizes_;
    sizes.state_bytes = 2 * needed;
    if (auto grown = grow(sizes, description_); !grown) return grown;
  }
  states_.put(key, std::move(message));
  now_->states.put(states_, description_number_);
  counters_.bytes_sent.add_alone(states_.in_order().rbegin()->second.message->size());
  return {};
}

bool ShmPublisher::publish(const wire::MessagePieces& message, bool) noexcept {
  if (is_inherited() || (message.size() > now_->poses.capacity() && !grow_for_pose(message.size()))) {
    counters_.poses_dropped.add();
    counters_.frames_dropped.add();
    return false;
  }
  now_->poses.write(message, description_number_);
  tag_of_newest_pose_ = description_number_;
  counters_.messages_sent.add_alone(1);
  counters_.bytes_sent.add_alone(message.size());
  return true;
}

void ShmPublisher::send_control(std::span<const std::byte> message) noexcept {
  if (is_inherited()) return;
  if (message.size() > now_->controls.capacity()) {
    counters_.reject(Cause::oversize);
    return;
  }
  now_->controls.write({message, {}}, 0);
  counters_.bytes_sent.add_alone(message.size());
}

// Reads at most one reply per reader, so that a busy reader does not starve the others. Returns false if
// there was none.
bool ShmPublisher::read_replies_of(const std::shared_ptr<Published>& from) {
  bool came = false;
  for (uint32_t reader = 0; reader < kReaderCount; ++reader) {
    ImageNotification notice;
    const ReplyConsumer::Outcome outcome = from->replies[reader].pop(reply_, notice);
    came |= outcome != ReplyConsumer::Outcome::empty;
    switch (outcome) {
      case ReplyConsumer::Outcome::empty:
        break;
      case ReplyConsumer::Outcome::corrupt:
        counters_.reject(Cause::malformed);
        break;
      case ReplyConsumer::Outcome::image:
        note_image(from, reader, notice);
        break;
      case ReplyConsumer::Outcome::message:
        counters_.messages_received.add();
        counters_.bytes_received.add(reply_.size());
        replies_.push_back(std::exchange(reply_, {}));
        break;
    }
  }
  return came;
}

// Called when no message or image of the requested kind is queued. Queues the other kind within its limits.
bool ShmPublisher::read_replies() {
  bool came = false;
  for (const auto& segment : before_) came |= read_replies_of(segment);
  came |= read_replies_of(now_);
  while (replies_.size() > kMaxUnreadReplies) {
    replies_.pop_front();
    counters_.reject(Cause::unread);
  }
  return came;
}

void ShmPublisher::note_image(const std::shared_ptr<Published>& from, uint32_t reader,
                              const ImageNotification& notice) {
  if (!from->images.is_sound(notice)) return counters_.reject(Cause::malformed);
  if (!from->images.is_there(notice, reader)) return;  // replaced; a correct reader notifies only once
  const uint64_t owner = image_owner(notice.ticket, reader, ImagePhase::complete);
  if (from->notified_owner[notice.slot] == owner)
    return counters_.reject(Cause::malformed);  // duplicate notice
  if (noted_images_.size() >= 2 * kMaxImageSlots)
    std::erase_if(noted_images_, [](const NotedImage& noted) {
      return noted.from && !noted.from->images.is_there(noted.notice, noted.reader);
    });
  if (noted_images_.size() >= 2 * kMaxImageSlots) return counters_.reject(Cause::unread);
  noted_images_.push_back({from, reader, notice});
  from->notified_owner[notice.slot] = owner;
}

Result<void> ShmPublisher::make_room_for_images(size_t block_bytes, size_t requests) {
  if (is_inherited())
    return Error{"shm://" + name_ + ": the link was opened before fork(); open one in the child"};
  // Two slots per request: one is filled while the caller holds another. Fewer in reserve for large images.
  const uint64_t fewest =
      std::clamp<uint64_t>(kReservedImageMemory / std::max<size_t>(block_bytes, 1), 2, kFewestImageSlots);
  const uint64_t slots = std::max<uint64_t>(2 * requests, fewest);
  SegmentSizes sizes = sizes_;
  if (sizes.image_slots < slots) sizes.image_slots = std::bit_ceil(slots);
  // A quarter in reserve, so that small growth of a view does not replace the segment every time.
  if (block_bytes > sizes.image_bytes)
    sizes.image_bytes = std::min<uint64_t>(block_bytes + block_bytes / 4, kMaxMessageBytes);
  const auto too_much = [&] { return sizes.image_bytes * sizes.image_slots > kMaxImageMemory; };
  if (too_much()) sizes.image_bytes = block_bytes;  // ignores earlier requests, and keeps no reserve
  if (sizes.image_bytes == sizes_.image_bytes && sizes.image_slots == sizes_.image_slots) return {};
  if (sizes.image_slots > kMaxImageSlots || too_much())
    return Error{"shm://" + name_ + ": images of " + std::to_string(requests) + " requests, of up to " +
                 std::to_string(sizes.image_bytes) + " bytes, take more than " +
                 std::to_string(kMaxImageMemory >> 20) + " MiB; request fewer or smaller images"};
  return grow(sizes, description_);
}

std::optional<PublisherLink::Image> ShmPublisher::poll_image() {
  if (is_inherited()) return {};
  const int64_t now_ns = monotonic_ns();
  count_readers(now_ns);
  for (int i = 0; i < kMaxReadAtOnce && noted_images_.empty() && read_replies(); ++i) {
  }
  while (!noted_images_.empty()) {
    const NotedImage noted = std::move(noted_images_.front());
    noted_images_.pop_front();
    if (noted.copy) {
      if (!wire::read_image_block(*noted.copy)) {
        counters_.reject(Cause::malformed);
        continue;
      }
      counters_.images_received.add();
      counters_.bytes_received.add(noted.copy->size());
      return Image{noted.copy, *noted.copy};
    }
    const auto block = noted.from->images.take(noted.notice, noted.reader);
    if (!block) continue;  // a newer image of its request replaced it, and its reader has counted that
    if (!wire::read_image_block(*block)) {
      noted.from->images.let_go(noted.notice.slot);
      counters_.reject(Cause::malformed);
      continue;
    }
    counters_.images_received.add();
    counters_.bytes_received.add(block->size());
    noted.from->lent_images.fetch_add(1, std::memory_order_relaxed);
    const auto let_go = [from = noted.from, slot = noted.notice.slot,
                         generation = fork_generation()](const void*) {
      if (generation != fork_generation()) return;
      from->images.let_go(slot);
      from->lent_images.fetch_sub(1, std::memory_order_relaxed);
    };
    Image image{std::shared_ptr<const void>(block->data(), let_go), *block, true};
    // Half of the slots stay for images to come: a caller that keeps more images gets copies.
    if (noted.from->lent_images.load(std::memory_order_relaxed) >
        noted.from->segment.geometry.images.count / 2) {
      const auto copy = std::make_shared<const wire::Bytes>(block->begin(), block->end());
      image = {copy, *copy};
    }
    return image;
  }
  return {};
}

// Copies the newest pose into the new segment, for readers that join while the simulator pauses.
bool ShmPublisher::carry_newest_pose(Published& next) {
  const RingReader poses(now_->segment.mapping.base(), now_->segment.geometry.rings[kPoseRing],
                         now_->segment.header().published[kPoseRing].value);
  std::vector<std::byte> pose;
  uint64_t tag = 0;
  if (poses.published() == 0 || tag_of_newest_pose_ != description_number_ ||
      poses.read(poses.published(), pose, tag) != RingReader::Outcome::ok)
    return false;
  next.segment.header().carried_poses = 1;
  next.poses.write({pose, {}}, description_.empty() ? 0 : 1);  // the segment begins with one description
  return true;
}

void ShmPublisher::count_readers(int64_t now_ns) {
  if (now_ns < next_count_ns_) return;
  next_count_ns_ = now_ns + kCountReadersEveryNs;
  give_up_replaced(now_ns);
  if (now_ns >= next_look_at_name_ns_) look_at_name(now_ns);
  uint64_t alive = 0;
  for (uint32_t i = 0; i < kReaderCount; ++i) {
    if (atomic_word(now_->segment.reader(i).active).load(std::memory_order_relaxed) == 0) continue;
    if (byte_held_by_other(now_->segment.fd.get(), reader_lock_byte(i))) ++alive;
  }
  counters_.peers.set(alive);
  if (sizes_.image_slots == 0 || now_ns < next_free_images_ns_) return;
  next_free_images_ns_ = now_ns + kFreeImagesEveryNs;
  now_->images.free_unfinished(
      [this](uint32_t reader) {
        return byte_held_by_other(now_->segment.fd.get(), reader_lock_byte(reader));
      },
      [this](const ImageNotification& notice, uint32_t reader) {
        return !now_->replies[reader].is_empty() ||
               now_->notified_owner[notice.slot] == image_owner(notice.ticket, reader, ImagePhase::complete);
      });
}

bool ShmPublisher::poll(std::vector<std::byte>& message) {
  if (is_inherited()) return false;
  count_readers(monotonic_ns());
  for (int i = 0; i < kMaxReadAtOnce && replies_.empty() && read_replies(); ++i) {
  }
  if (replies_.empty()) return false;
  message.swap(replies_.front());
  replies_.pop_front();
  return true;
}

}  // namespace

Result<std::unique_ptr<PublisherLink>> make_publisher(const std::string& name,
                                                      const PublisherOptions& options) {
  if (options.ring_slots < 2 || options.ring_slots > kMaxRingSlots)
    return Error{"shm://" + name + ": ring_slots is " + std::to_string(options.ring_slots) +
                 "; use 2 to 1024"};
  if (options.max_frame_bytes > kMaxMessageBytes)
    return Error{"shm://" + name + ": max_frame_bytes is larger than 256 MiB; choose less"};
  SegmentSizes sizes{};
  sizes.pose_bytes = options.max_frame_bytes != 0 ? options.max_frame_bytes : kFirstPoseBytes;
  sizes.pose_slots = options.ring_slots;
  sizes.description_bytes = kFirstDescriptionBytes;
  sizes.state_bytes = kFirstStateBytes;
  remove_dead_segments(name);  // their memory may be what this one needs
  const uint64_t publisher_id = random_id();
  auto made = create_segment(name, sizes, publisher_id);
  if (!made && remove_dead_segment(segment_path(name))) made = create_segment(name, sizes, publisher_id);
  if (!made) return made.error();
  auto first = std::make_shared<Published>(std::move(*made));
  if (auto named = take_name(first->segment, name, false); !named) return named.error();
  return std::unique_ptr<PublisherLink>(
      std::make_unique<ShmPublisher>(name, publisher_id, sizes, std::move(first)));
}

}  // namespace fire3dv::transport::shm
