#include "protocol/base/peer_budget.h"

#include <algorithm>

namespace fire3dv {
namespace {

uint64_t beyond(uint64_t used, uint64_t reserved) {
  return used > reserved ? used - reserved : 0;
}

}  // namespace

std::shared_ptr<BudgetPool> BudgetPool::create(const PeerLimits& limits) {
  return std::shared_ptr<BudgetPool>(new BudgetPool(limits));
}

std::shared_ptr<PeerBudget> BudgetPool::add_peer(std::string name) {
  std::shared_ptr<PeerBudget> peer(new PeerBudget(shared_from_this(), std::move(name)));
  const std::lock_guard lock(mutex_);
  peers_.push_back(peer.get());
  return peer;
}

uint64_t BudgetPool::used(Resource resource) const {
  const std::lock_guard lock(mutex_);
  return used_[static_cast<size_t>(resource)];
}

std::vector<BudgetPool::Report> BudgetPool::report() const {
  const std::lock_guard lock(mutex_);
  std::vector<Report> report;
  for (const PeerBudget* peer : peers_) report.push_back({peer->name_, peer->used_, peer->refused_, peer});
  return report;
}

PeerBudget::PeerBudget(std::shared_ptr<BudgetPool> pool, std::string name)
    : pool_(std::move(pool)), name_(std::move(name)) {}

// Releases amounts that try_take() or take() charged without a BudgetCharge. A charge keeps its budget alive,
// so none is left here.
PeerBudget::~PeerBudget() {
  const std::lock_guard lock(pool_->mutex_);
  for (size_t i = 0; i < kResourceCount; ++i) {
    pool_->used_[i] -= used_[i];
    pool_->shared_used_[i] -= beyond(used_[i], pool_->limits_.reserved[i]);
  }
  std::erase(pool_->peers_, this);
}

bool PeerBudget::try_take(Resource resource, uint64_t amount) {
  const auto i = static_cast<size_t>(resource);
  const PeerLimits& limits = pool_->limits_;
  const std::lock_guard lock(pool_->mutex_);
  const uint64_t used = used_[i];
  const bool fits = amount <= limits.per_peer[i] && used <= limits.per_peer[i] - amount;
  const uint64_t more =
      fits ? beyond(used + amount, limits.reserved[i]) - beyond(used, limits.reserved[i]) : 0;
  if (!fits || (more > 0 && pool_->shared_used_[i] + more > limits.shared[i])) {
    ++refused_[i];
    return false;
  }
  used_[i] += amount;
  pool_->used_[i] += amount;
  pool_->shared_used_[i] += more;
  return true;
}

Result<void> PeerBudget::take(Resource resource, uint64_t amount) {
  if (try_take(resource, amount)) return {};
  const ResourceInfo& what = info(resource);
  const uint64_t used_now = used(resource), most = limit(resource);
  const auto text = [resource](uint64_t value) { return amount_text(resource, value); };
  const std::string noun(what.noun), name(what.name);
  if (amount > most || used_now > most - amount)
    return Error{noun + " would use " + text(used_now + amount) + "; the limit of one peer is " + text(most) +
                 " (the renderer's option --peer-limit " + name + "=VALUE changes it)"};
  return Error{noun + " would use " + text(used_now + amount) + ", but all peers together use " +
               text(pool_->used(resource)) + " and share " +
               text(limits().shared[static_cast<size_t>(resource)]) +
               " (the renderer's option --peer-limit shared-" + name + "=VALUE changes it)"};
}

void PeerBudget::give_back(Resource resource, uint64_t amount) {
  const auto i = static_cast<size_t>(resource);
  const std::lock_guard lock(pool_->mutex_);
  FIRE3DV_ASSERT(amount <= used_[i]);
  const uint64_t reserved = pool_->limits_.reserved[i];
  pool_->used_[i] -= amount;
  pool_->shared_used_[i] -= beyond(used_[i], reserved) - beyond(used_[i] - amount, reserved);
  used_[i] -= amount;
}

uint64_t PeerBudget::used(Resource resource) const {
  const std::lock_guard lock(pool_->mutex_);
  return used_[static_cast<size_t>(resource)];
}

uint64_t PeerBudget::refused(Resource resource) const {
  const std::lock_guard lock(pool_->mutex_);
  return refused_[static_cast<size_t>(resource)];
}

std::string PeerBudget::name() const {
  const std::lock_guard lock(pool_->mutex_);
  return name_;
}

void PeerBudget::set_name(std::string name) {
  const std::lock_guard lock(pool_->mutex_);
  name_ = std::move(name);
}

Result<BudgetCharge> BudgetCharge::take(std::shared_ptr<PeerBudget> budget, Resource resource,
                                        uint64_t amount) {
  if (budget) {
    if (Result<void> taken = budget->take(resource, amount); !taken) return taken.error();
  }
  BudgetCharge charge;
  charge.budget_ = std::move(budget);
  charge.resource_ = resource;
  charge.amount_ = amount;
  return charge;
}

BudgetCharge::BudgetCharge(BudgetCharge&& other) noexcept
    : budget_(std::move(other.budget_)),
      resource_(other.resource_),
      amount_(std::exchange(other.amount_, 0)) {}

BudgetCharge& BudgetCharge::operator=(BudgetCharge&& other) noexcept {
  if (this == &other) return *this;
  release();
  budget_ = std::move(other.budget_);
  resource_ = other.resource_;
  amount_ = std::exchange(other.amount_, 0);
  return *this;
}

Result<void> BudgetCharge::resize(uint64_t amount) {
  if (budget_ && amount > amount_) {
    if (Result<void> taken = budget_->take(resource_, amount - amount_); !taken) return taken;
  } else if (budget_ && amount < amount_) {
    budget_->give_back(resource_, amount_ - amount);
  }
  amount_ = amount;
  return {};
}

void BudgetCharge::release() {
  if (budget_ && amount_ > 0) budget_->give_back(resource_, amount_);
  budget_.reset();
  amount_ = 0;
}

}  // namespace fire3dv
