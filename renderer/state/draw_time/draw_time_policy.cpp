#include "renderer/state/draw_time/draw_time_policy.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <utility>

namespace fire3dv::state {
namespace {

constexpr int64_t kMsNs = 1'000'000, kSecondNs = 1'000'000'000;

// Initial costs in ns of lavapipe with two cores, and of a GPU.
struct UnitCosts {
  double vertex, fragment, rebuilt;
};
constexpr UnitCosts kSoftware{10, 5, 500}, kHardware{0.1, 0.05, 20};

// Cost of an image without content of peers that no budget polices: a fixed time, and its pixels.
constexpr double kPlainSoftwareNs = 1.0e6, kPlainSoftwareNsPerPixel = 100;
constexpr double kPlainHardwareNs = 0.5e6, kPlainHardwareNsPerPixel = 2;

constexpr double kRecentNs = 2e9;             // time constant of shares
constexpr double kEstimateSlack = 4;          // errors of estimates that are not measured yet
constexpr double kReturnShare = 0.7;          // of the budget that returning content may take
constexpr uint32_t kImagesOver = 4;           // in a row, before content is hidden ...
constexpr int64_t kTimeOverNs = 400 * kMsNs;  // ... or fewer that take so long
constexpr int64_t kShortestPauseNs = 2 * kSecondNs, kLongestPauseNs = 64 * kSecondNs;
constexpr int64_t kQuietNs = kSecondNs;        // the content has to fit for so long before it returns
constexpr int64_t kMissingNs = 5 * kSecondNs;  // content that no image has for so long is gone
constexpr int64_t kTrialIntervals = 16;        // intervals after which it returns as a trial
constexpr double kReportedShare = 0.6, kForgottenShare = 0.3;
constexpr double kMaxBuildNs = 0.5e9;      // of acceleration structures of new content
constexpr double kMinAbandonedNs = 0.5e9;  // of images: shorter ones are drawn to their end
constexpr size_t kMaxKinds = 256;
constexpr int64_t kOldKindNs = 60 * kSecondNs;
constexpr double kMaxScale = 50;
constexpr double kMaxMeasuredRatio = 8;  // of measured to expected time of meshes: the rest is noise

constexpr const char* kHiddenWhile = "; it is hidden while other simulators are connected";
constexpr const char* kRemedy =
    "send fewer or smaller elements and triangles, or start the renderer with --peer-limit draw-time=off";

std::string milliseconds_text(double ns) {
  char text[32];
  std::snprintf(text, sizeof text, ns < 10e6 ? "%.1f ms" : "%.0f ms", ns * 1e-6);
  return text;
}

std::string expected_text(double ns, double without_ns) {
  return "its content would take about " + milliseconds_text(ns) + " of an image that takes " +
         milliseconds_text(without_ns) + " without it" + kHiddenWhile;
}

std::string percent_text(double share) {
  return std::to_string(std::lround(100 * std::min(share, 1.0))) + " %";
}

double average_scale(double scale, double ratio) {
  return std::clamp(scale * std::pow(ratio / scale, 0.2), 1 / kMaxScale, kMaxScale);
}

}  // namespace

Result<double> parse_draw_time_factor(std::string_view text) {
  if (text == "off") return 0.0;
  double factor = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), factor);
  if (fault != std::errc() || end != text.data() + text.size() || !(factor >= 1) || !(factor <= 1000))
    return Error{"draw-time: \"" + std::string(text) + "\" is neither a factor from 1 to 1000 nor \"off\""};
  return factor;
}

double DrawTimePolicy::ns_of(const DrawWork& work, double scale) const {
  const UnitCosts& costs = settings_.is_software ? kSoftware : kHardware;
  return scale * (work.vertices * costs.vertex + work.fragments * costs.fragment) +
         work.rebuilt * costs.rebuilt;
}

double DrawTimePolicy::expected_ns(const Content& content) const {
  return ns_of(content.markers, marker_scale_) + ns_of(content.meshes, mesh_scale_);
}

double DrawTimePolicy::plain_ns(uint64_t pixels) const {
  const auto count = static_cast<double>(pixels);
  return settings_.is_software ? kPlainSoftwareNs + kPlainSoftwareNsPerPixel * count
                               : kPlainHardwareNs + kPlainHardwareNsPerPixel * count;
}

// Time of the image without content of other peers, that of its requester included.
double DrawTimePolicy::base_ns(const Image& image) const {
  const auto kind = kinds_.find(image.kind);
  double own = 0;
  for (const Content& content : image.content)
    if (content.peer == image.requester) own += expected_ns(content);
  const double base = kind == kinds_.end() ? 0 : kind->second.base_ns;
  return std::max(base + own, plain_ns(image.pixels));
}

