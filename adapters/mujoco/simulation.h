// MuJoCo simulation of one model: load, reset, drive, step. One thread at a time.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "adapters/mujoco/compiled/load.h"
#include "base/error.h"

namespace fire3dv::mujoco {

enum class Drive {
  hold,  // actuators hold the keyframe's controls, or zero without one
  sine,  // actuators oscillate about these controls within their range, with equal period and different
         // phases
  zero,
};

class Simulation {
 public:
  // keyframe: name or number; empty: the first one, or the model's default pose. folders: folders that the
  // model may read besides its own.
  static Result<Simulation> load(const std::filesystem::path& file, const std::string& keyframe, Drive drive,
                                 const std::vector<std::filesystem::path>& folders = {});

  // Advances by one step. Poses stay those of the step's start until update_poses(). The error has MuJoCo's
  // message.
  // before: called with the controls of this step set; null: not.
  Result<void> step(const std::function<void(const mjModel& model, mjData& data)>& before = {});
  Result<void> reset();
  // Computes poses of bodies, cameras, lights and tendons for the current time. reset() includes it.
  Result<void> update_poses();

  const mjModel& model() const { return *model_; }
  const mjData& data() const { return *data_; }
  // Returns MuJoCo's warnings since the last call.
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
