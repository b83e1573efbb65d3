#include "renderer/state/image_requests.h"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

#include "base/error.h"

namespace fire3dv::state {
namespace {

constexpr int64_t kActiveNs = 1'000'000'000;
constexpr int64_t kAccountLifetimeNs = 5'000'000'000;  // then the account of an inactive requester is deleted
// Quiet time (without long turns) that a requester gets for each nanosecond of a long turn. The requester
// keeps two thirds of the device's time, hence half of its rate even if the start of its images is delayed,
// too.
constexpr double kQuietShare = 2;
// Safety factor of unmeasured costs: large images take longer per pixel than small images of other
// requesters.
constexpr double kUnmeasured = 2;
// Upper bound of a wait, so that a wrong estimate cannot block a requester for longer.
constexpr double kMaxWaitNs = 10e9;

void smooth(double& average, double sample) {
  average = average > 0 ? 0.75 * average + 0.25 * sample : sample;
}

}  // namespace

void ImageScheduler::note_demands(std::span<const ImageDemand> demands, int64_t now_ns) {
  std::erase_if(accounts_, [&](const Entry& entry) {
    return entry.second.in_flight == 0 && now_ns - entry.second.active_ns > kAccountLifetimeNs;
  });
  for (auto& [requester, account] : accounts_) {
    if (!std::ranges::binary_search(demands, requester, {}, &ImageDemand::requester))
      account.due_since_ns.reset();
    if (account.in_flight > 0) account.active_ns = now_ns;
  }
  for (const ImageDemand& demand : demands) {
    const auto [entry, is_new] = accounts_.try_emplace(demand.requester);
    Account& account = entry->second;
    if (is_new) account.first_ns = now_ns;
    account.active_ns = now_ns;
    if (account.due_since_ns) continue;
    account.due_since_ns = now_ns;
    if (account.finished_ns && account.in_flight == 0)
      smooth(account.pause_ns, static_cast<double>(now_ns - *account.finished_ns));
    account.start = std::max(virtual_now_, account.finish);
  }
}

std::optional<RequesterId> ImageScheduler::next(std::span<const ImageDemand> demands, int64_t now_ns) {
  Entry* best = nullptr;
  for (const ImageDemand& demand : demands) {
    Entry& entry = *accounts_.find(demand.requester);
    if (!may_begin(entry, demand, now_ns)) continue;
    if (!best || entry.second.start < best->second.start) best = &entry;
  }
  if (!best) return {};
  Account& account = best->second;
  virtual_now_ = std::max(virtual_now_, account.start);
  if (account.turn_ns > 0) smooth(account.service_ns, account.turn_ns);
  account.turn_ns = 0;
  account.due_since_ns.reset();
  return best->first;
}

bool ImageScheduler::is_active(const Account& account, int64_t now_ns) const {
  return account.in_flight > 0 || now_ns - account.active_ns < kActiveNs;
}

bool ImageScheduler::is_alone(RequesterId requester, int64_t now_ns) const {
  return std::ranges::none_of(accounts_, [&](const Entry& entry) {
    return entry.first != requester && is_active(entry.second, now_ns);
  });
}

// A turn is long for a requester if it exceeds the requester's period. A requester that pauses tolerates
// turns as long as its pause.
double ImageScheduler::tolerated_ns(const Account& account, int64_t now_ns) {
  const auto since = [&](int64_t time_ns) { return static_cast<double>(now_ns - time_ns); };
  const bool is_known = account.pause_ns >= 0 && account.service_ns >= 0;
  const double period_ns = is_known ? account.pause_ns + account.service_ns : since(account.first_ns);
  return std::max(period_ns, since(account.active_ns));
}

double ImageScheduler::estimate_ns(const Account& account, uint64_t cost) const {
  return static_cast<double>(cost) *
         (account.ns_per_cost > 0 ? account.ns_per_cost : kUnmeasured * ns_per_cost_);
}

bool ImageScheduler::may_begin(const Entry& entry, const ImageDemand& demand, int64_t now_ns) const {
  const auto& [requester, account] = entry;
  if (!is_waiting_allowed_ || is_alone(requester, now_ns)) return true;
  if (account.in_flight > 0) return false;  // its previous turn is in flight
  const double turn_ns =
      std::min(estimate_ns(account, demand.cost),
               std::max(static_cast<double>(slice_ns_), estimate_ns(account, demand.largest)));
  for (const auto& requester_account : accounts_) {
    const RequesterId other_requester = requester_account.first;  // clang 14 captures no structured bindings
    const auto& other = requester_account.second;
    if (other_requester == requester || !is_active(other, now_ns)) continue;
    const double tolerated = tolerated_ns(other, now_ns);
    if (turn_ns <= tolerated) continue;
    if (now_ns < other.quiet_until_ns) return false;
    const double wait_ns = std::min(kQuietShare * (turn_ns - tolerated), kMaxWaitNs);
    if (static_cast<double>(now_ns - account.due_since_ns.value_or(now_ns)) < wait_ns) return false;
    if (std::ranges::any_of(flights_, [&](const Flight& flight) {
          return flight.requester != other_requester && flight.estimate_ns > tolerated;
        }))
      return false;
  }
  return true;
}

void ImageScheduler::submitted(RequesterId requester, uint64_t cost, int64_t now_ns) {
  Account& account = accounts_[requester];
  ++account.in_flight;
  account.active_ns = now_ns;
  account.finish = std::max(account.finish, account.start) + static_cast<double>(cost);
  account.start = account.finish;
  flights_.push_back({requester, cost, estimate_ns(account, cost), now_ns});
}

void ImageScheduler::finished(int64_t begin_ns, int64_t end_ns) {
  FIRE3DV_ASSERT(!flights_.empty());
  const Flight flight = flights_.front();
  flights_.erase(flights_.begin());
  const int64_t took_ns = std::max<int64_t>(end_ns - begin_ns, 0);
  Account& account = accounts_[flight.requester];
  --account.in_flight;
  account.active_ns = end_ns;
  account.finished_ns = end_ns;
  const double turn_before_ns = account.turn_ns;
  account.turn_ns += static_cast<double>(took_ns);
  if (flight.cost > 0) {
    const double ns_per_cost = static_cast<double>(took_ns) / static_cast<double>(flight.cost);
    smooth(account.ns_per_cost, ns_per_cost);
    smooth(ns_per_cost_, ns_per_cost);
  }
  for (auto& [requester, other] : accounts_) {
    if (requester == flight.requester || !is_active(other, begin_ns)) continue;
    const double tolerated = tolerated_ns(other, begin_ns);
    const double more_ns =
        std::max(account.turn_ns - tolerated, 0.0) - std::max(turn_before_ns - tolerated, 0.0);
    if (more_ns <= 0) continue;
    const int64_t left_ns = std::max<int64_t>(other.quiet_until_ns - begin_ns, 0);
    const double quiet_ns = std::min(static_cast<double>(left_ns) + kQuietShare * more_ns, kMaxWaitNs);
    other.quiet_until_ns = end_ns + static_cast<int64_t>(quiet_ns);
  }
}

std::optional<int64_t> ImageScheduler::remaining_ns(int64_t now_ns) const {
  double remaining_ns = 0;
  for (const Flight& flight : flights_) {
    if (flight.estimate_ns <= 0) return {};
    remaining_ns += flight.estimate_ns;
  }
  if (flights_.empty()) return 0;
  // An overdue submission is expected to take as long again as it is overdue.
  const auto elapsed_ns = static_cast<double>(now_ns - flights_.front().submitted_ns);
  const double first_ns = flights_.front().estimate_ns;
  remaining_ns += elapsed_ns < first_ns ? -elapsed_ns : elapsed_ns - first_ns;
  return static_cast<int64_t>(remaining_ns);
}

namespace {

std::string output_names(uint32_t outputs) {
  std::string names;
  for (uint32_t bit = 0; bit < 32; ++bit) {
    if ((outputs >> bit & 1) == 0) continue;
    if (!names.empty()) names += ", ";
    names += bit < wire::kImageOutputCount ? wire::image_output_name(bit) : "of bit " + std::to_string(bit);
  }
  return names;
}

}  // namespace

ImageRequestRegistry::Refused ImageRequestRegistry::refuse(RequesterId requester,
                                                           const wire::ImageRequest& request,
                                                           wire::ImageRefusal reason, std::string message) {
  ++refused_;
  return {requester, {request.epoch, request.id, reason, std::move(message)}, {}};
}

std::optional<ImageRequestRegistry::Refused> ImageRequestRegistry::charge(
    RequesterId requester, const std::shared_ptr<PeerBudget>& budget, Entry& entry) {
  const auto take = [&](Resource resource, uint64_t amount, BudgetCharge& charge) -> std::optional<Refused> {
    Result<BudgetCharge> taken = BudgetCharge::take(budget, resource, amount);
    if (taken) {
      charge = std::move(*taken);
      return {};
    }
    Refused refused = refuse(requester, entry.request, wire::ImageRefusal::too_many,
                             taken.error().message + "; cancel requests, or ask for smaller images");
    refused.over = resource;
    return refused;
  };
  if (auto refused = take(Resource::requests, 1, entry.request_charge)) return refused;
  return take(Resource::request_bytes, entry.pixel_bytes, entry.bytes_charge);
}

std::optional<ImageRequestRegistry::Refused> ImageRequestRegistry::add(
    RequesterId requester, const wire::ImageRequest& request, const std::shared_ptr<PeerBudget>& budget) {
  std::map<uint32_t, Entry>& places = requests_[requester];
  const auto at = places.find(request.place);
  if (at != places.end() && at->second.request.id == request.id && request.when != wire::ImageWhen::never) {
    if (at->second.request == request) return {};  // links may deliver a message twice
    return refuse(requester, request, wire::ImageRefusal::bad_request,
                  "request " + std::to_string(request.id) +
                      " was made already and says something else; an id is used once");
  }
  if (at != places.end()) places.erase(at);
  if (request.when == wire::ImageWhen::never) return {};

  using Refusal = wire::ImageRefusal;
  if (request.when > wire::ImageWhen::exactly)
    return refuse(requester, request, Refusal::not_supported,
                  "ImageRequest.when is " + std::to_string(static_cast<int>(request.when)) +
                      ", which this renderer does not know; update it");
  if (const uint32_t more = request.outputs & ~abilities_.outputs; more != 0)
    return refuse(requester, request, Refusal::not_supported,
                  "this renderer does not make the output " + output_names(more) + "; ask for " +
                      output_names(abilities_.outputs));
  const wire::LensModel lens = request.intrinsics.lens.model;
  if (lens != wire::LensModel::none && (!abilities_.lenses || lens > wire::LensModel::fisheye))
    return refuse(requester, request, Refusal::not_supported,
                  "this renderer does not know the lens " + std::to_string(static_cast<int>(lens)) +
                      "; ask for images without one");
  const bool is_shaded = wire::ImageOutputs(request.outputs).shaded();
  if (request.intrinsics.f_number != 0 && is_shaded && !abilities_.thin_lenses)
    return refuse(requester, request, Refusal::not_supported,
                  "this renderer draws no depth of field, which needs its visibility buffer; leave f_number "
                  "and focus_distance_m out");
  // Boxes are computed from the instance plane, so a request for boxes renders it, too.
  const uint32_t boxes = request.outputs & (wire::kBoxes2d | wire::kBoxes3d);
  const uint32_t drawn = request.outputs | (boxes != 0 ? uint32_t{wire::kInstanceU32} : 0);
  const uint64_t bytes = wire::pixel_bytes_of(request.intrinsics.width, request.intrinsics.height, drawn, 0);
  if (bytes > abilities_.max_pixel_bytes)
    return refuse(requester, request, Refusal::too_large,
                  "an image of " + std::to_string(request.intrinsics.width) + " x " +
                      std::to_string(request.intrinsics.height) + " has " + std::to_string(bytes) +
                      " bytes; at most " + std::to_string(abilities_.max_pixel_bytes) +
                      " are made: ask for a smaller one, or for fewer outputs");
  uint64_t open_bytes = bytes;
  for (const auto& [place, entry] : places) open_bytes += entry.pixel_bytes;
  if (!budget && open_bytes > abilities_.max_open_bytes)
    return refuse(requester, request, Refusal::too_many,
                  "the images that this stream asks for have " + std::to_string(open_bytes) +
                      " bytes together; at most " + std::to_string(abilities_.max_open_bytes) +
                      " are made of one frame: take some back, or ask for smaller ones");
  Entry entry;
  entry.request = request;
  entry.pixel_bytes = bytes;
  if (auto refused = charge(requester, budget, entry)) return refused;
  places[request.place] = std::move(entry);
  return {};
}

void ImageRequestRegistry::remove(RequesterId requester, uint64_t id) {
  const auto places = requests_.find(requester);
  if (places == requests_.end()) return;
  std::erase_if(places->second, [&](const auto& entry) { return entry.second.request.id == id; });
}

ImageRequestRegistry::Action ImageRequestRegistry::action_now(const Entry& entry, uint64_t sequence,
                                                              int64_t now_ns) {
  const wire::ImageRequest& request = entry.request;
  if (sequence < request.sequence) return Action::wait;
  const bool is_first = entry.rendered == 0;
  switch (request.when) {
    case wire::ImageWhen::never:
      break;
    case wire::ImageWhen::once:
      return Action::render_last;
    case wire::ImageWhen::every_nth:
      return is_first || sequence - entry.last_sequence >= request.every ? Action::render : Action::wait;
    case wire::ImageWhen::rate: {
      const bool is_time = static_cast<double>(now_ns - entry.last_ns) * request.rate_hz >= 1e9;
      return is_first || (is_time && sequence > entry.last_sequence) ? Action::render : Action::wait;
    }
    case wire::ImageWhen::exactly:
      return sequence == request.sequence ? Action::render_last : Action::overtaken;
  }
  return Action::wait;
}

std::vector<ImageDemand> ImageRequestRegistry::demands(const ShownOf& shown, int64_t now_ns,
                                                       std::vector<Refused>& refused) {
  std::vector<ImageDemand> demands;
  for (auto& [requester, places] : requests_) {
    if (places.empty()) continue;
    const std::optional<Shown> now = shown(requester);
    if (!now) continue;
    ImageDemand demand{requester, 0, 0};
    for (auto at = places.begin(); at != places.end();) {
      const wire::ImageRequest& request = at->second.request;
      const Action action =
          request.epoch == now->epoch ? action_now(at->second, now->sequence, now_ns) : Action::wait;
      if (action == Action::overtaken) {
        refused.push_back(refuse(requester, request, wire::ImageRefusal::overtaken,
                                 "frame " + std::to_string(request.sequence) +
                                     " is not shown any more; frame " + std::to_string(now->sequence) +
                                     " is: wait for images in lockstep, or ask for what is shown next"));
        at = places.erase(at);
        continue;
      }
      if (action != Action::wait) {
        const uint64_t cost = image_cost(request.intrinsics.width, request.intrinsics.height);
        demand.cost += cost;
        demand.largest = std::max(demand.largest, cost);
      }
      ++at;
    }
    if (demand.cost > 0) demands.push_back(demand);
  }
  return demands;
}

std::vector<ImageRequestRegistry::Due> ImageRequestRegistry::due(RequesterId requester, const Shown& shown,
                                                                 int64_t now_ns) const {
  std::vector<Due> due;
  const auto places = requests_.find(requester);
  if (places == requests_.end()) return due;
  for (const auto& [place, entry] : places->second) {
    if (entry.request.epoch != shown.epoch) continue;
    const Action action = action_now(entry, shown.sequence, now_ns);
    if (action != Action::render && action != Action::render_last) continue;
    due.push_back({requester, entry.request, entry.rendered + 1, shown.sequence, shown.sim_time_ns, now_ns});
  }
  // Images of the same size and outputs become neighbours, so that one submission can draw them.
  std::stable_sort(due.begin(), due.end(), [](const Due& a, const Due& b) {
    const wire::Intrinsics &of_a = a.request.intrinsics, &of_b = b.request.intrinsics;
    return std::tuple(of_a.width, of_a.height, a.request.outputs) <
           std::tuple(of_b.width, of_b.height, b.request.outputs);
  });
  return due;
}

void ImageRequestRegistry::mark_rendered(const Due& due) {
  const auto places = requests_.find(due.requester);
  if (places == requests_.end()) return;
  const auto at = places->second.find(due.request.place);
  if (at == places->second.end() || at->second.request.id != due.request.id) return;
  Entry& entry = at->second;
  if (action_now(entry, due.sequence, due.due_ns) == Action::render_last) {
    places->second.erase(at);
    return;
  }
  entry.rendered = due.number;
  entry.last_sequence = due.sequence;
  entry.last_ns = due.due_ns;
}

std::vector<std::pair<RequesterId, uint64_t>> ImageRequestRegistry::open() const {
  std::vector<std::pair<RequesterId, uint64_t>> open;
  for (const auto& [requester, places] : requests_)
    for (const auto& [place, entry] : places) open.emplace_back(requester, entry.request.id);
  std::ranges::sort(open);
  return open;
}

bool ImageRequestRegistry::is_open(RequesterId requester, uint64_t id) const {
  const auto places = requests_.find(requester);
  return places != requests_.end() && std::ranges::any_of(places->second, [&](const auto& entry) {
           return entry.second.request.id == id;
         });
}

size_t ImageRequestRegistry::count() const {
  size_t count = 0;
  for (const auto& [requester, places] : requests_) count += places.size();
  return count;
}

}  // namespace fire3dv::state
