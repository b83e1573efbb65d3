#include "adapters/mujoco/joint_scalars.h"

#include <set>

namespace fire3dv::mujoco {
namespace {

constexpr std::array<const char*, 3> kGroups = {"joint_positions", "joint_velocities", "joint_efforts"};
constexpr std::array<const char*, 3> kTurning = {"rad", "rad/s", "N m"}, kSliding = {"m", "m/s", "N"};

}  // namespace

JointScalars::JointScalars(const mjModel& m) {
  std::set<std::string> taken;
  for (int joint = 0; joint < m.njnt; ++joint) {
    const bool is_hinge = m.jnt_type[joint] == mjJNT_HINGE;
    if (!is_hinge && m.jnt_type[joint] != mjJNT_SLIDE) continue;
    joints_.push_back({m.jnt_qposadr[joint], m.jnt_dofadr[joint], is_hinge});
    const char* const own = mj_id2name(&m, mjOBJ_JOINT, joint);
    std::string name = own && *own ? own : "joint_" + std::to_string(joint);
    while (!taken.insert(name).second) name += "_";  // another joint has the name by itself
    names_.push_back(std::move(name));
  }
  for (std::vector<double>& values : values_) values.resize(joints_.size());
}

Result<void> JointScalars::declare(fire3dv_stream* stream) const {
  if (joints_.empty()) return {};
  std::vector<const char*> names, units;
  for (const std::string& name : names_) names.push_back(name.c_str());
  for (size_t group = 0; group < kGroups.size(); ++group) {
    units.clear();
    for (const Joint& joint : joints_) units.push_back(joint.is_hinge ? kTurning[group] : kSliding[group]);
    const fire3dv_scalars scalars{sizeof scalars, names.data(), units.data(), names.size()};
    if (fire3dv_declare_scalars(stream, kGroups[group], &scalars) != FIRE3DV_OK)
      return Error{fire3dv_last_error()};
  }
  return {};
}

Result<void> JointScalars::set(fire3dv_stream* stream, const mjData& d, int64_t sim_time_ns) {
  if (joints_.empty()) return {};
  for (size_t i = 0; i < joints_.size(); ++i) {
    values_[0][i] = d.qpos[joints_[i].position];
    values_[1][i] = d.qvel[joints_[i].velocity];
    values_[2][i] = d.qfrc_actuator[joints_[i].velocity];
  }
  for (size_t group = 0; group < kGroups.size(); ++group) {
    if (fire3dv_set_scalars(stream, kGroups[group], sim_time_ns, values_[group].data(), joints_.size()) !=
        FIRE3DV_OK)
      return Error{fire3dv_last_error()};
  }
  return {};
}

}  // namespace fire3dv::mujoco
