// Joints of a MuJoCo simulation as scalars: groups joint_positions, joint_velocities and joint_efforts of its
// hinge and slide joints, for plots and recordings.
#pragma once

#include <fire3dv/scalars.h>
#include <mujoco/mujoco.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/error.h"

namespace fire3dv::mujoco {

class JointScalars {
 public:
  // Joints without a name are joint_N, N their index.
  explicit JointScalars(const mjModel& model);

  // Declares the groups; none without such joints.
  Result<void> declare(fire3dv_stream* stream) const;
  // Positions, velocities and forces of actuators in data.
  Result<void> set(fire3dv_stream* stream, const mjData& data, int64_t sim_time_ns);

 private:
  struct Joint {
    int position = 0, velocity = 0;  // indices into qpos, and into qvel and qfrc_actuator
    bool is_hinge = false;
  };
  std::vector<Joint> joints_;
  std::vector<std::string> names_;
  std::array<std::vector<double>, 3> values_;  // of the groups, by joint
};

}  // namespace fire3dv::mujoco
