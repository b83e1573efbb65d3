#include "renderer/state/image_scheduler.h"

#include <algorithm>
#include <bit>
#include <limits>

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

// Index of ImageTimes: a size is four times the next smaller one.
size_t size_of(uint64_t image_cost) {
  constexpr uint64_t kSmallest = 256;
  const auto bits = static_cast<size_t>(std::bit_width(image_cost / kSmallest));
  return std::min<size_t>((bits + 1) / 2, 19);
}

// Single slow images, such as those that compile pipelines, count as so many times the average at most.
constexpr double kMaxGrowth = 4;

// Cost of a submission of several images before the first measurement.
constexpr uint64_t kMaxUnmeasuredCost = 1 << 20;

}  // namespace

void ImageTimes::add(uint64_t cost, uint64_t images, double ns) {
  if (cost == 0) return;
  double& average = ns_per_cost_[size_of(cost / std::max<uint64_t>(images, 1))];
  const double sample = ns / static_cast<double>(cost);
  smooth(average, average > 0 ? std::min(sample, kMaxGrowth * average) : sample);
}

double ImageTimes::measured(uint64_t image_cost) const {
  const size_t size = size_of(image_cost);
  for (size_t i = size; i < kSizes; ++i)
    if (ns_per_cost_[i] > 0) return ns_per_cost_[i];
  for (size_t i = size; i-- > 0;)
    if (ns_per_cost_[i] > 0) return ns_per_cost_[i];
  return 0;
}

double ImageTimes::ns_per_cost(uint64_t image_cost, const ImageTimes& others) const {
  const double own = ns_per_cost_[size_of(image_cost)];
  if (own > 0) return own;
  // Of other sizes: a single slow image, such as the first one, says little about others.
  const double of_others = kUnmeasured * others.measured(image_cost), of_sizes = measured(image_cost);
  return of_sizes > 0 ? std::min(of_sizes, of_others) : of_others;
}

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
      smooth(account.pause_ns,
             static_cast<double>(std::max<int64_t>(noted_ns_.value_or(now_ns) - *account.finished_ns, 0)));
    account.start = std::max(virtual_now_, account.finish);
  }
  noted_ns_ = now_ns;
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

uint64_t ImageScheduler::max_cost(RequesterId requester, uint64_t image_cost, int64_t span_ns,
                                  int64_t now_ns) const {
  const auto known = accounts_.find(requester);
  if (!is_waiting_allowed_ || known == accounts_.end() || is_alone(requester, now_ns))
    return std::numeric_limits<uint64_t>::max();
  const double each_ns = known->second.times.ns_per_cost(image_cost, times_);
  if (each_ns <= 0) return kMaxUnmeasuredCost;
  const double cost = static_cast<double>(std::max<int64_t>(span_ns, 0)) / each_ns;
  return cost < 1e15 ? static_cast<uint64_t>(cost) : std::numeric_limits<uint64_t>::max();
}

bool ImageScheduler::may_begin(const Entry& entry, const ImageDemand& demand, int64_t now_ns) const {
  const auto& [requester, account] = entry;
  if (!is_waiting_allowed_ || is_alone(requester, now_ns)) return true;
  if (account.in_flight > 0) return false;  // its previous turn is in flight
  const double turn_ns =
      std::min(estimate_ns(account, demand.cost, demand.first),
               std::max(static_cast<double>(slice_ns_), estimate_ns(account, demand.first, demand.first)));
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

void ImageScheduler::submitted(RequesterId requester, uint64_t cost, uint64_t images, int64_t now_ns) {
  Account& account = accounts_[requester];
  ++account.in_flight;
  account.active_ns = now_ns;
  const double estimate = estimate_ns(account, cost, cost / std::max<uint64_t>(images, 1));
  account.finish = std::max(account.finish, account.start) + estimate;
  account.start = account.finish;
  flights_.push_back({requester, cost, images, estimate, now_ns});
}

void ImageScheduler::finished(int64_t begin_ns, int64_t end_ns, bool has_compiled) {
  FIRE3DV_ASSERT(!flights_.empty());
  const Flight flight = flights_.front();
  flights_.erase(flights_.begin());
  const auto took_ns = static_cast<double>(std::max<int64_t>(end_ns - begin_ns, 0));
  Account& account = accounts_[flight.requester];
  --account.in_flight;
  account.active_ns = end_ns;
  account.finished_ns = end_ns;
  if (has_compiled) return;  // charged as estimated
  const double correction_ns = took_ns - flight.estimate_ns;
  account.start += correction_ns;
  account.finish += correction_ns;
  account.times.add(flight.cost, flight.images, took_ns);
  times_.add(flight.cost, flight.images, took_ns);
  add_turn_time(flight.requester, begin_ns, end_ns);
}

void ImageScheduler::spent(RequesterId requester, int64_t begin_ns, int64_t end_ns) {
  const auto known = accounts_.find(requester);
  if (known == accounts_.end() || end_ns <= begin_ns) return;
  known->second.start += static_cast<double>(end_ns - begin_ns);
  known->second.finish += static_cast<double>(end_ns - begin_ns);
  add_turn_time(requester, begin_ns, end_ns);
}

// Other requesters get quiet time for the part of the turn that exceeds their period.
void ImageScheduler::add_turn_time(RequesterId requester, int64_t begin_ns, int64_t end_ns) {
  Account& account = accounts_[requester];
  const double turn_before_ns = account.turn_ns;
  account.turn_ns += static_cast<double>(std::max<int64_t>(end_ns - begin_ns, 0));
  for (auto& [other_requester, other] : accounts_) {
    if (other_requester == requester || !is_active(other, begin_ns)) continue;
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

}  // namespace fire3dv::state
