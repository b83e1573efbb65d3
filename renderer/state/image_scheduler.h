// Fair scheduler between the requesters of images (streams). It has no clock and no link: callers pass the
// time in nanoseconds. Not thread-safe.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace fire3dv::state {

// Identity of a stream's run as requester of images. StreamReceiver assigns a new one to each accepted
// description, and never reuses it; a StreamId is the slot that the run has meanwhile.
using RequesterId = uint64_t;

// Due images of one requester. Costs: image_cost().
struct ImageDemand {
  RequesterId requester = 0;
  uint64_t cost = 0;   // of all images
  uint64_t first = 0;  // of the image that is drawn first
};

// Work of one image beyond that of its pixels.
struct ImageEffort {
  uint32_t outputs = 1;       // planes that are drawn
  bool is_distorted = false;  // a larger pinhole image, and its distortion
  bool is_blurred = false;    // depth of field
  bool has_markers = false;
  uint32_t path_samples = 0;  // of each pixel; 0: no paths are traced
};

// Render cost of one image: its pixels, weighted by what is drawn of them, plus a fixed amount for culling
// and set-up. ImageScheduler scales costs to the measured times of each requester.
constexpr uint64_t image_cost(uint32_t width, uint32_t height, const ImageEffort& effort = {}) {
  constexpr uint32_t kPlane = 4;  // weights are quarters of a plane of colours
  uint64_t weight = kPlane + (effort.outputs > 1 ? effort.outputs - 1 : 0);
  if (effort.is_distorted) weight += 1 * kPlane;
  if (effort.is_blurred) weight += 2 * kPlane;
  if (effort.has_markers) weight += 1 * kPlane;
  if (effort.path_samples > 0) weight += uint64_t{effort.path_samples} * 2 * kPlane;
  return uint64_t{width} * height * weight / kPlane + 16'384;
}

// Measured times of images by their cost. Small images take longer for their cost than large ones, so that
// each order of magnitude has a mean of its own.
class ImageTimes {
 public:
  void add(uint64_t cost, uint64_t images, double ns);
  // Time for a cost, of images of this cost each; 0: nothing is measured. others: of all requesters, whose
  // times count with a safety factor where these have none.
  double ns_per_cost(uint64_t image_cost, const ImageTimes& others) const;

 private:
  double measured(uint64_t image_cost) const;  // of this or the next measured size; 0: none

  static constexpr size_t kSizes = 20;
  std::array<double, kSizes> ns_per_cost_{};  // by the logarithm of the cost; 0: not measured
};

// Start-time fair queueing by render time selects the next requester: estimated from the cost at the start of
// a turn, corrected to the measured time at its end. A turn that exceeds another requester's
// period starts only after twice as much time without such turns. Every requester therefore keeps at least
// half of its undisturbed rate.
class ImageScheduler {
 public:
  // slice_ns: the longest turn of several images. is_waiting_allowed false: every demand is served
  // immediately, for lockstep, where all requesters wait for all images.
  explicit ImageScheduler(int64_t slice_ns, bool is_waiting_allowed = true)
      : slice_ns_(slice_ns), is_waiting_allowed_(is_waiting_allowed) {}

  // Sets the current demands, sorted by requester.
  void note_demands(std::span<const ImageDemand> demands, int64_t now_ns);
  // Selects the requester whose turn begins; nullopt if all must wait. demands: noted ones that are not
  // served yet.
  std::optional<RequesterId> next(std::span<const ImageDemand> demands, int64_t now_ns);
  // True if no other requester was active within the last second.
  bool is_alone(RequesterId requester, int64_t now_ns) const;

  // Cost of the largest submission of several images in this time by the measured times, of images of this
  // cost each, unless the requester is alone. One image may cost more.
  uint64_t max_cost(RequesterId requester, uint64_t image_cost, int64_t span_ns, int64_t now_ns) const;

  // Records a submission to the device, in submission order.
  void submitted(RequesterId requester, uint64_t cost, uint64_t images, int64_t now_ns);
  // Records that the oldest submission in flight is done. begin_ns: a device was free to execute it.
  // has_compiled: pipelines were compiled in it, so that its time says nothing about later ones.
  void finished(int64_t begin_ns, int64_t end_ns, bool has_compiled = false);
  // Records host time for the requester's images beside their submissions, such as for copies.
  void spent(RequesterId requester, int64_t begin_ns, int64_t end_ns);
  size_t in_flight() const { return flights_.size(); }
  // Estimated time until the last submission in flight is done; nullopt before the first measurement.
  std::optional<int64_t> remaining_ns(int64_t now_ns) const;

 private:
  struct Account {
    double start = 0,
           finish = 0;      // virtual times of fair queueing, in ns; in cost units before a measurement
    int64_t active_ns = 0;  // last time with a demand or a submission in flight
    std::optional<int64_t> due_since_ns;
    int64_t quiet_until_ns = 0;  // no turn that is long for this requester begins before
    size_t in_flight = 0;
    ImageTimes times;
    // Period = pause between an image and the next demand, plus time on the device. Negative: unknown. The
    // pause ends when the demand was last seen to be absent, so that turns of others do not lengthen it.
    double pause_ns = -1, service_ns = -1;
    int64_t first_ns = 0;
    std::optional<int64_t> finished_ns;  // end of the last submission
    double turn_ns = 0;                  // time of the finished submissions of the last turn
  };
  struct Flight {
    RequesterId requester = 0;
    uint64_t cost = 0, images = 0;
    double estimate_ns = 0;
    int64_t submitted_ns = 0;
  };
  using Entry = std::pair<const RequesterId, Account>;

  bool may_begin(const Entry& entry, const ImageDemand& demand, int64_t now_ns) const;
  bool is_active(const Account& account, int64_t now_ns) const;
  double estimate_ns(const Account& account, uint64_t cost, uint64_t image_cost) const {
    return static_cast<double>(cost) * account.times.ns_per_cost(image_cost, times_);
  }
  void add_turn_time(RequesterId requester, int64_t begin_ns, int64_t end_ns);
  static double tolerated_ns(const Account& account, int64_t now_ns);

  const int64_t slice_ns_;
  const bool is_waiting_allowed_;
  std::map<RequesterId, Account> accounts_;
  std::vector<Flight> flights_;
  double virtual_now_ = 0;
  std::optional<int64_t> noted_ns_;  // last note_demands()
  ImageTimes times_;                 // of all requesters
};

}  // namespace fire3dv::state
