// A recording as a link that a renderer listens to: its streams come as they came from their adapters, when
// their time has come. One that listens knows no difference; one that steers has a timeline.
#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/record/playback.h"
#include "protocol/replay/queue_link.h"
#include "protocol/replay/replay_clock.h"
#include "protocol/replay/stream_player.h"
#include "protocol/replay/timeline.h"
#include "protocol/transport/link.h"

namespace fire3dv::replay {

struct ReplayOptions {
  std::vector<std::string> streams;  // by name; empty: all
  double speed = 1;                  // 0: as fast as can be
  double start_s = 0, end_s = 0;     // into the recording; end_s 0: its end
  bool loop = false;
  bool each_frame = false;   // a poll gives one frame, as soon as it is asked: nothing is paced
  bool end_streams = false;  // at the end they say goodbye; else the last frame stays
  record::ReadLimits limits;
};

// Thread-safety: one thread does everything, but for stats(). poll() reads the file: it waits for the disk
// and for nothing else, reads nothing before its time has come but the message that is next, and ends after
// some milliseconds of reading when there is more to read than that, whatever it is. seek() reads all that it
// needs.
class ReplayLink final : public transport::ListenerLink, public TimelineControl {
 public:
  static Result<std::unique_ptr<ReplayLink>> open(const std::string& path, const ReplayOptions& options);
  static Result<std::unique_ptr<ReplayLink>> open(std::unique_ptr<record::Source> source,
                                                  const ReplayOptions& options);

  // ListenerLink. Time begins with the first poll: what is opened early waits for who opens late. What is
  // sent is not heard: a recording answers to nobody.
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
  void set_speed(double speed) override;
  void set_looping(bool looping) override { looping_ = looping; }

  record::Playback& playback() { return playback_; }

 private:
  ReplayLink(record::Playback playback, const ReplayOptions& options);
  Result<void> choose_streams(const std::vector<std::string>& names);

  // How much is read in one go.
  class Turn;
  enum class Fetched { message, later, end };
  // The next message of the part that is played, in pending_, its stream chosen or not. later: the turn is
  // over.
  Fetched fetch(Turn& turn);
  void play_pending();
  // Messages up to that moment, without their frames; then the newest frame of each stream. Until it is done
  // nobody hears anything of it.
  void show_state_at(uint64_t log_time_ns);
  void begin_to_show(uint64_t log_time_ns, uint64_t look_back_ns);
  bool go_on_showing(Turn& turn);  // false: there is more to read
  bool all_have_frames() const;
  void take_leave();
  void reach_end();
  void run();
  uint64_t frames() const;

  record::Playback playback_;
  std::vector<std::unique_ptr<StreamPlayer>> players_;  // by stream; null: not asked for
  size_t first_chosen_ = 0;
  std::deque<QueuedEvent> queue_;  // published, not polled yet
  uint64_t start_ns_, end_ns_;
  bool each_frame_, end_streams_, looping_;

  ReplayClock clock_;
  std::optional<record::Played> pending_;  // read, and not due; valid until the playback moves
  std::vector<size_t> leaving_;  // streams whose goodbyes are held: the last of a recording leave its picture
  bool begun_ = false;           // polled, or steered: time runs
  bool at_end_ = false;
  bool step_ = false;
  struct Showing {
    uint64_t log_time_ns, look_back_ns;
    size_t queued;  // before it began
  };
  std::optional<Showing> showing_;
  uint64_t frames_at_round_ = 0;  // a round without a frame is not played again
  std::optional<size_t> newest_;  // stream of the newest frame
  uint64_t damaged_ = 0;
  std::vector<std::string> notes_;
  std::atomic<uint64_t> messages_{0}, bytes_{0};
  std::atomic<uint32_t> peers_{0};
};

}  // namespace fire3dv::replay
