#include "renderer/state/image_scheduler.h"

#include <algorithm>

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

}  // namespace fire3dv::state
