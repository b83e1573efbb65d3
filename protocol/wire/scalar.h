// Scalars: named numbers with units that a stream publishes besides poses (joint angles, forces, energies).
// A group of scalars is declared once; its values follow, one array per simulation time. SPEC section 12 is
// normative.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace fire3dv::wire {

constexpr size_t kMaxScalars = 4096;          // of one stream, in all groups
constexpr uint32_t kMaxScalarUnitBytes = 64;  // UTF-8

// Declaration of a group. The key of the edit has the group's name in place of a node's.
struct Scalars {
  std::vector<std::string> names;  // not empty, unique within the group
  std::vector<std::string> units;  // as many; empty: without a unit
  bool operator==(const Scalars&) const = default;
};

// Values of a group at one simulation time. They never delay a pose frame.
struct ScalarValues {
  uint64_t declaration = 0;  // version of the edit that declared the group
  int64_t sim_time_ns = 0;
  std::vector<double> values;  // by index of the declaration; not finite: no value
  bool operator==(const ScalarValues&) const = default;
};

}  // namespace fire3dv::wire
