// Cache of prepared environment maps across runs. Reason: preparation takes two cores a tenth of a second.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "base/digest.h"

namespace fire3dv::passes {

// Called on any thread.
class EnvironmentStore {
 public:
  virtual ~EnvironmentStore() = default;
  // Returns the cached maps of this kind, or nothing if the size differs.
  virtual std::optional<std::vector<std::byte>> find(const Digest& kind, size_t bytes) = 0;
  virtual void keep(const Digest& kind, std::span<const std::byte> maps) = 0;
};

}  // namespace fire3dv::passes
