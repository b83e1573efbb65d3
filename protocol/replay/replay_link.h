// ListenerLink that plays a recording: its streams arrive as from their adapters, at their recorded times.
// Implements TimelineControl for seeking and pausing.
#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocol/record/playback.h"
#include "protocol/replay/replay_clock.h"
#include "protocol/replay/stream_player.h"
#include "protocol/transport/link.h"
#include "protocol/wire/limits.h"

namespace fire3dv::replay {

struct QueuedEvent {
  transport::LinkEvent::Kind kind{};
  transport::PeerId peer = 0;
  wire::Bytes message;
};

// In-process publisher link: queues published messages for a listener in the same process.
class QueueLink final : public transport::PublisherLink {
 public:
  // Borrows the queue, which must outlive this object.
  QueueLink(std::deque<QueuedEvent>& queue, transport::PeerId peer) : queue_(queue), peer_(peer) {}

  size_t max_pose_message_bytes() const override { return wire::kMaxMessageBytes; }
  Result<void> set_description(std::span<const std::byte> message) override {
    put(transport::LinkEvent::Kind::control, {message, {}});
    return {};
  }
  Result<void> put_state(uint64_t, transport::SharedBytes message) override {
    put(transport::LinkEvent::Kind::control, {*message, {}});
    return {};
  }
  bool publish(const wire::MessagePieces& message, bool) noexcept override {
    put(transport::LinkEvent::Kind::pose, message);
    return true;
  }
  void send_control(std::span<const std::byte> message) noexcept override {
    put(transport::LinkEvent::Kind::control, {message, {}});
  }
  bool poll(std::vector<std::byte>&) override { return false; }
  transport::LinkStats stats() const override { return {}; }

 private:
  void put(transport::LinkEvent::Kind kind, const wire::MessagePieces& message) {
    wire::Bytes bytes;
    bytes.reserve(message.size());
    bytes.insert(bytes.end(), message.head.begin(), message.head.end());
    bytes.insert(bytes.end(), message.body.begin(), message.body.end());
    queue_.push_back({kind, peer_, std::move(bytes)});
  }

  std::deque<QueuedEvent>& queue_;
  transport::PeerId peer_;
};

struct ReplayOptions {
  std::vector<std::string> streams;  // names; empty: all
  double speed = 1;                  // 0: unpaced
  double start_s = 0, end_s = 0;     // seconds into the recording; end_s 0: its end
  bool loop = false;
  bool each_frame = false;   // unpaced: each poll delivers one frame
  bool end_streams = false;  // at the end, streams send Goodbye; otherwise the last frame remains
  record::ReadLimits limits;
};

// Single-threaded except for stats(). poll() reads the file and blocks only on the disk. It reads at most one
// message ahead and returns after some milliseconds, even if more messages are due. seek() reads everything
// that it needs.
class ReplayLink final : public transport::ListenerLink, public TimelineControl {
 public:
  static Result<std::unique_ptr<ReplayLink>> open(const std::string& path, const ReplayOptions& options);
  static Result<std::unique_ptr<ReplayLink>> open(std::unique_ptr<record::Source> source,
                                                  const ReplayOptions& options);

  // ListenerLink. Time starts with the first poll, so that the renderer misses nothing. send() is ignored: a
  // recording has no back channel.
  void poll(const std::function<void(const transport::LinkEvent&)>& on_event) override;
  void wait(std::chrono::nanoseconds timeout) override;
  void send(transport::PeerId, std::span<const std::byte>) override {}
  transport::LinkStats stats() const override;
  std::string uri() const override;

  TimelineState timeline() const override;
  void play() override;
  void pause() override;
  void seek(uint64_t log_time_ns) override;
  Result<void> seek_sim_time(int64_t sim_time_ns) override;
  void step() override;
  void step_back() override;
  void set_speed(double speed) override;
  void set_looping(bool looping) override { looping_ = looping; }

  record::Playback& playback() { return playback_; }

 private:
  ReplayLink(record::Playback playback, const ReplayOptions& options);
  Result<void> choose_streams(const std::vector<std::string>& names);

  // Time limit of one poll.
  class TimeSlice;
  enum class Fetched { message, later, end };
  // Fetches the next message of the played range, of a chosen stream or not, into pending_. later: the time
  // limit is reached.
  Fetched fetch(TimeSlice& turn);
  void play_pending();
  // Seek: applies all messages up to that time without their frames, then the newest frame of each stream.
  // Events are delivered only when the seek is complete.
  void show_state_at(uint64_t log_time_ns);
  void begin_seek(uint64_t log_time_ns, uint64_t look_back_ns);
  bool continue_seek(TimeSlice& turn);  // false: more to read
  bool all_have_frames() const;
  void send_goodbyes();
  void reach_end();
  void run();
  uint64_t frames() const;

  record::Playback playback_;
  std::vector<std::unique_ptr<StreamPlayer>> players_;  // by stream; null: not chosen
  size_t first_chosen_ = 0;
  std::deque<QueuedEvent> queue_;  // published, not polled yet
  uint64_t start_ns_, end_ns_;
  bool each_frame_, end_streams_, looping_;

  ReplayClock clock_;
  std::optional<record::Played> pending_;  // next message, not due yet; valid until the playback moves
  // Streams with a delayed goodbye: the last goodbyes of a recording are dropped, so that its image remains.
  std::vector<size_t> delayed_goodbyes_;
  bool begun_ = false;  // polled or controlled: time runs
  bool at_end_ = false;
  bool step_ = false;
  struct Showing {
    uint64_t log_time_ns, look_back_ns;
    size_t queued;  // events queued before the seek
  };
  std::optional<Showing> showing_;
  uint64_t frames_at_round_ = 0;   // a round without a frame is not repeated
  std::optional<size_t> newest_;   // stream of the newest frame
  uint64_t long_wait_for_ns_ = 0;  // log time of the message behind the pause that was reported last
  uint64_t shown_ns_ = 0;          // log time of the newest published frame; 0: none
  uint64_t assembled_ns_ = 0;      // log time of the newest frame that a seek has assembled; 0: none
  uint64_t damaged_ = 0;
  std::vector<std::string> notes_;
  std::atomic<uint64_t> messages_{0}, bytes_{0};
  std::atomic<uint32_t> peers_{0};
};

}  // namespace fire3dv::replay
