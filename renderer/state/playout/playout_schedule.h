// Playout schedule of one stream: due times of its frames on the publish clock. Due times are evenly spaced
// in simulator time along a line fitted to publish times. Bursts and single delays of publishing are
// smoothed, for simulators faster and slower than real time. Times are in nanoseconds. Not thread-safe.
#pragma once

#include <cstdint>

namespace fire3dv::state {

class PlayoutSchedule {
 public:
  struct Place {
    int64_t from_ns = 0;  // start of the motion from the previous frame
    int64_t due_ns = 0;   // end of the motion; equal to from_ns for a jump
  };

  // Schedules the next frame, in sequence order; published_ns must not decrease. jump: bodies or time jumped.
  // A simulator time that goes back is a jump in any case.
  Place next(int64_t sim_ns, int64_t published_ns, bool jump);

 private:
  Place begin_at(int64_t due_ns);
  double measure(double step_ns, double expected_ns, double error_ns);  // returns the position gain

  bool begun_ = false;
  bool stood_still_ = false;  // at the previous frame
  int64_t sim_ns_ = 0, published_ns_ = 0, due_ns_ = 0;
  double ns_per_sim_ns_ = 0;  // valid if measured_ > 0
  uint32_t measured_ = 0;     // number of measured steps
};

}  // namespace fire3dv::state
