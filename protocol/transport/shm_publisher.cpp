#include "protocol/transport/shm_publisher.h"

#include <algorithm>
#include <array>

#include "protocol/transport/clock.h"
#include "protocol/transport/link_counters.h"
#include "protocol/transport/random.h"
#include "protocol/transport/shm_reply.h"
#include "protocol/transport/shm_ring.h"
#include "protocol/transport/shm_segment.h"
#include "protocol/transport/shm_states.h"

namespace fire3dv::transport::shm {
namespace {

constexpr uint64_t kFirstPoseBytes = 64 << 10;  // 1,300 poses; a larger first frame makes a larger segment
constexpr uint64_t kFirstDescriptionBytes = 64 << 10;
constexpr uint64_t kFirstStateBytes = 16 << 10;
constexpr int64_t kCountReadersEveryNs = 20 * kMillisecondNs;
constexpr int64_t kKeepReplacedForNs = 2 * kSecondNs;
constexpr int64_t kRetryGrowthAfterNs = kSecondNs;
constexpr uint32_t kMaxRingSlots = 1024;

// One segment and what the publisher knows of it.
struct Published {
  Segment segment;
  RingWriter poses, descriptions, controls;
  StatesWriter states;
  std::array<ReplyConsumer, kReaderCount> replies;

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
  }
  Published(const Published&) = delete;
  Published& operator=(const Published&) = delete;
};

class ShmPublisher final : public PublisherLink {
 public:
  ShmPublisher(std::string name, uint64_t publisher_id, SegmentSizes sizes, std::unique_ptr<Published> first)
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
  // Whoever attaches sees one whole frame at once.
  bool takes_partial_frames() const override { return false; }
  bool publish_partial(const wire::MessagePieces&,
                       std::span<const wire::MessagePieces> whole) noexcept override {
    return publish(whole[0], true);
  }
  void send_control(std::span<const std::byte> message) noexcept override;
  bool poll(std::vector<std::byte>& message) override;
  LinkStats stats() const override { return counters_.snapshot(); }

 private:
  // The ring has one writer: a child that was forked without exec is not it.
  bool is_inherited() const { return forked_from_ != fork_generation(); }
  Result<void> grow(const SegmentSizes& sizes, const wire::Bytes& description);
  bool grow_for_pose(size_t bytes) noexcept;
  bool poll_segment(Published& from, std::vector<std::byte>& message);
  void count_readers(int64_t now_ns);
  void write_description() {
    now_->descriptions.write({description_, {}}, 0);
    ++description_number_;
  }

  std::string name_;
  unsigned forked_from_ = fork_generation();
  uint64_t publisher_id_;
  SegmentSizes sizes_;
  std::unique_ptr<Published> now_;
  std::unique_ptr<Published> before_;  // replies that were on their way when it was replaced still count
  wire::Bytes description_;
  uint64_t description_number_ = 0;  // in the segment now in use
  KeyedStates states_;
  uint32_t next_reader_ = 0;
  int64_t forget_before_at_ns_ = 0;
  int64_t next_count_ns_ = 0;
  int64_t no_growth_until_ns_ = 0;
  LinkCounters counters_;
};

Result<void> ShmPublisher::grow(const SegmentSizes& sizes, const wire::Bytes& description) {
  auto made = create_segment(name_, sizes, publisher_id_);
  if (!made) return made.error();
  auto next = std::make_unique<Published>(std::move(*made));
  if (!description.empty()) next->descriptions.write({description, {}}, 0);
  if (states_.count() != 0) next->states.begin_again(states_, description.empty() ? 0 : 1);
  if (auto named = take_name(next->segment, name_, true); !named) return named;
  now_->segment.set_state(
      SegmentState::retired);  // after the rename: a reader that sees it finds the new one
  before_ = std::move(now_);
  forget_before_at_ns_ = monotonic_ns() + kKeepReplacedForNs;
  now_ = std::move(next);
  description_number_ = description.empty() ? 0 : 1;
  sizes_ = sizes;
  return {};
}

bool ShmPublisher::grow_for_pose(size_t bytes) noexcept {
  if (bytes > kMaxMessageBytes || monotonic_ns() < no_growth_until_ns_) return false;
  try {
    SegmentSizes sizes = sizes_;
    sizes.pose_bytes = std::min<uint64_t>(bytes + bytes / 4, kMaxMessageBytes);
    if (grow(sizes, description_)) return true;
  } catch (const std::exception&) {  // out of memory: as when /dev/shm is full
  }
  no_growth_until_ns_ = monotonic_ns() + kRetryGrowthAfterNs;
  return false;
}

Result<void> ShmPublisher::set_description(std::span<const std::byte> message) {
  if (message.size() > kMaxMessageBytes)
    return Error{"shm://" + name_ + ": the description is larger than 256 MiB; describe fewer nodes"};
  if (is_inherited())
    return Error{"shm://" + name_ + ": the link was opened before fork(); open one in the child"};
  // What fails, by an error or for lack of memory, fails before anything has changed.
  wire::Bytes description(message.begin(), message.end());
  KeyedStates earlier = std::move(states_);
  states_ = earlier.emptied();
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
  now_->states.begin_again(states_, description_number_);
  return {};
}

Result<void> ShmPublisher::put_state(uint64_t key, SharedBytes message) {
  if (message->size() > kMaxMessageBytes)
    return Error{"shm://" + name_ + ": a scene edit is larger than 256 MiB; split it or name a file"};
  if (is_inherited())
    return Error{"shm://" + name_ + ": the link was opened before fork(); open one in the child"};
  // As if it replaced nothing; and twice what is needed, so that each byte is moved only now and then.
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

bool ShmPublisher::poll_segment(Published& from, std::vector<std::byte>& message) {
  for (uint32_t i = 0; i < kReaderCount; ++i) {
    const uint32_t reader = (next_reader_ + i) % kReaderCount;
    switch (from.replies[reader].pop(message)) {
      case ReplyConsumer::Outcome::empty:
        break;
      case ReplyConsumer::Outcome::corrupt:
        counters_.reject(Cause::malformed);
        break;
      case ReplyConsumer::Outcome::message:
        next_reader_ = reader + 1;  // turns: one busy reader does not silence the others
        counters_.messages_received.add();
        counters_.bytes_received.add(message.size());
        return true;
    }
  }
  return false;
}

void ShmPublisher::count_readers(int64_t now_ns) {
  if (now_ns < next_count_ns_) return;
  next_count_ns_ = now_ns + kCountReadersEveryNs;
  if (before_ && now_ns > forget_before_at_ns_) before_.reset();
  uint64_t alive = 0;
  for (uint32_t i = 0; i < kReaderCount; ++i) {
    if (atomic_word(now_->segment.reader(i).active).load(std::memory_order_relaxed) == 0) continue;
    if (byte_held_by_other(now_->segment.fd.get(), reader_lock_byte(i))) ++alive;
  }
  counters_.peers.set(alive);
}

bool ShmPublisher::poll(std::vector<std::byte>& message) {
  if (is_inherited()) return false;
  count_readers(monotonic_ns());
  if (before_ && poll_segment(*before_, message)) return true;
  return poll_segment(*now_, message);
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
  const uint64_t publisher_id = random_id();
  auto made = create_segment(name, sizes, publisher_id);
  if (!made) return made.error();
  auto first = std::make_unique<Published>(std::move(*made));
  if (auto named = take_name(first->segment, name, false); !named) return named.error();
  return std::unique_ptr<PublisherLink>(
      std::make_unique<ShmPublisher>(name, publisher_id, sizes, std::move(first)));
}

}  // namespace fire3dv::transport::shm
