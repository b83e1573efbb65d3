// Summary statistics of repeated measurements.
#pragma once

#include <cstddef>
#include <vector>

namespace fire3dv::bench {

struct Summary {
  size_t count = 0;
  double median = 0, p10 = 0, p90 = 0, p95 = 0, p99 = 0, p999 = 0;
  double mean = 0, deviation = 0, least = 0, most = 0;  // deviation: sample standard deviation
};

// Quantiles interpolate between samples. Without samples the count is 0.
Summary summarise(std::vector<double> values);

}  // namespace fire3dv::bench
