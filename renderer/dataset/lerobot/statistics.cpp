#include "renderer/dataset/lerobot/statistics.h"

#include <algorithm>
#include <cmath>

namespace fire3dv::dataset {
namespace {

constexpr std::array kQuantiles{0.01, 0.1, 0.5, 0.9, 0.99};
constexpr size_t kFirstQuantile = 4;
static_assert(kFirstQuantile + kQuantiles.size() == kStatisticNames.size());

// Sorted values with their counts.
struct Counted {
  double value = 0;
  uint64_t count = 0;
};

double value_at(std::span<const Counted> sorted, uint64_t index) {
  for (const Counted& each : sorted) {
    if (index < each.count) return each.value;
    index -= each.count;
  }
  return sorted.back().value;
}

void append(std::span<const Counted> sorted, FeatureStatistics& statistics) {
  double sum = 0, squares = 0;
  uint64_t count = 0;
  for (const Counted& each : sorted) {
    sum += each.value * static_cast<double>(each.count);
    count += each.count;
  }
  const double mean = sum / static_cast<double>(count);
  for (const Counted& each : sorted)
    squares += (each.value - mean) * (each.value - mean) * static_cast<double>(each.count);
  statistics.values[0].push_back(sorted.front().value);
  statistics.values[1].push_back(sorted.back().value);
  statistics.values[2].push_back(mean);
  statistics.values[3].push_back(std::sqrt(squares / static_cast<double>(count)));
  for (size_t i = 0; i < kQuantiles.size(); ++i) {
    const double at = kQuantiles[i] * static_cast<double>(count - 1);
    const auto below = static_cast<uint64_t>(at);
    const double low = value_at(sorted, below), high = value_at(sorted, std::min(below + 1, count - 1));
    statistics.values[kFirstQuantile + i].push_back(low + (high - low) * (at - static_cast<double>(below)));
  }
}

}  // namespace

FeatureStatistics statistics_of(std::span<const double> values, size_t components) {
  FeatureStatistics statistics;
  statistics.count = values.size() / components;
  for (size_t component = 0; component < components; ++component) {
    std::vector<double> own;
    for (size_t i = component; i < values.size(); i += components) own.push_back(values[i]);
    std::sort(own.begin(), own.end());
    std::vector<Counted> sorted;
    for (const double value : own) {
      if (!sorted.empty() && sorted.back().value == value)
        ++sorted.back().count;
      else
        sorted.push_back({value, 1});
    }
    append(sorted, statistics);
  }
  return statistics;
}

FeatureStatistics PixelCounts::statistics(const std::function<double(size_t)>& value_of,
                                          uint64_t images) const {
  FeatureStatistics statistics;
  statistics.count = images;
  for (size_t first = 0; first < counts_.size(); first += values_) {
    std::vector<Counted> sorted;
    for (size_t value = 0; value < values_; ++value) {
      if (counts_[first + value] != 0) sorted.push_back({value_of(value), counts_[first + value]});
    }
    append(sorted, statistics);
  }
  return statistics;
}

}  // namespace fire3dv::dataset
