// Change detection for geom appearance: colour, opacity and visible groups. MuJoCo does not signal changes,
// so each call compares. Changes become scene edits by geom name; scenes without geom nodes stay unchanged.
#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace fire3dv::mujoco {

struct GeomEdit {
  size_t geom = 0;                           // index into MjcfNames::geoms
  std::optional<bool> visible;               // empty: unchanged
  std::optional<std::array<float, 4>> rgba;  // linear RGBA; empty: unchanged
};

class GeomAppearance {
 public:
  // The scene must have been exported from the model in its current state.
  explicit GeomAppearance(const mjModel& model);

  // Returns changes since the last call. Without changes it allocates nothing.
  const std::vector<GeomEdit>& changes(const mjModel& model);

 private:
  struct Appearance {
    std::array<float, 4> rgba{};  // as displayed (sRGB)
    bool is_shown = false;
    bool is_in_scene = false;
  };
  std::vector<Appearance> appearances_;
  std::vector<GeomEdit> changes_;
};

}  // namespace fire3dv::mujoco
