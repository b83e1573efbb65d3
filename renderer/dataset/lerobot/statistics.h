// Statistics of a column or a video that policies normalise their inputs by (meta/stats.json of LeRobot).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace fire3dv::dataset {

constexpr std::array kStatisticNames{"min", "max", "mean", "std", "q01", "q10", "q50", "q90", "q99"};

struct FeatureStatistics {
  // One for each component, by kStatisticNames. The standard deviation is that of the population; quantiles
  // are interpolated linearly, as by numpy.quantile.
  std::array<std::vector<double>, kStatisticNames.size()> values;
  uint64_t count = 0;  // of rows or images
};

// values: row after row; at least one row.
FeatureStatistics statistics_of(std::span<const double> values, size_t components);

// Counts of the pixels' values, of each component.
class PixelCounts {
 public:
  PixelCounts(size_t components, size_t values) : values_(values), counts_(components * values) {}

  void add(size_t component, size_t value) { ++counts_[component * values_ + value]; }
  // value_of: rises. At least one pixel was added to each component.
  FeatureStatistics statistics(const std::function<double(size_t)>& value_of, uint64_t images) const;

 private:
  size_t values_;
  std::vector<uint64_t> counts_;
};

}  // namespace fire3dv::dataset
