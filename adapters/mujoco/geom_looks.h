// What a simulation changes of its model's looks while it runs: colours, opacity and groups of geoms. Found
// by comparing, since MuJoCo does not say; told as scene edits by the geoms' names. A scene whose geoms are
// not nodes of their own has no such names, and stays as it is.
#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace fire3dv::mujoco {

struct GeomEdit {
  size_t geom = 0;                           // into MjcfNames::geoms
  std::optional<bool> visible;               // nothing: as it was
  std::optional<std::array<float, 4>> rgba;  // linear; nothing: as it was
};

class GeomLooks {
 public:
  // The scene was made of the model as it is now.
  explicit GeomLooks(const mjModel& model);

  // What has changed since the last call; mostly nothing, and then nothing is allocated.
  const std::vector<GeomEdit>& changes(const mjModel& model);

 private:
  struct Look {
    std::array<float, 4> rgba{};  // as displayed
    bool is_shown = false;
    bool is_in_scene = false;
  };
  std::vector<Look> looks_;
  std::vector<GeomEdit> changes_;
};

}  // namespace fire3dv::mujoco
