// Reader of one shared-memory segment, from attaching to its end.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "protocol/transport/core/link_counters.h"
#include "protocol/transport/link.h"
#include "protocol/transport/shm/shm_back_channel.h"
#include "protocol/transport/shm/shm_ring.h"
#include "protocol/transport/shm/shm_segment.h"
#include "protocol/transport/shm/shm_states.h"

namespace fire3dv::transport::shm {

// Progress over all segments of one publisher.
struct Progress {
  wire::Bytes description;
  uint64_t state = 0;  // number of the newest keyed state
  uint64_t poses = 0;  // poses published up to the newest one that was delivered or skipped
};

class Reader {
 public:
  // overtaken: see LinkEvent.
  using OnMessage =
      std::function<void(LinkEvent::Kind, std::span<const std::byte> message, uint64_t overtaken)>;
  enum class End { retired, closed, dead, replaced };

  // before: progress in the previous segment of the same publisher, to skip delivered messages; null: none.
  // replies: takes a reader slot for the back channel, by which the publisher counts its renderers.
  Reader(Found found, Delivery delivery, const Progress* before, LinkCounters& counters, bool replies = true);
  ~Reader();
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  const FileId& id() const { return id_; }
  bool can_reply() const { return reader_index_.has_value(); }
  bool reply(std::span<const std::byte> message) {
    return forked_from_ == fork_generation() && replies_.push(message);
  }

  // Same as ListenerLink::send_image(), for the single publisher.
  using Fill = std::function<void(std::span<std::byte> pixels)>;
  bool send_image(uint64_t request, std::span<const std::byte> head, size_t pixel_bytes, const Fill& fill);

  bool has_unread() const;

  // Checks the state word of the segment; cheap.
  std::optional<End> end_by_state() const;
  // Checks the publisher's lock and the name: two system calls.
  std::optional<End> end_by_file(const std::string& path);
  // True once end_by_file() found that a living publisher's segment has no name any more.
  bool has_lost_name() const { return has_lost_name_; }

  // Delivers all new messages: each pose after its description and keyed states. Returns false if the segment
  // is invalid.
  bool drain(Progress& progress, const OnMessage& on_message);

 private:
  bool drain_newest_pose(Progress& progress, const OnMessage& on_message);
  bool drain_all_poses(Progress& progress, const OnMessage& on_message);
  bool deliver_pose(Progress& progress, uint64_t tag, const OnMessage& on_message);
  bool drain_description(Progress& progress, const OnMessage& on_message);
  bool drain_states(Progress& progress, const OnMessage& on_message);
  bool drain_controls(const OnMessage& on_message);
  void count_received();
  void add_overtaken(uint64_t poses);

  Segment segment_;
  FileId id_;
  Delivery delivery_;
  LinkCounters& counters_;
  RingReader poses_, descriptions_, controls_;
  StatesReader states_;
  uint64_t last_pose_ = 0;  // numbers of the newest delivered or skipped messages
  uint64_t overtaken_ = 0;  // poses skipped since the last delivered one
  uint64_t last_description_ = 0;
  uint64_t last_control_ = 0;
  bool has_lost_name_ = false;
  unsigned forked_from_ = fork_generation();
  std::optional<uint32_t> reader_index_;  // index in the reader table
  ReplyProducer replies_;
  ImageWriter images_;
  std::vector<std::byte> buffer_;
};

}  // namespace fire3dv::transport::shm
