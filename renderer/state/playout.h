// The frames of one stream from another machine, shown a little late and evenly: what is to be seen at a time
// lies between two frames that have come by then. How late is chosen from how unevenly frames come, or fixed.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "protocol/wire/messages.h"

namespace fire3dv::state {

// How a stream stands, for people: a picture that is held must not pass for one that lives.
enum class Condition {
  live,  // frames come
  late,  // none has come for a quarter of a second
  lost,  // none has come for seconds
};

// After this long without a frame.
Condition condition_after(int64_t silence_ns);

class Playout {
 public:
  // Nothing: the delay follows the jitter.
  explicit Playout(std::optional<int64_t> fixed_delay_ns = {}) : fixed_delay_ns_(fixed_delay_ns) {}

  // A whole frame came. published_ns: on our clock, as far as it is known. False: it is older than what was
  // shown, or was there already.
  bool add(const wire::PoseFrameHeader& header, std::span<const wire::Affine3x4> poses, int64_t published_ns,
           int64_t received_ns);

  // What to show now. Nothing before the first frame. The header is that of the newest frame at or before the
  // moment shown, with the sim time of that moment.
  struct Shown {
    wire::PoseFrameHeader header;
    std::span<const wire::Affine3x4> poses;  // valid until the next call
    bool changed = false;                    // since the last call
  };
  std::optional<Shown> at(int64_t now_ns);

  int64_t delay_ns() const { return fixed_delay_ns_.value_or(delay_ns_); }
  uint64_t newest_sequence() const { return frames_.empty() ? 0 : frames_.back().header.sequence; }

 private:
  struct Frame {
    wire::PoseFrameHeader header;
    std::vector<wire::Affine3x4> poses;
    int64_t published_ns = 0;
  };
  void measure(int64_t published_ns, int64_t received_ns);
  int64_t interval_ns() const;
  static double way(int64_t into_ns, int64_t span_ns);
  // True when that is something else than what was shown last.
  bool show(const Frame& earlier, const Frame& later, double t);

  std::optional<int64_t> fixed_delay_ns_;
  std::deque<Frame> frames_;  // by sequence; the first is the one at or before what was shown last
  std::vector<std::vector<wire::Affine3x4>> spare_;  // memory of frames that are gone
  std::deque<int64_t> lateness_ns_;                  // of the last frames: received - published
  int64_t delay_ns_ = 0;
  std::vector<wire::Affine3x4> poses_;
  wire::PoseFrameHeader header_;
  uint64_t shown_later_ = 0;  // what poses_ and header_ were made of
  uint64_t shown_earlier_ = 0;
  double shown_t_ = 0;
};

}  // namespace fire3dv::state
