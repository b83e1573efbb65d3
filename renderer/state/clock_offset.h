// How a publisher's monotonic clock stands to ours. Known where both run on one boot of one machine; measured
// by pings where answers come; else only bounded from the times at which frames come, and then it holds the
// shortest way of a frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace fire3dv::state {

class ClockOffset {
 public:
  enum class Source {
    none,        // nothing has come yet
    one_way,     // frames alone: too large by the time that the fastest of them was on its way
    round_trip,  // pings: wrong by at most half the shortest round trip
    same_clock,
  };

  void same_clock();
  // A ping left at sent_ns, its answer says answer_ns on the publisher's clock, and came at received_ns.
  void on_pong(int64_t sent_ns, uint64_t answer_ns, int64_t received_ns);
  void on_frame(uint64_t publish_ns, int64_t received_ns);

  Source source() const;
  // Our clock when the publisher's shows this.
  int64_t local_ns(uint64_t publisher_ns) const;
  // Our clock when what was published then can be here at the soonest: what motion is shown by. Frames are
  // many more than pings, so it hardly changes, and the way itself does not matter. When the quickest frames
  // take longer than before it follows slowly, since whatever it does is seen.
  int64_t soonest_ns(uint64_t publisher_ns) const;
  // How wrong local_ns may be; meaningful for pings alone.
  int64_t uncertainty_ns() const;

 private:
  int64_t shortest_way_ns() const;  // with the offset between the clocks in it
  void follow_shortest_way(int64_t received_ns);
  // The smallest of the last samples is what was disturbed least. Old ones go: clocks drift by parts in a
  // million.
  struct Sample {
    int64_t offset_ns = 0;
    int64_t cost_ns = INT64_MAX;  // round trip, or for frames the offset itself
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
  Best<16> frame_periods_;  // the best of each second
  Sample this_period_;
  int64_t period_began_ns_ = 0;
  int64_t soonest_offset_ns_ = 0, followed_ns_ = 0;
};

}  // namespace fire3dv::state
