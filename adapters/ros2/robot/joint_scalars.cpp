#include "adapters/ros2/robot/joint_scalars.h"

#include <fire3dv/joints.h>
#include <fire3dv/scalars.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "base/text.h"

namespace fire3dv::ros2 {
namespace {

constexpr int64_t kJumpBackNs = 1'000'000'000;
constexpr size_t kMaxJointNameBytes = 1024;  // of a scalar
constexpr std::array<const char*, 3> kGroups = {"joint_positions", "joint_velocities", "joint_efforts"};
constexpr std::array<const char*, 3> kTurning = {"rad", "rad/s", "N m"}, kSliding = {"m", "m/s", "N"};

Result<void> check_names(const JointStateView& state, std::span<const size_t> order) {
  for (size_t i = 0; i < order.size(); ++i) {
    const std::string_view name = state.names[order[i]];
    if (name.empty() || name.size() > kMaxJointNameBytes)
      return Error{"a joint has a name of " + std::to_string(name.size()) + " bytes instead of 1 to 1024"};
    if (i > 0 && name == state.names[order[i - 1]])
      return Error{"joint " + quote(std::string(name)) + " is twice in one message"};
  }
  return {};
}

}  // namespace

void JointScalars::set_joint_types(JointTypes types) {
  types_ = std::move(types);
  for (JointSet& set : sets_) set_units(set);
}

void JointScalars::restart() {
  for (JointSet& set : sets_) set.last_ns.reset();
}

void JointScalars::set_units(JointSet& set) const {
  for (size_t g = 0; g < set.groups.size(); ++g) {
    std::vector<std::string> units;
    for (const std::string& name : set.names) {
      const auto type = types_.find(name);
      const bool turns = type != types_.end() && type->second == FIRE3DV_JOINT_REVOLUTE;
      const bool slides = type != types_.end() && type->second == FIRE3DV_JOINT_PRISMATIC;
      units.emplace_back(turns ? kTurning[g] : slides ? kSliding[g] : "");
    }
    ScalarGroup& group = set.groups[g];
    if (units == group.units) continue;
    group.units = std::move(units);
    group.is_declared = group.is_refused = false;
  }
}

JointScalars::JointSet* JointScalars::find(const JointStateView& state, std::span<const size_t> order) {
  const auto has_names = [&](const JointSet& set) {
    return std::ranges::equal(
        set.order, order, [&](size_t known, size_t index) { return set.names[known] == state.names[index]; });
  };
  if (const auto known = std::ranges::find_if(sets_, has_names); known != sets_.end()) return &*known;
  if (sets_.size() == kMaxSets) return nullptr;
  JointSet& set = sets_.emplace_back();
  set.names.assign(state.names.begin(), state.names.end());
  set.order.assign(order.begin(), order.end());
  for (size_t g = 0; g < set.groups.size(); ++g) {
    set.groups[g].name = kGroups[g];
    if (sets_.size() > 1) set.groups[g].name += " " + std::to_string(sets_.size());
    set.groups[g].names = set.names;
  }
  set_units(set);
  return &set;
}

Result<std::vector<ScalarGroup*>> JointScalars::take(const JointStateView& state) {
  std::vector<ScalarGroup*> groups;
  const size_t count = state.names.size();
  if (count == 0) return groups;
  if (count > FIRE3DV_MAX_SCALARS)
    return Error{"a message has " + std::to_string(count) + " joints, and a stream at most " +
                 std::to_string(FIRE3DV_MAX_SCALARS) + " scalars"};
  std::vector<size_t> order(count);
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::sort(order, {}, [&](size_t index) { return state.names[index]; });
  if (Result<void> good = check_names(state, order); !good) return good.error();
  JointSet* const set = find(state, order);
  if (!set)
    return Error{"the messages have more than " + std::to_string(kMaxSets) + " different sets of joints"};
  const bool is_late =
      set->last_ns && state.stamp_ns < *set->last_ns && *set->last_ns - state.stamp_ns < kJumpBackNs;
  if (is_late) return groups;
  set->last_ns = state.stamp_ns;
  const std::array<std::span<const double>, 3> numbers = {state.positions, state.velocities, state.efforts};
  for (size_t g = 0; g < numbers.size(); ++g) {
    ScalarGroup& group = set->groups[g];
    if (numbers[g].size() != count || group.is_refused) continue;
    group.values.resize(count);
    for (size_t i = 0; i < count; ++i) group.values[set->order[i]] = numbers[g][order[i]];
    group.time_ns = state.stamp_ns;
    groups.push_back(&group);
  }
  return groups;
}

}  // namespace fire3dv::ros2