// Estimates that no image has confirmed may be wrong; content within this limit is drawn and measured.
double DrawTimePolicy::limit_ns(const Image& image) const {
  return kEstimateSlack * settings_.factor * base_ns(image) + 25 * plain_ns(0);
}

bool DrawTimePolicy::set_peers(std::span<const Peer> peers) {
  bool is_changed = false;
  const bool was_active = is_active();
  for (auto& [peer, account] : accounts_) account.is_seen = false;
  for (const Peer peer : peers) accounts_[peer].is_seen = true;
  std::erase_if(accounts_, [&](const auto& entry) {
    const Account& account = entry.second;
    if (account.is_seen) return false;
    if (account.is_hidden) {
      --hidden_count_;
      ++revision_;
      is_changed = true;
    }
    return true;
  });
  if (is_active() || !was_active) return is_changed;
  for (auto& [peer, account] : accounts_) {
    if (account.is_hidden) {
      show(account, peer, "no other simulator is connected");
      is_changed = true;
    }
    account = Account{.seconds = account.seconds};
  }
  kinds_.clear();
  recent_total_ns_ = 0;
  return is_changed;
}

void DrawTimePolicy::hide(Account& account, Peer peer, const std::string& why, int64_t now_ns) {
  const bool is_again = account.shown_ns && now_ns - *account.shown_ns < 4 * account.interval_ns;
  account.interval_ns = is_again ? std::min(2 * account.interval_ns, kLongestPauseNs) : kShortestPauseNs;
  account.is_hidden = true;
  account.hidden_ns = account.unfit_ns = account.content_ns = now_ns;
  account.over_count = 0;
  account.over_ns = 0;
  ++hidden_count_;
  ++revision_;
  notices_.push_back({peer, Notice::Kind::hidden, why + "; " + kRemedy});
}

void DrawTimePolicy::show(Account& account, Peer peer, const std::string& why) {
  account.is_hidden = false;
  --hidden_count_;
  ++revision_;
  notices_.push_back({peer, Notice::Kind::shown, why});
}

bool DrawTimePolicy::plan(const Image& image, int64_t now_ns) {
  if (!is_active() || settings_.factor == 0) return false;
  const double base = base_ns(image);
  const double allowed = (settings_.factor - 1) * base;
  const double limit = limit_ns(image);
  double shown = 0;
  std::vector<std::pair<double, Peer>> foreign;
  for (const Content& content : image.content) {
    const auto known = accounts_.find(content.peer);
    if (known == accounts_.end()) continue;
    Account& account = known->second;
    account.expected_ns = expected_ns(content) * account.correction;
    account.content_ns = now_ns;
    if (content.peer == image.requester || account.is_hidden) continue;
    shown += account.expected_ns;
    foreign.emplace_back(account.expected_ns, content.peer);
  }
  bool is_changed = false;
  std::sort(foreign.rbegin(), foreign.rend());
  for (const auto& [expected, peer] : foreign) {
    if (shown <= limit || expected < allowed / 2) break;
    hide(accounts_.at(peer), peer, expected_text(expected, base), now_ns);
    shown -= expected;
    is_changed = true;
  }
  for (auto& [peer, account] : accounts_) {
    if (!account.is_hidden || now_ns - account.content_ns < kMissingNs) continue;
    account.correction = 1;
    account.shown_ns = now_ns;
    show(account, peer, "nothing of it is left");
    is_changed = true;
  }
  for (const Content& content : image.content) {
    const auto known = accounts_.find(content.peer);
    if (known == accounts_.end() || !known->second.is_hidden || content.peer == image.requester) continue;
    Account& account = known->second;
    const bool fits = shown + account.expected_ns <= kReturnShare * allowed;
    if (!fits) account.unfit_ns = now_ns;
    const int64_t hidden_ns = now_ns - account.hidden_ns;
    const bool returns = fits && hidden_ns >= account.interval_ns && now_ns - account.unfit_ns >= kQuietNs;
    // A wrong measurement must not hide content for good.
    const bool is_tried =
        hidden_ns >= kTrialIntervals * account.interval_ns && shown + expected_ns(content) <= limit;
    if (!returns && !is_tried) continue;
    account.correction = 1;
    account.shown_ns = now_ns;
    shown += account.expected_ns;
    show(account, content.peer, returns ? "its content takes little drawing time now" : "as a trial");
    is_changed = true;
  }
  return is_changed;
}

