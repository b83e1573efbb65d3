// Joint states (sensor_msgs/JointState) as scalars of a stream: groups joint_positions, joint_velocities and
// joint_efforts, with units by the type of the joint. Each set of joints that comes in one message has groups
// of its own, since publishers have times of their own.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "base/error.h"

namespace fire3dv::ros2 {

// FIRE3DV_JOINT_* by the name of the joint.
using JointTypes = std::unordered_map<std::string, int32_t>;

// Borrowed message. Numbers of another count than the names are not used; NaN: no value at this time.
struct JointStateView {
  std::span<const std::string_view> names;
  std::span<const double> positions, velocities, efforts;
  int64_t stamp_ns = 0;
};

struct ScalarGroup {
  std::string name;
  std::vector<std::string> names, units;  // a unit for each name; empty: unknown
  std::vector<double> values;             // in the order of the names
  int64_t time_ns = 0;
  // Set by the caller. A refused group is not returned again before its units change.
  bool is_declared = false, is_refused = false;
};

class JointScalars {
 public:
  static constexpr size_t kMaxSets = 16;  // sets of joints

  // Of the robot; they decide the units. Groups whose units change are declared again.
  void set_joint_types(JointTypes types);
  // The next message may have an earlier stamp: time went back.
  void restart();

  // Groups with the values of a message, valid until the next call; none if its stamp is less than a second
  // before that of the last one. Fails for names that cannot be scalars, and for more than kMaxSets sets.
  Result<std::vector<ScalarGroup*>> take(const JointStateView& state);

 private:
  struct JointSet {
    std::vector<std::string> names;  // in the order of the first message
    std::vector<size_t> order;       // of their indices, sorted by name
    std::array<ScalarGroup, 3> groups;
    std::optional<int64_t> last_ns;
  };
  JointSet* find(const JointStateView& state, std::span<const size_t> order);
  void set_units(JointSet& set) const;

  JointTypes types_;
  std::list<JointSet> sets_;  // groups keep their addresses
};

}  // namespace fire3dv::ros2
