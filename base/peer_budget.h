// Resource limits of peers, the budget of one peer, and the pool shared by all peers. Every allocation on
// behalf of a peer is charged here first. A refusal names the limit, the amount in use and the option that
// changes the limit. Other peers never cause a refusal within a peer's reserved amounts. Thread-safe.
// Semantics: docs/design/budgets.md; defaults of the limits: protocol/SPEC.md, section 14.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace fire3dv {

// Resources that a reader allocates on behalf of a peer. A peer is one connection, datagram session or
// shared-memory segment.
enum class Resource : uint8_t {
  received_bytes,     // incomplete messages, and messages that the renderer has not read yet
  queued_bytes,       // replies and images queued for sending to the peer
  description_bytes,  // stream description: names, offsets
  names,              // node names in the description
  pose_bytes,         // pose frames: displayed, queued, in assembly
  edits,              // active scene edits, one per key
  edit_bytes,         // values of active edits
  nodes,              // nodes added to the scene, including those of assets
  lights,             // lights set by edits or contained in assets
  shadow_lights,      // shadow-casting subset of `lights`; lights beyond the limit cast no shadow
  asset_bytes,        // decoded assets in host memory
  gpu_bytes,          // estimated device memory of added assets and vertices
  requests,           // open image requests
  request_bytes,      // pixels of one image per open request
};
constexpr size_t kResourceCount = 14;

struct ResourceInfo {
  Resource resource;
  std::string_view name;  // used in options, metrics and panels: "asset-bytes"
  std::string_view noun;  // used in messages: "decoded assets"
  bool is_bytes;          // unit: bytes; otherwise a count of objects
  uint64_t per_peer;      // default limit of one peer
  uint64_t reserved;      // default amount guaranteed to each peer, regardless of the other peers
  uint64_t shared;        // default limit of the sum over all peers of their use beyond the reserved amounts
};
const std::array<ResourceInfo, kResourceCount>& resource_table();
inline const ResourceInfo& info(Resource resource) {
  return resource_table()[static_cast<size_t>(resource)];
}

// Time slices of the render thread: the longest time for one peer before the other peers get their turn.
struct TimeSlices {
  int64_t receive_ns = 2'000'000;  // messages of one peer per poll
  int64_t image_ns = 50'000'000;   // image requests between two polls
};

struct PeerLimits {
  PeerLimits();  // the defaults of resource_table()

  std::array<uint64_t, kResourceCount> per_peer, reserved, shared;
  TimeSlices slices;

  uint64_t& of(Resource resource) { return per_peer[static_cast<size_t>(resource)]; }
  uint64_t of(Resource resource) const { return per_peer[static_cast<size_t>(resource)]; }
};

// Sets one limit from "NAME=VALUE". NAME is a ResourceInfo::name (limit of one peer), "shared-" and such a
// name (sum over all peers beyond their reserved amounts), "receive-ms" or "image-ms". VALUE is an integer;
// byte limits accept the suffixes KiB, MiB and GiB. The error describes the fault and lists the names.
Result<void> set_limit(std::string_view text, PeerLimits& limits);

// Formats an amount for messages and panels: "84 KiB", "12 MiB", "4096".
std::string amount_text(Resource resource, uint64_t amount);

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

  // Time that scene builds have spent for this peer.
  void add_build_ns(int64_t ns) { build_ns_.fetch_add(ns, std::memory_order_relaxed); }
  int64_t build_ns() const { return build_ns_.load(std::memory_order_relaxed); }

  // Drawing time of the peer's content while other peers are connected. Written by the render thread.
  struct DrawCost {
    double seconds = 0;      // since it connected
    double share = 0;        // of the drawing time of the last seconds, 0 to 1
    bool is_hidden = false;  // to keep others' images fast
  };
  void set_draw_cost(const DrawCost& cost) {
    draw_seconds_.store(cost.seconds, std::memory_order_relaxed);
    draw_share_.store(cost.share, std::memory_order_relaxed);
    is_content_hidden_.store(cost.is_hidden, std::memory_order_relaxed);
  }
  DrawCost draw_cost() const {
    return {draw_seconds_.load(std::memory_order_relaxed), draw_share_.load(std::memory_order_relaxed),
            is_content_hidden_.load(std::memory_order_relaxed)};
  }

 private:
  friend class BudgetPool;
  PeerBudget(std::shared_ptr<BudgetPool> pool, std::string name);

  const std::shared_ptr<BudgetPool> pool_;
  std::string name_;  // guarded by the pool's mutex, like used_ and refused_
  std::array<uint64_t, kResourceCount> used_{}, refused_{};
  std::atomic<int64_t> build_ns_{0};
  std::atomic<double> draw_seconds_{0}, draw_share_{0};
  std::atomic<bool> is_content_hidden_{false};
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
