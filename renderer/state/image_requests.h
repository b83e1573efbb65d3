// Requested images: a fair scheduler between the requesters (streams), and the registry of their requests.
// Both have no clock and no link: callers pass the time in nanoseconds. Not thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/peer_budget.h"
#include "protocol/wire/image.h"

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

// Outputs and limits that this renderer supports; requests beyond them are refused.
struct ImageAbilities {
  uint32_t outputs = wire::kColorSrgb8;
  bool lenses = false;                              // lens distortion
  bool thin_lenses = false;                         // depth of field
  uint64_t max_pixel_bytes = wire::kMaxPixelBytes;  // of one image
  uint64_t max_open_bytes = uint64_t{1} << 30;  // limit of one requester's open requests if it has no budget
};

// Open requests of each requester and their due times. It checks requests against the renderer's abilities
// and the peer's budget, and refuses the others (SPEC.md, section 13).
class ImageRequestRegistry {
 public:
  struct Refused {
    RequesterId requester = 0;
    wire::ImageRefused answer;
    std::optional<Resource> over;  // the limit of the requester's budget that was exceeded
  };
  // An image that is due now.
  struct Due {
    RequesterId requester = 0;
    wire::ImageRequest request;
    uint64_t number = 0;  // running number within the request, from 1
    uint64_t sequence = 0;
    int64_t sim_time_ns = 0;
    int64_t due_ns = 0;
  };
  // The pose frame of a stream that is shown. sequence 0: no frame yet.
  struct Shown {
    uint64_t epoch = 0;
    uint64_t sequence = 0;
    int64_t sim_time_ns = 0;
  };

  explicit ImageRequestRegistry(const ImageAbilities& abilities = {}) : abilities_(abilities) {}

  // Registers the request, or returns the refusal. The budget is charged while the request is open.
  std::optional<Refused> add(RequesterId requester, const wire::ImageRequest& request,
                             const std::shared_ptr<PeerBudget>& budget = nullptr);
  // Removes all requests of a requester whose stream ended or restarted.
  void remove_all(RequesterId requester) { requests_.erase(requester); }
  // Closes a request that cannot be served.
  void remove(RequesterId requester, uint64_t id);

  using ShownOf = std::function<std::optional<Shown>(RequesterId)>;  // nullopt: unknown stream
  // Demands of all requesters with due images, sorted by requester. Requests that can no longer be served are
  // closed, and their refusals are appended to `refused`.
  std::vector<ImageDemand> demands(const ShownOf& shown, int64_t now_ns, std::vector<Refused>& refused);
  // Due images of one requester, grouped by size and outputs. They stay due until mark_rendered() is called.
  std::vector<Due> due(RequesterId requester, const Shown& shown, int64_t now_ns) const;
  // Marks an image as rendered. Does nothing if its request is closed.
  void mark_rendered(const Due& due);

  // Requester and id of each open request, sorted.
  std::vector<std::pair<RequesterId, uint64_t>> open() const;
  bool is_open(RequesterId requester, uint64_t id) const;
  size_t count() const;
  uint64_t refused() const { return refused_; }

 private:
  struct Entry {
    wire::ImageRequest request;
    uint64_t pixel_bytes = 0;  // bytes of one image without boxes
    BudgetCharge request_charge, bytes_charge;
    uint64_t rendered = 0;  // number of rendered images
    uint64_t last_sequence = 0;
    int64_t last_ns = 0;
  };
  std::optional<Refused> charge(RequesterId requester, const std::shared_ptr<PeerBudget>& budget,
                                Entry& entry);
  enum class Action { wait, render, render_last, overtaken };
  static Action action_now(const Entry& entry, uint64_t sequence, int64_t now_ns);
  Refused refuse(RequesterId requester, const wire::ImageRequest& request, wire::ImageRefusal reason,
                 std::string message);

  ImageAbilities abilities_;
  std::map<RequesterId, std::map<uint32_t, Entry>> requests_;  // the inner key is ImageRequest::place
  uint64_t refused_ = 0;
};

}  // namespace fire3dv::state
