// Resource budget of one peer, and the pool that all peers share. Whatever a peer makes the renderer hold is
// charged here before it is allocated; a refusal names the limit, the use and the option that changes it. A
// peer within its reserved amounts is never refused because of the others. All functions may be called from
// any thread.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "protocol/base/peer_limits.h"
#include "protocol/error.h"

namespace fire3dv {

class PeerBudget;

// Budgets of all peers of a program. Owned by shared_ptr; every PeerBudget keeps its pool alive.
class BudgetPool : public std::enable_shared_from_this<BudgetPool> {
 public:
  static std::shared_ptr<BudgetPool> create(const PeerLimits& limits = {});

  // The budget of a peer that has connected. `name` is shown in metrics and panels.
  std::shared_ptr<PeerBudget> add_peer(std::string name);

  const PeerLimits& limits() const { return limits_; }
  uint64_t used(Resource resource) const;  // by all peers that exist

  // A copy of one peer's numbers.
  struct Report {
    std::string name;
    std::array<uint64_t, kResourceCount> used{}, refused{};
  };
  std::vector<Report> report() const;

 private:
  friend class PeerBudget;
  explicit BudgetPool(const PeerLimits& limits) : limits_(limits) {}

  const PeerLimits limits_;
  mutable std::mutex mutex_;
  std::array<uint64_t, kResourceCount> used_{};         // by all peers
  std::array<uint64_t, kResourceCount> shared_used_{};  // of that, beyond peers' reserved amounts
  std::vector<PeerBudget*> peers_;
};

class PeerBudget {
 public:
  ~PeerBudget();
  PeerBudget(const PeerBudget&) = delete;
  PeerBudget& operator=(const PeerBudget&) = delete;

  // Charges `amount` more, or charges nothing and says why not.
  Result<void> take(Resource resource, uint64_t amount);
  // As take(), without the cost of a sentence.
  bool try_take(Resource resource, uint64_t amount);
  // Gives back part of what was taken.
  void give_back(Resource resource, uint64_t amount);

  uint64_t used(Resource resource) const;
  uint64_t limit(Resource resource) const { return pool_->limits_.of(resource); }
  uint64_t refused(Resource resource) const;  // how often
  const PeerLimits& limits() const { return pool_->limits_; }

  std::string name() const;
  void set_name(std::string name);  // once the peer has described itself

  // Time that threads which serve all peers have spent for this one; who has spent least goes next.
  void add_render_ns(int64_t ns) { render_ns_.fetch_add(ns, std::memory_order_relaxed); }
  void add_build_ns(int64_t ns) { build_ns_.fetch_add(ns, std::memory_order_relaxed); }
  int64_t render_ns() const { return render_ns_.load(std::memory_order_relaxed); }
  int64_t build_ns() const { return build_ns_.load(std::memory_order_relaxed); }

 private:
  friend class BudgetPool;
  PeerBudget(std::shared_ptr<BudgetPool> pool, std::string name);

  const std::shared_ptr<BudgetPool> pool_;
  std::string name_;  // under the pool's mutex, as the next two
  std::array<uint64_t, kResourceCount> used_{}, refused_{};
  std::atomic<int64_t> render_ns_{0}, build_ns_{0};
};

// Amount charged to a budget for as long as this lives. Movable; empty by default.
class BudgetCharge {
 public:
  BudgetCharge() = default;
  // A null budget charges nobody and always succeeds: for readers without limits, such as offline tools.
  static Result<BudgetCharge> take(std::shared_ptr<PeerBudget> budget, Resource resource, uint64_t amount);

  BudgetCharge(BudgetCharge&& other) noexcept;
  BudgetCharge& operator=(BudgetCharge&& other) noexcept;
  ~BudgetCharge() { release(); }

  // Changes the amount. On an error the old amount stays charged.
  Result<void> resize(uint64_t amount);
  void release();
  uint64_t amount() const { return amount_; }

 private:
  std::shared_ptr<PeerBudget> budget_;
  Resource resource_ = Resource::received_bytes;
  uint64_t amount_ = 0;
};

}  // namespace fire3dv
