// Fair order of the requested images of all askers (streams). Start-time fair queueing by render cost picks
// the next asker. A turn that exceeds another asker's period starts only after that asker had twice as much
// time without such turns, so that every asker keeps at least half of its undisturbed rate. Pure bookkeeping:
// the caller passes the time.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

namespace fire3dv::state {

// Images of one asker that are due. Costs are in pixels (image_cost()).
struct ImageDemand {
  uint64_t asker = 0;
  uint64_t cost = 0;     // of all images
  uint64_t largest = 0;  // of the most expensive image
};

// Cost of one image: its pixels, and a fixed amount for culling and set-up.
constexpr uint64_t image_cost(uint32_t width, uint32_t height) {
  return uint64_t{width} * height + 16'384;
}

class ImageTurns {
 public:
  using Asker = uint64_t;

  // slice_ns: the longest turn of several images. is_waiting_allowed: false serves a demand always at once,
  // for a renderer in lockstep, where all askers wait for all images anyway.
  explicit ImageTurns(int64_t slice_ns, bool is_waiting_allowed = true)
      : slice_ns_(slice_ns), is_waiting_allowed_(is_waiting_allowed) {}

  // All demands that exist now, in the order of their askers.
  void note_demands(std::span<const ImageDemand> demands, int64_t now_ns);
  // Asker whose turn begins; none when all of them have to wait. demands: those noted that are not served
  // yet.
  std::optional<Asker> next(std::span<const ImageDemand> demands, int64_t now_ns);
  // No other asker was active within the last second.
  bool is_alone(Asker asker, int64_t now_ns) const;

  // Submissions, in their order. begin_ns: when a device was free to execute it.
  void submitted(Asker asker, uint64_t cost, int64_t now_ns);
  void finished(int64_t begin_ns, int64_t end_ns);  // the oldest one in flight
  size_t in_flight() const { return flights_.size(); }
  // Estimate of the time until the last submission in flight is done; none before the first measurement.
  std::optional<int64_t> remaining_ns(int64_t now_ns) const;

 private:
  struct Account {
    double start = 0, finish = 0;  // virtual times, in cost
    int64_t active_ns = 0;         // last time with a demand or a submission in flight
    std::optional<int64_t> due_since_ns;
    int64_t quiet_until_ns = 0;  // until then no turn that is long for this asker begins
    size_t in_flight = 0;
    double ns_per_cost = 0;  // measured; 0: unknown
    // Period: pause from image to next demand, and own time on the device. Negative: unknown.
    double pause_ns = -1, service_ns = -1;
    int64_t first_ns = 0;
    std::optional<int64_t> finished_ns;  // last submission
    double turn_ns = 0;                  // of the submissions of the last turn that are done
  };
  struct Flight {
    Asker asker = 0;
    uint64_t cost = 0;
    double estimate_ns = 0;
    int64_t submitted_ns = 0;
  };
  using Entry = std::pair<const Asker, Account>;

  bool may_begin(const Entry& entry, const ImageDemand& demand, int64_t now_ns) const;
  bool is_active(const Account& account, int64_t now_ns) const;
  double estimate_ns(const Account& account, uint64_t cost) const;
  static double tolerated_ns(const Account& account, int64_t now_ns);

  const int64_t slice_ns_;
  const bool is_waiting_allowed_;
  std::map<Asker, Account> accounts_;
  std::vector<Flight> flights_;
  double virtual_now_ = 0;
  double ns_per_cost_ = 0;  // of all askers; 0: unknown
};

}  // namespace fire3dv::state
