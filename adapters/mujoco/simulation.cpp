#include "adapters/mujoco/simulation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "adapters/mujoco/compiled/model_files.h"
#include "base/numbers.h"
#include "base/text.h"

namespace fire3dv::mujoco {
namespace {

constexpr double kSwing_hz = 0.25;
constexpr double kSwing = 0.25;          // amplitude, as a share of an actuator's range
constexpr double kFreeSwing = 0.5;       // amplitude of actuators without a range
constexpr double kPhaseApart_rad = 0.7;  // phase between neighbouring actuators, so that they do not reverse
                                         // together

Result<int> keyframe_of(const mjModel& m, const std::string& text) {
  if (text.empty()) return m.nkey > 0 ? 0 : -1;
  if (const auto number = parse_number<int>(text); number && *number >= 0 && *number < m.nkey) return *number;
  if (const int found = mj_name2id(&m, mjOBJ_KEY, text.c_str()); found >= 0) return found;
  return Error{"the model has no keyframe " + quote(text) + "; it has " + std::to_string(m.nkey) +
               ", the first is 0"};
}

}  // namespace

Simulation::Simulation(convert::MjcfModel model, convert::MjcfData data, int keyframe, Drive drive)
    : model_(std::move(model)), data_(std::move(data)), keyframe_(keyframe), drive_(drive) {}

Result<Simulation> Simulation::load(const std::filesystem::path& file, const std::string& keyframe,
                                    Drive drive, const std::vector<std::filesystem::path>& folders) {
  if (const auto files = convert::mjcf_files(file, folders); !files) return files.error();
  std::vector<std::string> warnings;
  Result<convert::MjcfModel> model = convert::compile_mjcf(file, &warnings);
  if (!model)
    return Error{
        model.error().message + " (MuJoCo " + mj_versionString() +
        ", which this program is linked with; a model for a newer version cannot be stepped, but fire3dv "
        "can show it)"};
  const Result<int> start = keyframe_of(**model, keyframe);
  if (!start) return start.error();
  Result<convert::MjcfData> data = convert::pose_mjcf(**model, &warnings);
  if (!data) return Error{quote(file.string()) + ": " + data.error().message};
  Simulation simulation(std::move(*model), std::move(*data), *start, drive);
  if (Result<void> done = simulation.reset(); !done) return done.error();
  simulation.warnings_.insert(simulation.warnings_.begin(), warnings.begin(), warnings.end());
  return simulation;
}

Result<void> Simulation::reset() {
  const Result<void> done = convert::call_mujoco(
      [this] {
        if (keyframe_ >= 0)
          mj_resetDataKeyframe(model_.get(), data_.get(), keyframe_);
        else
          mj_resetData(model_.get(), data_.get());
      },
      &warnings_);
  return done ? update_poses() : done;
}

Result<void> Simulation::step(const std::function<void(const mjModel& model, mjData& data)>& before) {
  const Result<void> done = convert::call_mujoco(
      [&] {
        drive();
        if (before) before(*model_, *data_);
        mj_step(model_.get(), data_.get());
      },
      &warnings_);
  if (!done) return Error{"MuJoCo cannot step the model: " + done.error().message};
  return {};
}

Result<void> Simulation::update_poses() {
  const Result<void> done = convert::call_mujoco(
      [this] {
        mj_kinematics(model_.get(), data_.get());
        mj_comPos(model_.get(), data_.get());
        mj_camlight(model_.get(), data_.get());
        mj_tendon(model_.get(), data_.get());
      },
      &warnings_);
  if (!done) return Error{"MuJoCo cannot pose the model: " + done.error().message};
  return {};
}

void Simulation::drive() {
  const mjModel& m = *model_;
  for (int i = 0; i < m.nu; ++i) {
    const mjtNum* range = m.actuator_ctrlrange + 2 * i;
    const bool limited = m.actuator_ctrllimited[i];
    double middle = keyframe_ >= 0 ? m.key_ctrl[keyframe_ * m.nu + i] : 0;
    if (limited && (middle < range[0] || middle > range[1])) middle = (range[0] + range[1]) / 2;
    double control = drive_ == Drive::zero ? 0 : middle;
    if (drive_ == Drive::sine) {
      const double swing = limited ? kSwing * (range[1] - range[0]) : kFreeSwing;
      control += swing * std::sin(2 * std::numbers::pi * kSwing_hz * data_->time + kPhaseApart_rad * i);
    }
    data_->ctrl[i] = limited ? std::clamp(control, range[0], range[1]) : control;
  }
}

}  // namespace fire3dv::mujoco
