// Metric families in Prometheus' text exposition format (version 0.0.4): the writer, and the families of this
// process and of peer budgets.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/peer_budget.h"

namespace fire3dv::metrics {

// Duration histogram with fixed buckets, in seconds. Memory is constant.
class Histogram {
 public:
  static constexpr std::array<double, 13> kUpperBounds_s = {0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05,
                                                            0.1,    0.25,  0.5,    1,     2.5,  10};
  void add(double seconds);

  uint64_t count() const { return count_; }
  double sum_s() const { return sum_s_; }
  // Number of samples of at most kUpperBounds_s[bound].
  uint64_t count_up_to(size_t bound) const;

 private:
  std::array<uint64_t, kUpperBounds_s.size() + 1> buckets_{};
  uint64_t count_ = 0;
  double sum_s_ = 0;
};

// Page of metric families with labelled samples. Untrusted text appears in label values only and is escaped.
class Exposition {
 public:
  using Label = std::pair<std::string_view, std::string_view>;
  using Labels = std::span<const Label>;

  // Begins a metric family; its samples follow. type: counter, gauge, histogram or summary.
  void family(std::string_view name, std::string_view type, std::string_view help);
  void sample(std::initializer_list<Label> labels, double value);
  void sample(std::initializer_list<Label> labels, uint64_t value);
  void histogram(std::initializer_list<Label> labels, const Histogram& histogram);
  // Summary without quantiles.
  void summary(std::initializer_list<Label> labels, uint64_t count, double sum);

  const std::string& text() const { return text_; }

 private:
  void line(std::string_view suffix, Labels labels, const Label* more, std::string_view value);

  std::string family_;
  std::string text_;
};

// Resident set size in bytes; 0 if unknown.
uint64_t resident_bytes();

// Process metrics (memory, CPU time, descriptors) with the family names of Prometheus client libraries.
void write_process_use(Exposition& exposition);

// Peers with the least use beyond this number are counted, not listed.
constexpr size_t kMaxListedPeers = 64;

struct PeerUse {
  std::string peer;    // name; made unique and printable by write_peer_use()
  std::string stream;  // stream number as in other families; empty: none
  std::array<uint64_t, kResourceCount> used{}, refused{};
};

// Metrics of peer budgets: use, limits and refusals by peer and resource. The number of listed peers is
// bounded.
void write_peer_use(Exposition& page, const PeerLimits& limits, std::vector<PeerUse> peers);

}  // namespace fire3dv::metrics
