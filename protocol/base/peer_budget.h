// Resource budget of one peer, and the pool shared by all peers. Every allocation on behalf of a peer is
// charged here first. A refusal names the limit, the amount in use and the option that changes the limit.
// Other peers never cause a refusal within a peer's reserved amounts. Thread-safe.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/base/peer_limits.h"

namespace fire3dv {

class PeerBudget;

// Budgets of all peers of a process. Owned by shared_ptr; every PeerBudget keeps its pool alive.
class BudgetPool : public std::enable_shared_from_this<BudgetPool> {
 public:
  static std::shared_ptr<BudgetPool> create(const PeerLimits& limits = {});

  // Creates the budget of a newly connected peer. `name` is shown in metrics and panels.
  std::shared_ptr<PeerBudget> add_peer(std::string name);

  const PeerLimits& limits() const { return limits_; }
  uint64_t used(Resource resource) const;  // sum over all live peers

  // Snapshot of one peer's counters.
  struct Report {
    std::string name;
    std::array<uint64_t, kResourceCount> used{}, refused{};
    const PeerBudget* peer = nullptr;  // identity only: the peer may no longer exist
  };
  std::vector<Report> report() const;

 private:
  friend class PeerBudget;
  explicit BudgetPool(const PeerLimits& limits) : limits_(limits) {}

  const PeerLimits limits_;
  mutable std::mutex mutex_;
  std::array<uint64_t, kResourceCount> used_{};  // sum over all peers
  std::array<uint64_t, kResourceCount>
      shared_used_{};  // the part of used_ beyond the peers' reserved amounts
  std::vector<PeerBudget*> peers_;
};

class PeerBudget {
 public:
  ~PeerBudget();
  PeerBudget(const PeerBudget&) = delete;
  PeerBudget& operator=(const PeerBudget&) = delete;

  // Charges `amount`, or charges nothing and returns the reason.
  Result<void> take(Resource resource, uint64_t amount);
  // Same as take() without an error message.
  bool try_take(Resource resource, uint64_t amount);
  // Releases part of the charged amount.
  void give_back(Resource resource, uint64_t amount);

  uint64_t used(Resource resource) const;
  uint64_t limit(Resource resource) const { return pool_->limits_.of(resource); }
  uint64_t refused(Resource resource) const;  // number of refusals
  const PeerLimits& limits() const { return pool_->limits_; }

  std::string name() const;
  void set_name(std::string name);  // called after the peer has sent its description

  // Time that shared threads have spent for this peer. The scheduler serves the peer with the least time
  // first.
  void add_render_ns(int64_t ns) { render_ns_.fetch_add(ns, std::memory_order_relaxed); }
  void add_build_ns(int64_t ns) { build_ns_.fetch_add(ns, std::memory_order_relaxed); }
  int64_t render_ns() const { return render_ns_.load(std::memory_order_relaxed); }
  int64_t build_ns() const { return build_ns_.load(std::memory_order_relaxed); }

 private:
  friend class BudgetPool;
  PeerBudget(std::shared_ptr<BudgetPool> pool, std::string name);

  const std::shared_ptr<BudgetPool> pool_;
  std::string name_;  // guarded by the pool's mutex, like used_ and refused_
  std::array<uint64_t, kResourceCount> used_{}, refused_{};
  std::atomic<int64_t> render_ns_{0}, build_ns_{0};
};

// RAII charge: an amount that stays charged to a budget for the lifetime of this object. Movable; empty by
// default.
class BudgetCharge {
 public:
  BudgetCharge() = default;
  // A null budget always succeeds and charges nothing: for readers without limits, such as offline tools.
  static Result<BudgetCharge> take(std::shared_ptr<PeerBudget> budget, Resource resource, uint64_t amount);

  BudgetCharge(BudgetCharge&& other) noexcept;
  BudgetCharge& operator=(BudgetCharge&& other) noexcept;
  ~BudgetCharge() { release(); }

  // Changes the amount. After an error the old amount stays charged.
  Result<void> resize(uint64_t amount);
  void release();
  uint64_t amount() const { return amount_; }

 private:
  std::shared_ptr<PeerBudget> budget_;
  Resource resource_ = Resource::received_bytes;
  uint64_t amount_ = 0;
};

}  // namespace fire3dv
