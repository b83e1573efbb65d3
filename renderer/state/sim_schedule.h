// When the frames of one stream are due, on the clock on which they were published: at even distances in the
// simulator's own time, along a line that follows its times of publishing and does not take over their
// unevenness. So a simulator that publishes in bursts, or late now and then, is seen to move as it
// calculated, whether it runs faster or slower than the clock on the wall.
#pragma once

#include <cstdint>

namespace fire3dv::state {

class SimSchedule {
 public:
  struct Place {
    int64_t from_ns = 0;  // the way from the frame before to this one begins here
    int64_t due_ns = 0;   // and ends here; the same where nothing moves between the two (a jump)
  };

  // For frames in the order of their sequences; published_ns never goes back. jump: bodies or time jumped.
  // Simulator time that goes back is one in any case.
  Place next(int64_t sim_ns, int64_t published_ns, bool jump);

 private:
  Place begin_at(int64_t due_ns);
  double measure(double step_ns, double expected_ns, double error_ns);  // the gain of places

  bool begun_ = false;
  bool stood_still_ = false;  // before the last frame
  int64_t sim_ns_ = 0, published_ns_ = 0, due_ns_ = 0;
  double ns_per_sim_ns_ = 0;  // meaningful once measured_ > 0
  uint32_t measured_ = 0;     // steps that it comes from
};

}  // namespace fire3dv::state
