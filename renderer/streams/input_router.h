// Events of people to the streams whose inputs they use: checks the declaration, bounds rates, sends the
// newest of continuous events, and ends the drags of viewers that go away. Main thread.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "protocol/wire/input.h"
#include "renderer/state/pose_state.h"
#include "renderer/streams/receiver_log.h"

namespace fire3dv::app {

// Number of whoever acts: 0 is this renderer's window, others are pages of the live view.
using InputViewer = uint32_t;

class InputRouter {
 public:
  static constexpr int64_t kSendPeriodNs = 8'000'000;      // between continuous events of a viewer and input
  static constexpr int64_t kRepeatPeriodNs = 200'000'000;  // of the last move of a drag: a sign of life
  static constexpr uint32_t kEventsPerSecond = 200;        // of a stream, other than continuous ones
  static constexpr size_t kMaxEpochs = 1024;               // whose last sequences are known, with ended ones

  // Sends to a stream's link; called by the epoch that names the stream.
  struct Link {
    std::function<bool(uint64_t epoch)> carries_input;
    std::function<void(uint64_t epoch, const wire::InputEvent& event)> send;
    std::function<int64_t()> now_ns;  // monotonic clock
  };
  InputRouter(const state::PoseState& poses, Link link);

  // Active streams with declared inputs that can be reached, by slot.
  std::vector<state::StreamId> streams() const;
  // The active stream of an epoch, if its inputs can be reached.
  const state::Stream* find(uint64_t epoch) const;

  // What a person did. The epoch names the stream; source, sequence and times are set here. Returns false if
  // the event is dropped: the stream has ended or does not take it, its text holds control
  // characters, or there are too many.
  bool act(uint64_t epoch, InputViewer viewer, wire::InputEvent event);
  // Ends what the viewer holds.
  void release(InputViewer viewer);
  // Sends the continuous events that are due, repeats the moves of held drags, and forgets what is held of
  // streams that have ended. Call once a turn of the frame loop.
  void update();
  // True while a drag is held or a continuous event waits: turns must be frequent.
  bool is_busy() const { return !pending_.empty() || !holds_.empty(); }

  uint64_t sent() const { return sent_; }
  uint64_t dropped() const { return dropped_; }
  // Changes when any stream's inputs do, or the set of streams.
  uint64_t revision() const;

 private:
  using Key = std::tuple<uint64_t, InputViewer, std::string>;  // epoch, viewer, input
  struct StreamState {
    uint64_t sequence = 0;
    RateLimit limit;
  };
  bool drop() {
    ++dropped_;
    return false;
  }
  StreamState& state_of(uint64_t epoch);
  void send(uint64_t epoch, wire::InputEvent event, int64_t now_ns);
  void flush(const Key& key, int64_t now_ns);
  bool begin_or_end(const Key& key, const wire::InputEvent& event);

  const state::PoseState& poses_;
  const Link link_;
  const uint64_t source_;
  std::map<uint64_t, StreamState> streams_;  // by epoch; ended ones until kMaxEpochs
  uint64_t forgotten_sequence_ = 0;          // the highest of the epochs that streams_ has no more
  std::map<Key, wire::InputEvent> pending_;  // the newest continuous event
  std::map<Key, int64_t> sent_ns_;           // of the last continuous event
  std::map<Key, wire::InputEvent> holds_;    // newest position of each held drag
  uint64_t sent_ = 0, dropped_ = 0;
};

}  // namespace fire3dv::app
