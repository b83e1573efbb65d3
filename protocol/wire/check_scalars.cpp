// Validation of declarations and values of scalars.
#include <string>

#include "protocol/wire/check.h"

namespace fire3dv::wire {

Result<void> check(const Scalars& scalars, const DecodeLimits& limits) {
  const size_t count = scalars.names.size();
  if (count == 0) return Error{"SceneEdit.names is empty; clear the group of scalars instead"};
  if (count > kMaxScalars)
    return Error{"SceneEdit.names holds " + std::to_string(count) + " names; at most " +
                 std::to_string(kMaxScalars) + " scalars are allowed"};
  if (scalars.units.size() != count)
    return Error{"SceneEdit.units holds " + std::to_string(scalars.units.size()) + " units for " +
                 std::to_string(count) + " names; one for each name is needed, empty where there is none"};
  for (size_t i = 0; i < count; ++i) {
    const std::string index = "[" + std::to_string(i) + "]";
    if (scalars.names[i].empty()) return Error{"SceneEdit.names" + index + " is empty; a scalar has a name"};
    if (auto good = check_text("SceneEdit.names" + index, scalars.names[i], limits.max_name_bytes); !good)
      return good;
    if (auto good = check_text("SceneEdit.units" + index, scalars.units[i], kMaxScalarUnitBytes); !good)
      return good;
  }
  return check_unique("SceneEdit.names", scalars.names);
}

Result<void> check(const ScalarValues& scalars) {
  if (scalars.declaration == 0)
    return Error{"SceneEdit.declaration is 0; it is the version of the edit that declared the group"};
  if (scalars.values.empty()) return Error{"SceneEdit.values is empty; a group has at least one scalar"};
  if (scalars.values.size() > kMaxScalars)
    return Error{"SceneEdit.values holds " + std::to_string(scalars.values.size()) + " values; at most " +
                 std::to_string(kMaxScalars) + " scalars are allowed"};
  return {};
}

}  // namespace fire3dv::wire
