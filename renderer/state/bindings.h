// Which scene node a name of a stream means.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "renderer/scene/scene.h"

namespace fire3dv::state {

class NodeNames {
 public:
  explicit NodeNames(const scene::Scene& scene);

  // The node of exactly this name if only one has it, else the node of this path if only one has it, else
  // scene::kNone.
  uint32_t find(std::string_view name) const;

 private:
  struct Hash : std::hash<std::string_view> {
    using is_transparent = void;
  };
  // Names that several nodes share map to kNone: a duplicate binds nothing rather than the first of them.
  using Index = std::unordered_map<std::string, uint32_t, Hash, std::equal_to<>>;
  static void insert(Index& index, const std::string& name, uint32_t node);
  static uint32_t lookup(const Index& index, std::string_view name);

  Index by_name_, by_path_;
};

}  // namespace fire3dv::state
