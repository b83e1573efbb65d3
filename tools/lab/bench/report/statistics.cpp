#include "tools/lab/bench/report/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace fire3dv::bench {
namespace {

double at_fraction(const std::vector<double>& sorted, double fraction) {
  const double rank = fraction * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<size_t>(rank);
  const size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], rank - static_cast<double>(below));
}

}  // namespace

Summary summarise(std::vector<double> values) {
  Summary summary;
  summary.count = values.size();
  if (values.empty()) return summary;
  std::sort(values.begin(), values.end());
  const auto count = static_cast<double>(values.size());
  summary.median = at_fraction(values, 0.5);
  summary.p10 = at_fraction(values, 0.1);
  summary.p90 = at_fraction(values, 0.9);
  summary.p95 = at_fraction(values, 0.95);
  summary.p99 = at_fraction(values, 0.99);
  summary.p999 = at_fraction(values, 0.999);
  summary.mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
  double squares = 0;
  for (const double value : values) squares += (value - summary.mean) * (value - summary.mean);
  if (values.size() > 1) summary.deviation = std::sqrt(squares / (count - 1));
  summary.least = values.front();
  summary.most = values.back();
  return summary;
}

}  // namespace fire3dv::bench
