// History of the scalars of one stream: for each group a ring of samples by simulation time, and statistics
// of its scalars. Memory is bounded and charged to the peer's budget for edits. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/peer_budget.h"
#include "protocol/wire/scene_edit.h"

namespace fire3dv::stream {

// Of the values since the group's history began. Values that are not finite do not count.
struct ScalarStatistics {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  uint64_t count = 0;
  double min = kNone, max = kNone, last = kNone;  // NaN: no value yet
};

// Samples of one group, oldest first. Simulation times rise strictly.
class ScalarGroup {
 public:
  const wire::Scalars& declared() const { return declared_; }
  const std::vector<ScalarStatistics>& statistics() const { return statistics_; }  // by scalar

  size_t size() const { return size_; }
  int64_t sim_time_ns(size_t sample) const { return times_[slot(sample)]; }
  double value(size_t sample, size_t scalar) const {  // not finite: no value
    return values_[slot(sample) * statistics_.size() + scalar];
  }
  // First sample of this time or a later one; size() if there is none.
  size_t find(int64_t sim_time_ns) const;

 private:
  friend class ScalarHistory;
  size_t slot(size_t sample) const { return (begin_ + sample) % times_.size(); }
  void clear();
  void resize(size_t samples);

  uint64_t declaration_ = 0;
  wire::Scalars declared_;
  std::vector<ScalarStatistics> statistics_;
  std::vector<int64_t> times_;
  std::vector<double> values_;  // times_.size() rows
  size_t begin_ = 0, size_ = 0;
  std::optional<int64_t> newest_ns_;
  bool is_growing_ = true;  // false: memory has ended
  BudgetCharge declaration_charge_, sample_charge_;
};

class ScalarHistory {
 public:
  static constexpr size_t kMaxSamples = 10'000;           // of a group
  static constexpr uint64_t kMaxSampleBytes = 32u << 20;  // of a stream

  enum class Keep { samples, statistics };

  ScalarHistory() = default;
  // budget null: no limits but those above. statistics: groups have no samples.
  explicit ScalarHistory(std::shared_ptr<PeerBudget> budget, Keep keep = Keep::samples)
      : budget_(std::move(budget)), keep_(keep) {}

  enum class Outcome {
    accepted,
    unmatched,  // values without a matching declaration
    refused,    // over a limit; refusal() says which
  };
  // Applies an edit of a scalar property. When memory for samples ends, new samples replace the oldest ones
  // earlier. Values of a time before the newest sample restart the group's history; values of its time
  // replace it.
  Outcome apply(const wire::SceneEdit& edit);

  const std::string& refusal() const { return refusal_; }
  const std::map<std::string, ScalarGroup>& groups() const { return groups_; }
  uint64_t revision() const { return revision_; }  // incremented by each change

 private:
  Outcome declare(const wire::SceneEdit& edit, const wire::Scalars& scalars);
  Outcome add(ScalarGroup& group, const wire::ScalarValues& values);
  bool grow(ScalarGroup& group);
  void push(ScalarGroup& group, const wire::ScalarValues& values);
  void drop_samples(ScalarGroup& group);
  Outcome refuse(std::string message);

  std::shared_ptr<PeerBudget> budget_;
  Keep keep_ = Keep::samples;
  std::map<std::string, ScalarGroup> groups_;
  size_t scalars_ = 0;         // of all groups
  uint64_t sample_bytes_ = 0;  // of all groups
  uint64_t revision_ = 0;
  std::string refusal_;
};

}  // namespace fire3dv::stream
