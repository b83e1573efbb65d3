// Timing of a stream's frames: liveness by their arrival, and the offset of the publisher's clock. Times are
// in nanoseconds. Not thread-safe.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fire3dv::state {

enum class Condition : uint8_t {
  live,  // frames arrive
  // No frame for 0.25 s or for four of the stream's own intervals.
  late,
  lost,  // no frame for seconds
};
constexpr const char* condition_name(Condition condition) {
  constexpr const char* kNames[] = {"live", "late", "lost"};
  return kNames[static_cast<size_t>(condition)];
}

// Live, late or lost, by arrival times of whole frames. Viewers mark the images of stale streams with it.
class Liveness {
 public:
  void on_frame(int64_t received_ns);
  // Returns live before the first frame: no stale frame is shown then.
  Condition at(int64_t now_ns) const;
  // Intervals between the newest frames, oldest first, for jitter plots.
  std::vector<float> gaps_ms() const;

 private:
  int64_t late_after_ns() const;

  int64_t last_ns_ = 0;
  int64_t last_gap_ns_ = 0;
  double interval_ns_ = 0;
  static constexpr size_t kMaxGaps = 96;
  std::array<float, kMaxGaps> gaps_ms_{};
  size_t gaps_ = 0;  // count since the start
};

// Clock offset estimator between a publisher's monotonic clock and the local one. The offset is exact within
// one boot of one machine. Ping round trips measure it on links with a return path; else one-way delays bound
// it.
class ClockOffset {
 public:
  enum class Source {
    none,        // no sample yet
    one_way,     // frames only: the offset includes the smallest one-way delay
    round_trip,  // pings: the error is at most half the shortest round trip
    same_clock,
  };

  void same_clock();
  // Adds a ping sample. sent_ns and received_ns are local; answer_ns is the publisher's clock in the pong.
  void on_pong(int64_t sent_ns, uint64_t answer_ns, int64_t received_ns);
  void on_frame(uint64_t publish_ns, int64_t received_ns);

  Source source() const;
  // Converts a time of the publisher's clock to the local clock.
  int64_t local_ns(uint64_t publisher_ns) const;
  // Earliest local time at which a frame published at publisher_ns can arrive; playout schedules motion by
  // it. It includes the one-way delay. It follows a longer delay at a limited rate, since a step would be
  // visible.
  int64_t soonest_ns(uint64_t publisher_ns) const;
  // Error bound of local_ns(); 0 unless the source is round_trip.
  int64_t uncertainty_ns() const;

 private:
  int64_t shortest_way_ns() const;  // smallest one-way delay plus the clock offset
  void follow_shortest_way(int64_t received_ns);
  // Minimum filter: the sample with the smallest delay is the least disturbed one. Old samples expire, since
  // clocks drift by parts in a million.
  struct Sample {
    int64_t offset_ns = 0;
    int64_t cost_ns = INT64_MAX;  // round trip; for frames the offset itself
  };
  template <size_t count>
  struct Best {
    std::array<Sample, count> samples{};
    size_t next = 0;
    void add(Sample sample) { samples[next++ % count] = sample; }
    Sample least() const;
  };
  bool same_ = false;
  Best<16> pongs_;
  Best<16> frame_periods_;  // the best sample of each second
  Sample this_period_;
  int64_t period_began_ns_ = 0;
  int64_t soonest_offset_ns_ = 0, followed_ns_ = 0;
};

}  // namespace fire3dv::state
