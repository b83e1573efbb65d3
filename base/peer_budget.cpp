#include "base/peer_budget.h"

#include <algorithm>
#include <charconv>
#include <limits>

namespace fire3dv {
namespace {

constexpr uint64_t kKiB = uint64_t{1} << 10, kMiB = uint64_t{1} << 20, kGiB = uint64_t{1} << 30;

constexpr std::array<ResourceInfo, kResourceCount> kTable{{
    {Resource::received_bytes, "received-bytes", "messages not read yet", true, 512 * kMiB, 8 * kMiB, kGiB},
    {Resource::queued_bytes, "queued-bytes", "replies and images not sent yet", true, 256 * kMiB, 64 * kMiB,
     kGiB},
    {Resource::description_bytes, "description-bytes", "the description", true, 128 * kMiB, 2 * kMiB,
     512 * kMiB},
    {Resource::names, "names", "node names", false, 1'048'576, 65'536, 4'194'304},
    {Resource::pose_bytes, "pose-bytes", "pose frames", true, 512 * kMiB, 16 * kMiB, 2 * kGiB},
    {Resource::edits, "edits", "scene edits in force", false, 65'536, 4'096, 262'144},
    {Resource::edit_bytes, "edit-bytes", "values of scene edits", true, 256 * kMiB, 16 * kMiB, kGiB},
    {Resource::nodes, "nodes", "added nodes", false, 8'192, 1'024, 65'536},
    {Resource::lights, "lights", "lights", false, 8, 4, 32},
    {Resource::shadow_lights, "shadow-lights", "lights with shadows", false, 1, 0, 4},
    {Resource::asset_bytes, "asset-bytes", "decoded assets", true, 512 * kMiB, 64 * kMiB, 2 * kGiB},
    {Resource::gpu_bytes, "gpu-bytes", "device memory", true, kGiB, 64 * kMiB, 4 * kGiB},
    {Resource::requests, "requests", "image requests", false, 1'024, 64, 8'192},
    {Resource::request_bytes, "request-bytes", "requested images", true, kGiB, 64 * kMiB, 4 * kGiB},
}};

constexpr bool table_is_in_order() {
  for (size_t i = 0; i < kTable.size(); ++i) {
    if (static_cast<size_t>(kTable[i].resource) != i) return false;
  }
  return true;
}
static_assert(table_is_in_order());

Result<uint64_t> parse_amount(std::string_view name, std::string_view text, bool is_bytes) {
  uint64_t value = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view suffix = text.substr(static_cast<size_t>(end - text.data()));
  uint64_t unit = 0;
  if (suffix.empty()) unit = 1;
  if (is_bytes && suffix == "KiB") unit = kKiB;
  if (is_bytes && suffix == "MiB") unit = kMiB;
  if (is_bytes && suffix == "GiB") unit = kGiB;
  if (fault != std::errc() || unit == 0)
    return Error{std::string(name) + ": \"" + std::string(text) + "\" is not a whole number" +
                 (is_bytes ? ", optionally followed by KiB, MiB or GiB" : "")};
  if (value > std::numeric_limits<int64_t>::max() / unit)
    return Error{std::string(name) + ": " + std::string(text) + " is too large"};
  return value * unit;
}

std::string all_names() {
  std::string names;
  for (const ResourceInfo& each : kTable) names += std::string(each.name) + ", ";
  return names +
         "each of them with \"shared-\" in front for all peers together, receive-ms, image-ms, draw-time";
}

uint64_t beyond(uint64_t used, uint64_t reserved) {
  return used > reserved ? used - reserved : 0;
}

}  // namespace

const std::array<ResourceInfo, kResourceCount>& resource_table() {
  return kTable;
}

PeerLimits::PeerLimits() {
  for (size_t i = 0; i < kResourceCount; ++i) {
    per_peer[i] = kTable[i].per_peer;
    reserved[i] = kTable[i].reserved;
    shared[i] = kTable[i].shared;
  }
}

Result<void> set_limit(std::string_view text, PeerLimits& limits) {
  const size_t equals = text.find('=');
  if (equals == std::string_view::npos)
    return Error{"\"" + std::string(text) + "\" is not NAME=VALUE; names are " + all_names()};
  const std::string_view name = text.substr(0, equals), value = text.substr(equals + 1);
  if (name == "receive-ms" || name == "image-ms") {
    const Result<uint64_t> milliseconds = parse_amount(name, value, false);
    if (!milliseconds) return milliseconds.error();
    if (*milliseconds == 0 || *milliseconds > 60'000)
      return Error{std::string(name) + ": a time slice is 1 to 60000 ms, not " + std::string(value)};
    (name == "receive-ms" ? limits.slices.receive_ns : limits.slices.image_ns) =
        static_cast<int64_t>(*milliseconds) * 1'000'000;
    return {};
  }
  constexpr std::string_view kShared = "shared-";
  const bool is_shared = name.starts_with(kShared);
  const std::string_view bare = is_shared ? name.substr(kShared.size()) : name;
  for (size_t i = 0; i < kResourceCount; ++i) {
    if (kTable[i].name != bare) continue;
    const Result<uint64_t> amount = parse_amount(name, value, kTable[i].is_bytes);
    if (!amount) return amount.error();
    (is_shared ? limits.shared : limits.per_peer)[i] = *amount;
    // A limit below the default reserved amount lowers the reserved amount as well.
    if (!is_shared && limits.reserved[i] > *amount) limits.reserved[i] = *amount;
    return {};
  }
  return Error{"there is no limit \"" + std::string(name) + "\"; names are " + all_names()};
}

std::string amount_text(Resource resource, uint64_t amount) {
  if (!info(resource).is_bytes) return std::to_string(amount);
  if (amount >= 10 * kGiB) return std::to_string(amount / kGiB) + " GiB";
  if (amount >= 10 * kMiB) return std::to_string(amount / kMiB) + " MiB";
  if (amount >= 10 * kKiB) return std::to_string(amount / kKiB) + " KiB";
  return std::to_string(amount) + " bytes";
}

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
