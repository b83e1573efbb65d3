#include "renderer/browser/live_plots.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/text.h"
#include "renderer/browser/json_text.h"

namespace fire3dv::app {
namespace {

using Json = nlohmann::json;

constexpr size_t kMaxPlotNameBytes = 100, kMaxUnitBytes = 20;
constexpr auto kPeriod = std::chrono::milliseconds(100);
constexpr auto kFullPeriod = std::chrono::milliseconds(50), kListPeriod = std::chrono::milliseconds(250);
constexpr auto kFast = std::chrono::milliseconds(80), kSlow = std::chrono::milliseconds(200);

const stream::ScalarGroup* find_group(const state::PoseState& poses, const ScalarList::Entry& entry) {
  const auto& streams = poses.streams();
  const auto known = std::ranges::find_if(
      streams, [&](const state::Stream& stream) { return stream.active && stream.epoch == entry.epoch; });
  if (known == streams.end()) return nullptr;
  const auto& groups = known->scalars().groups();
  const auto group = groups.find(entry.group);
  return group == groups.end() || entry.scalar >= group->second.statistics().size() ? nullptr
                                                                                    : &group->second;
}

bool is_same(double a, double b) {
  return a == b || (!std::isfinite(a) && !std::isfinite(b));
}

// Also for times of opposite ends of the range.
int64_t difference(int64_t a, int64_t b) {
  return static_cast<int64_t>(static_cast<uint64_t>(a) - static_cast<uint64_t>(b));
}

}  // namespace

size_t ScalarList::count(const state::PoseState& poses) {
  size_t count = 0;
  for (const state::Stream& stream : poses.streams()) {
    if (!stream.active) continue;
    for (const auto& [name, group] : stream.scalars().groups()) count += group.statistics().size();
  }
  return count;
}

bool ScalarList::update(const state::PoseState& poses) {
  std::vector<Entry> entries;
  size_t omitted = 0;
  for (const state::Stream& stream : poses.streams()) {
    if (!stream.active) continue;
    for (const auto& [name, group] : stream.scalars().groups()) {
      const size_t room = kMaxListedScalars - entries.size();
      const size_t listed = std::min(room, group.statistics().size());
      for (size_t i = 0; i < listed; ++i)
        entries.push_back(
            {stream.epoch, stream.name, name, group.declared().names[i], group.declared().units[i], i});
      omitted += group.statistics().size() - listed;
    }
  }
  if (number_ != 0 && entries == entries_ && omitted == omitted_) return false;
  entries_ = std::move(entries);
  omitted_ = omitted;
  ++number_;
  Json scalars = Json::array();
  for (const Entry& entry : entries_)
    scalars.push_back(
        {printable_text(entry.stream, kMaxPlotNameBytes), printable_text(entry.group, kMaxPlotNameBytes),
         printable_text(entry.name, kMaxPlotNameBytes), printable_text(entry.unit, kMaxUnitBytes)});
  const Json message = {
      {"type", "scalars"}, {"list", number_}, {"scalars", std::move(scalars)}, {"omitted", omitted_}};
  message_ = text_of(message);
  return true;
}

void PlotFeed::close() {
  is_open_ = false;
  curves_.clear();
}

void PlotFeed::open(const ScalarList& now, uint32_t list, std::span<const uint32_t> plotted) {
  is_open_ = true;
  list_ = list;
  curves_.clear();
  base_ns_.reset();
  in_flight_ = is_full_ = false;
  if (list_ != now.number()) return;
  for (const uint32_t index : plotted)
    if (index < now.entries().size()) curves_.push_back({index, now.entries()[index], {}, 0, 0});
}

bool PlotFeed::take_list(const ScalarList& now, Clock::time_point at) {
  if (!is_open_ || list_ == now.number() || at - listed_ < kListPeriod) return false;
  listed_ = at;
  list_ = now.number();
  curves_.clear();  // the page chooses again, by name
  return true;
}

// Larger messages for a page that is quick, smaller ones for one that is not.
void PlotFeed::on_plotted(uint32_t number, Clock::time_point now) {
  if (!in_flight_ || number != number_) return;
  in_flight_ = false;
  if (is_full_ && now - sent_ < kFast) samples_ = std::min(2 * samples_, kMaxSamples);
  if (now - sent_ > kSlow) samples_ = std::max(samples_ / 2, kMinSamples);
}

std::optional<std::string> PlotFeed::take_samples(const state::PoseState& poses, Clock::time_point now) {
  if (!is_open_ || in_flight_ || curves_.empty()) return std::nullopt;
  if (now - sent_ < (is_full_ ? kFullPeriod : kPeriod)) return std::nullopt;
  const size_t room = samples_ / curves_.size();
  bool is_full = false;
  Json curves = Json::array();
  for (Curve& curve : curves_) {
    const stream::ScalarGroup* const group = find_group(poses, curve.of);
    if (!group || group->size() == 0) continue;
    const uint64_t finite_values = group->statistics()[curve.of.scalar].count;
    const bool restarts = !curve.sent_ns || group->sim_time_ns(group->size() - 1) < *curve.sent_ns ||
                          finite_values < curve.finite_values;
    if (restarts) curve.sent_ns.reset();
    size_t sample = curve.sent_ns ? group->find(*curve.sent_ns) : 0;
    // The newest sample may have another value by now.
    if (curve.sent_ns && sample < group->size() && group->sim_time_ns(sample) == *curve.sent_ns &&
        is_same(group->value(sample, curve.of.scalar), curve.sent_value))
      ++sample;
    const size_t end = sample + std::min(room, group->size() - sample);
    is_full |= end < group->size();
    if (sample == end) continue;
    if (!base_ns_) base_ns_ = group->sim_time_ns(sample);
    Json times = Json::array(), values = Json::array();
    for (; sample < end; ++sample) {
      const double value = group->value(sample, curve.of.scalar);
      times.push_back(difference(group->sim_time_ns(sample), *base_ns_));
      values.push_back(std::isfinite(value) ? Json(value) : Json());
    }
    curve.sent_ns = group->sim_time_ns(end - 1);
    curve.sent_value = group->value(end - 1, curve.of.scalar);
    curve.finite_values = finite_values;
    curves.push_back({{"scalar", curve.index},
                      {"restarts", restarts},
                      {"t_ns", std::move(times)},
                      {"values", std::move(values)}});
  }
  is_full_ = is_full;
  if (curves.empty()) return std::nullopt;
  sent_ = now;
  in_flight_ = true;
  const Json message = {{"type", "samples"},
                        {"number", ++number_},
                        {"list", list_},
                        {"base_ns", std::to_string(*base_ns_)},
                        {"curves", std::move(curves)}};
  return message.dump();
}

}  // namespace fire3dv::app
