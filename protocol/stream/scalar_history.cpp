#include "protocol/stream/scalar_history.h"

#include <algorithm>
#include <cmath>

namespace fire3dv::stream {
namespace {

constexpr size_t kFirstSamples = 64;
constexpr uint64_t kBytesPerScalar = 128, kBytesPerGroup = 512;  // overhead of containers

uint64_t row_bytes(size_t scalars) {
  return sizeof(int64_t) + scalars * sizeof(double);
}

uint64_t declaration_bytes(const std::string& name, const wire::Scalars& scalars) {
  uint64_t bytes = kBytesPerGroup + name.size();
  for (size_t i = 0; i < scalars.names.size(); ++i)
    bytes += kBytesPerScalar + sizeof(ScalarStatistics) + scalars.names[i].size() + scalars.units[i].size();
  return bytes;
}

}  // namespace

size_t ScalarGroup::find(int64_t sim_time_ns) const {
  size_t low = 0, high = size_;
  while (low < high) {
    const size_t middle = (low + high) / 2;
    if (this->sim_time_ns(middle) < sim_time_ns)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

void ScalarGroup::clear() {
  begin_ = size_ = 0;
  std::ranges::fill(statistics_, ScalarStatistics{});
}

// Moves the samples to the begin of larger rings.
void ScalarGroup::resize(size_t samples) {
  const size_t scalars = statistics_.size();
  std::vector<int64_t> times(samples);
  std::vector<double> values(samples * scalars);
  for (size_t i = 0; i < size_; ++i) {
    times[i] = times_[slot(i)];
    const auto row = values_.begin() + static_cast<std::ptrdiff_t>(slot(i) * scalars);
    std::copy_n(row, scalars, values.begin() + static_cast<std::ptrdiff_t>(i * scalars));
  }
  begin_ = 0;
  times_ = std::move(times);
  values_ = std::move(values);
}

ScalarHistory::Outcome ScalarHistory::refuse(std::string message) {
  refusal_ = std::move(message);
  return Outcome::refused;
}

ScalarHistory::Outcome ScalarHistory::apply(const wire::SceneEdit& edit) {
  if (const auto* scalars = std::get_if<wire::Scalars>(&edit.value)) return declare(edit, *scalars);
  const auto group = groups_.find(edit.node);
  if (const auto* values = std::get_if<wire::ScalarValues>(&edit.value))
    return group == groups_.end() ? Outcome::unmatched : add(group->second, *values);
  if (edit.property == wire::Property::scalars && group != groups_.end()) {
    scalars_ -= group->second.statistics_.size();
    drop_samples(group->second);
    groups_.erase(group);
    ++revision_;
  }
  return Outcome::accepted;
}

ScalarHistory::Outcome ScalarHistory::declare(const wire::SceneEdit& edit, const wire::Scalars& scalars) {
  const auto known = groups_.find(edit.node);
  if (known != groups_.end() && known->second.declared_ == scalars) {  // repeated: the history stays
    known->second.declaration_ = edit.version;
    return Outcome::accepted;
  }
  // A refused declaration ends the old one, whose values do not come any more.
  if (known != groups_.end()) {
    scalars_ -= known->second.statistics_.size();
    drop_samples(known->second);
    groups_.erase(known);
  }
  ++revision_;
  if (scalars_ + scalars.names.size() > wire::kMaxScalars)
    return refuse("a stream has at most " + std::to_string(wire::kMaxScalars) + " scalars; the group has " +
                  std::to_string(scalars.names.size()) + ", and other groups have " +
                  std::to_string(scalars_));
  Result<BudgetCharge> charge =
      BudgetCharge::take(budget_, Resource::edit_bytes, declaration_bytes(edit.node, scalars));
  if (!charge) return refuse(charge.error().message);
  Result<BudgetCharge> samples = BudgetCharge::take(budget_, Resource::edit_bytes, 0);
  if (!samples) return refuse(samples.error().message);
  ScalarGroup& group = groups_[edit.node];
  group.declaration_ = edit.version;
  group.declared_ = scalars;
  group.statistics_.resize(scalars.names.size());
  group.declaration_charge_ = std::move(*charge);
  group.sample_charge_ = std::move(*samples);
  scalars_ += scalars.names.size();
  return Outcome::accepted;
}

void ScalarHistory::drop_samples(ScalarGroup& group) {
  sample_bytes_ -= group.times_.size() * row_bytes(group.statistics_.size());
  group.times_ = {};
  group.values_ = {};
  group.clear();
  group.sample_charge_.release();
}

// Returns false if the ring is as large as it may be.
bool ScalarHistory::grow(ScalarGroup& group) {
  const size_t old_samples = group.times_.size();
  const size_t samples = std::min(kMaxSamples, old_samples == 0 ? kFirstSamples : 2 * old_samples);
  const uint64_t row = row_bytes(group.statistics_.size());
  const uint64_t more = (samples - old_samples) * row;
  if (!group.is_growing_ || more == 0) return false;
  // Asked once: a refusal is counted by the budget.
  group.is_growing_ =
      sample_bytes_ + more <= kMaxSampleBytes && group.sample_charge_.resize(samples * row).ok();
  if (!group.is_growing_) return false;
  group.resize(samples);
  sample_bytes_ += more;
  return true;
}

void ScalarHistory::push(ScalarGroup& group, const wire::ScalarValues& values) {
  if (group.size_ == 0 || group.sim_time_ns(group.size_ - 1) != values.sim_time_ns) {
    if (group.size_ == group.times_.size() && !grow(group)) {
      if (group.size_ == 0) return;
      group.begin_ = (group.begin_ + 1) % group.times_.size();
      --group.size_;
    }
    ++group.size_;
  }
  const size_t slot = group.slot(group.size_ - 1);
  group.times_[slot] = values.sim_time_ns;
  std::ranges::copy(values.values,
                    group.values_.begin() + static_cast<std::ptrdiff_t>(slot * values.values.size()));
}

ScalarHistory::Outcome ScalarHistory::add(ScalarGroup& group, const wire::ScalarValues& values) {
  const size_t scalars = group.statistics_.size();
  if (values.declaration != group.declaration_ || values.values.size() != scalars) return Outcome::unmatched;
  ++revision_;
  if (group.newest_ns_ && values.sim_time_ns < *group.newest_ns_) group.clear();
  group.newest_ns_ = values.sim_time_ns;
  if (keep_ == Keep::samples) push(group, values);
  for (size_t i = 0; i < scalars; ++i) {
    const double value = values.values[i];
    if (!std::isfinite(value)) continue;
    ScalarStatistics& statistics = group.statistics_[i];
    statistics.min = statistics.count == 0 ? value : std::min(statistics.min, value);
    statistics.max = statistics.count == 0 ? value : std::max(statistics.max, value);
    statistics.last = value;
    ++statistics.count;
  }
  if (keep_ == Keep::samples && group.size_ == 0)
    return refuse("there is no memory for samples of scalars: a stream may use " +
                  amount_text(Resource::edit_bytes, kMaxSampleBytes) +
                  " for them, and they count against edit-bytes of its peer");
  return Outcome::accepted;
}

}  // namespace fire3dv::stream