// Divides the measured time among the visible content, and calibrates the estimates.
std::vector<DrawTimePolicy::Cost> DrawTimePolicy::costs_of(const Image& image, const Measured& measured,
                                                           int64_t now_ns) {
  double markers = 0, meshes = 0;  // as expected
  for (const Content& content : image.content) {
    markers += ns_of(content.markers, marker_scale_);
    meshes += ns_of(content.meshes, mesh_scale_);
  }
  const auto markers_ns = static_cast<double>(measured.markers_ns);
  const double rest_ns = static_cast<double>(measured.total_ns) - markers_ns;
  const double plain = plain_ns(image.pixels);
  Kind& kind = kinds_[image.kind];
  kind.seen_ns = now_ns;
  if (meshes < 0.01 * plain)
    kind.base_ns = kind.base_ns == 0 || rest_ns < kind.base_ns
                       ? rest_ns
                       : kind.base_ns + 0.02 * (rest_ns - kind.base_ns);
  double meshes_ns = 0;
  if (meshes > 0)
    meshes_ns = kind.base_ns > 0 ? std::clamp(rest_ns - kind.base_ns, 0.0, kMaxMeasuredRatio * meshes)
                                 : rest_ns * meshes / (meshes + plain);
  std::vector<Cost> costs;
  for (const Content& content : image.content) {
    if (!accounts_.contains(content.peer)) continue;
    Cost cost{content.peer, 0};
    if (markers > 0) cost.ns += markers_ns * ns_of(content.markers, marker_scale_) / markers;
    if (meshes > 0) cost.ns += meshes_ns * ns_of(content.meshes, mesh_scale_) / meshes;
    costs.push_back(cost);
  }
  constexpr double kLeastCalibratedNs = 0.2e6;
  if (markers > kLeastCalibratedNs && markers_ns > 0)
    marker_scale_ = average_scale(marker_scale_, marker_scale_ * markers_ns / markers);
  if (meshes > kLeastCalibratedNs && kind.base_ns > 0 && meshes_ns > 0)
    mesh_scale_ = average_scale(mesh_scale_, mesh_scale_ * meshes_ns / meshes);
  return costs;
}

void DrawTimePolicy::note_share(Peer peer, Account& account, const Cost& cost, const Measured& measured) {
  const double share = recent_total_ns_ > 0 ? account.recent_ns / recent_total_ns_ : 0;
  if (share < kForgottenShare) account.is_reported = false;
  if (share < kReportedShare || account.is_reported || account.is_hidden) return;
  account.is_reported = true;
  notices_.push_back({peer, Notice::Kind::expensive,
                      "takes " + percent_text(share) + " of drawing time: " + milliseconds_text(cost.ns) +
                          " of an image of " + milliseconds_text(static_cast<double>(measured.total_ns))});
}

bool DrawTimePolicy::add(const Image& image, const Measured& measured, int64_t now_ns) {
  if (!is_active() || measured.total_ns <= 0) return false;
  drop_old_kinds(now_ns);
  std::vector<Cost> costs = costs_of(image, measured, now_ns);
  const double decay =
      std::exp(-static_cast<double>(now_ns - std::exchange(recent_at_ns_, now_ns)) / kRecentNs);
  recent_total_ns_ = decay * recent_total_ns_ + static_cast<double>(measured.total_ns);
  for (auto& [peer, account] : accounts_) account.recent_ns *= decay;
  double foreign = 0;
  for (const Cost& cost : costs) {
    Account& account = accounts_.at(cost.peer);
    account.seconds += cost.ns * 1e-9;
    account.recent_ns += cost.ns;
    if (cost.peer != image.requester) foreign += cost.ns;
  }
  const double plain = plain_ns(image.pixels);
  const auto total = static_cast<double>(measured.total_ns);
  const double without = std::max(total - foreign, plain);
  const bool is_over = settings_.factor > 0 && foreign > (settings_.factor - 1) * without;
  bool is_changed = false;
  std::ranges::sort(costs, [](const Cost& a, const Cost& b) { return a.ns > b.ns; });
  bool is_first = true;
  for (const Cost& cost : costs) {
    Account& account = accounts_.at(cost.peer);
    if (cost.peer == image.requester || account.is_hidden) continue;
    // Costliest first: others are judged without it.
    if (!is_over || !is_first) {
      if (!is_over) account.over_count = 0, account.over_ns = 0;
      continue;
    }
    is_first = false;
    ++account.over_count;
    account.over_ns += measured.total_ns;
    if (account.over_count < kImagesOver && account.over_ns < kTimeOverNs) continue;
    for (const Content& content : image.content) {
      const double expected = content.peer == cost.peer ? expected_ns(content) : 0;
      if (expected > 0) account.correction = std::clamp(cost.ns / expected, 0.1, 10.0);
    }
    hide(account, cost.peer,
         "its content takes " + percent_text(cost.ns / total) + " of drawing time, " +
             milliseconds_text(cost.ns) + " of an image of " + milliseconds_text(total) +
             "; it is hidden while other simulators are connected",
         now_ns);
    is_changed = true;
  }
  for (const Cost& cost : costs) note_share(cost.peer, accounts_.at(cost.peer), cost, measured);
  return is_changed;
}

