// A model of MuJoCo's that is stepped: loaded, reset, driven.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "protocol/error.h"
#include "tools/convert/mjcf_load.h"

namespace fire3dv::mujoco {

enum class Drive {
  hold,  // actuators keep what the keyframe says; without one, zero
  sine,  // each swings about that within its range, all with one period and phases of their own
  zero,
};

class Simulation {
 public:
  // keyframe: its name or number; empty: the first, or the model's own pose where there is none.
  // folders: what the model may read beside its own folder.
  static Result<Simulation> load(const std::filesystem::path& file, const std::string& keyframe, Drive drive,
                                 const std::vector<std::filesystem::path>& folders = {});

  // Poses are then those of the new time. A sentence where MuJoCo gives up.
  Result<void> step();
  Result<void> reset();
  // After step(), before poses are read: they are those of the step's beginning until then.
  Result<void> place();

  const mjModel& model() const { return *model_; }
  const mjData& data() const { return *data_; }
  // What MuJoCo has warned of since the last call.
  std::vector<std::string> take_warnings() { return std::exchange(warnings_, {}); }

 private:
  Simulation(convert::MjcfModel model, convert::MjcfData data, int keyframe, Drive drive);
  void drive();

  convert::MjcfModel model_;
  convert::MjcfData data_;
  int keyframe_;  // -1: none
  Drive drive_;
  std::vector<std::string> warnings_;
};

}  // namespace fire3dv::mujoco
