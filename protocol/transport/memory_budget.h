// Memory that strangers may make this process hold, all of them together. Any thread.
#pragma once

#include <atomic>
#include <cstddef>
#include <utility>
#include <vector>

namespace fire3dv::transport {

class MemoryBudget {
 public:
  explicit MemoryBudget(size_t limit) : limit_(limit) {}
  void raise(size_t limit) { limit_.store(limit, std::memory_order_relaxed); }

  bool take(size_t bytes) {
    if (used_.fetch_add(bytes, std::memory_order_relaxed) + bytes <= limit_.load(std::memory_order_relaxed))
      return true;
    give(bytes);
    return false;
  }
  void give(size_t bytes) { used_.fetch_sub(bytes, std::memory_order_relaxed); }
  size_t used() const { return used_.load(std::memory_order_relaxed); }

 private:
  std::atomic<size_t> limit_;
  std::atomic<size_t> used_{0};
};

// Bytes taken from a budget, which has them back when they end. The budget outlives them.
class BudgetShare {
 public:
  BudgetShare() = default;
  // `budget` was asked for them, and said yes.
  BudgetShare(MemoryBudget& budget, size_t bytes) : budget_(&budget), bytes_(bytes) {}
  BudgetShare(BudgetShare&& other) noexcept
      : budget_(std::exchange(other.budget_, nullptr)), bytes_(other.bytes_) {}
  BudgetShare& operator=(BudgetShare&& other) noexcept {
    std::swap(budget_, other.budget_);
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~BudgetShare() {
    if (budget_ != nullptr) budget_->give(bytes_);
  }

 private:
  MemoryBudget* budget_ = nullptr;
  size_t bytes_ = 0;
};

struct BudgetedBytes {
  std::vector<std::byte> bytes;
  BudgetShare share;
  size_t size() const { return bytes.size(); }
};

}  // namespace fire3dv::transport