bool DrawTimePolicy::add_abandoned(const Image& image, int64_t elapsed_ns, int64_t now_ns) {
  if (!is_active() || settings_.factor == 0) return false;
  const Content* costliest = nullptr;
  for (const Content& content : image.content) {
    if (content.peer == image.requester || is_hidden(content.peer) || !accounts_.contains(content.peer))
      continue;
    if (!costliest || expected_ns(content) > expected_ns(*costliest)) costliest = &content;
  }
  if (!costliest) return false;
  Account& account = accounts_.at(costliest->peer);
  const double expected = expected_ns(*costliest);
  if (expected > 0) account.correction = std::clamp(static_cast<double>(elapsed_ns) / expected, 1.0, 1000.0);
  account.seconds += static_cast<double>(elapsed_ns) * 1e-9;
  account.recent_ns += static_cast<double>(elapsed_ns);
  recent_total_ns_ += static_cast<double>(elapsed_ns);
  hide(account, costliest->peer,
       "an image with its content was abandoned after " + milliseconds_text(static_cast<double>(elapsed_ns)) +
           "; it is hidden while other simulators are connected",
       now_ns);
  return true;
}

bool DrawTimePolicy::refuse_meshes(Peer peer, const DrawWork& meshes, std::span<const Image> images,
                                   int64_t now_ns) {
  const auto known = accounts_.find(peer);
  if (!is_active() || settings_.factor == 0 || known == accounts_.end()) return false;
  const double build = ns_of({.rebuilt = meshes.rebuilt}, 1);
  std::string why;
  if (build > kMaxBuildNs)
    why = "the acceleration structures of its " + std::to_string(std::llround(meshes.rebuilt)) +
          " triangles would take about " + milliseconds_text(build) + kHiddenWhile;
  for (const Image& image : images) {
    double drawn = 0;
    for (const Content& content : image.content)
      if (content.peer == peer && peer != image.requester) drawn += ns_of(content.meshes, mesh_scale_);
    if (why.empty() && drawn > limit_ns(image)) why = expected_text(drawn, base_ns(image));
  }
  if (why.empty()) return false;
  if (!known->second.is_hidden) hide(known->second, peer, why, now_ns);
  return true;
}

bool DrawTimePolicy::is_hidden(Peer peer) const {
  if (hidden_count_ == 0) return false;
  const auto known = accounts_.find(peer);
  return known != accounts_.end() && known->second.is_hidden;
}

std::optional<int64_t> DrawTimePolicy::abandon_after_ns(const Image& image) const {
  if (!limits()) return std::nullopt;
  const bool has_content = std::ranges::any_of(image.content, [&](const Content& content) {
    return content.peer != image.requester && !is_hidden(content.peer) && expected_ns(content) > 0;
  });
  if (!has_content) return std::nullopt;
  return static_cast<int64_t>(std::max(2 * limit_ns(image), kMinAbandonedNs));
}

std::vector<DrawTimePolicy::Report> DrawTimePolicy::report() const {
  std::vector<Report> reports;
  for (const auto& [peer, account] : accounts_) {
    const double share = is_active() && recent_total_ns_ > 0 ? account.recent_ns / recent_total_ns_ : 0;
    reports.push_back({peer, account.seconds, std::min(share, 1.0), account.is_hidden});
  }
  return reports;
}

std::vector<DrawTimePolicy::Notice> DrawTimePolicy::take_notices() {
  return std::exchange(notices_, {});
}

void DrawTimePolicy::drop_old_kinds(int64_t now_ns) {
  if (kinds_.size() < kMaxKinds) return;
  std::erase_if(kinds_, [&](const auto& entry) { return now_ns - entry.second.seen_ns > kOldKindNs; });
  if (kinds_.size() < kMaxKinds) return;
  kinds_.erase(std::ranges::min_element(kinds_, {}, [](const auto& entry) { return entry.second.seen_ns; }));
}

}  // namespace fire3dv::state
