// What many measurements of one thing come to.
#pragma once

#include <cstddef>
#include <vector>

namespace fire3dv::bench {

struct Summary {
  size_t count = 0;
  double median = 0, p10 = 0, p90 = 0, p95 = 0, p99 = 0, p999 = 0;
  double mean = 0, deviation = 0, least = 0, most = 0;  // deviation: of the sample
};

// Fractions between two measurements are interpolated. Nothing measured: a count of 0.
Summary summarise(std::vector<double> values);

}  // namespace fire3dv::bench
