// Fair scheduler between the requesters of images (streams). It has no clock and no link: callers pass the
// time in nanoseconds. Not thread-safe.
#pragma once

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

// Due images of one requester. Costs are in pixels (image_cost()).
struct ImageDemand {
  RequesterId requester = 0;
  uint64_t cost = 0;     // of all images
  uint64_t largest = 0;  // of the most expensive image
};

// Render cost of one image: its pixels plus a fixed amount for culling and set-up.
constexpr uint64_t image_cost(uint32_t width, uint32_t height) {
  return uint64_t{width} * height + 16'384;
}

// Start-time fair queueing by render cost selects the next requester. A turn that exceeds another requester's
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

  // Records a submission to the device, in submission order.
  void submitted(RequesterId requester, uint64_t cost, int64_t now_ns);
  // Records that the oldest submission in flight is done. begin_ns: a device was free to execute it.
  void finished(int64_t begin_ns, int64_t end_ns);
  size_t in_flight() const { return flights_.size(); }
  // Estimated time until the last submission in flight is done; nullopt before the first measurement.
  std::optional<int64_t> remaining_ns(int64_t now_ns) const;

 private:
  struct Account {
    double start = 0, finish = 0;  // virtual times of fair queueing, in cost units
    int64_t active_ns = 0;         // last time with a demand or a submission in flight
    std::optional<int64_t> due_since_ns;
    int64_t quiet_until_ns = 0;  // no turn that is long for this requester begins before
    size_t in_flight = 0;
    double ns_per_cost = 0;  // measured; 0 = unknown
    // Period = pause between an image and the next demand, plus time on the device. Negative: unknown.
    double pause_ns = -1, service_ns = -1;
    int64_t first_ns = 0;
    std::optional<int64_t> finished_ns;  // end of the last submission
    double turn_ns = 0;                  // time of the finished submissions of the last turn
  };
  struct Flight {
    RequesterId requester = 0;
    uint64_t cost = 0;
    double estimate_ns = 0;
    int64_t submitted_ns = 0;
  };
  using Entry = std::pair<const RequesterId, Account>;

  bool may_begin(const Entry& entry, const ImageDemand& demand, int64_t now_ns) const;
  bool is_active(const Account& account, int64_t now_ns) const;
  double estimate_ns(const Account& account, uint64_t cost) const;
  static double tolerated_ns(const Account& account, int64_t now_ns);

  const int64_t slice_ns_;
  const bool is_waiting_allowed_;
  std::map<RequesterId, Account> accounts_;
  std::vector<Flight> flights_;
  double virtual_now_ = 0;
  double ns_per_cost_ = 0;  // average of all requesters; 0 = unknown
};

}  // namespace fire3dv::state
