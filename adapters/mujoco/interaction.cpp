#include "adapters/mujoco/interaction.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>

#include "base/text.h"

namespace fire3dv::mujoco {
namespace {

constexpr const char* kRun = "run";
constexpr const char* kDrag = "drag";
constexpr double kMinSpeed = 0.05, kMaxSpeed = 10;
constexpr size_t kMaxNameBytes = 100;
constexpr double kMinMass_kg = 1e-6;

void cross(const double* a, const double* b, double* out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

// In the world. rows: 3x3, row-major, as in mjData.
std::array<double, 3> world_point(const mjData& d, int body, const std::array<double, 3>& point_body) {
  std::array<double, 3> point{};
  const mjtNum* const rows = d.xmat + 9 * body;
  for (size_t row = 0; row < 3; ++row) {
    point[row] = d.xpos[3 * static_cast<size_t>(body) + row];
    for (size_t column = 0; column < 3; ++column) point[row] += rows[3 * row + column] * point_body[column];
  }
  return point;
}

// Farthest that a geom's surface may be from its body's frame, or the model's extent if that is more.
double reach_of(const mjModel& m) {
  double reach = std::max<double>(m.stat.extent, 0);
  for (int geom = 0; geom < m.ngeom; ++geom)
    reach = std::max<double>(reach, mju_norm3(m.geom_pos + 3 * geom) + m.geom_rbound[geom]);
  return reach;
}

// The point, or the one in its direction at that distance. Else a renderer could choose any lever.
std::array<double, 3> within(double reach, const double* point) {
  const double distance = std::hypot(point[0], point[1], point[2]);
  const double scale = distance > reach ? reach / distance : 1;
  return {scale * point[0], scale * point[1], scale * point[2]};
}

// Unique: a name may be repeated after its end was cut, or its control characters were replaced.
std::string slider_name(const mjModel& m, int actuator, std::set<std::string>& taken) {
  const char* const own = mj_id2name(&m, mjOBJ_ACTUATOR, actuator);
  const std::string number = std::to_string(actuator);
  std::string name = own && *own ? printable_text(own, kMaxNameBytes) : "actuator_" + number;
  std::ranges::replace(name, '/', '_');  // the part before a slash is a folder
  if (!taken.insert(name).second) {
    name += " " + number;
    taken.insert(name);
  }
  return "actuators/" + name;
}

Result<void> declare_input(fire3dv_stream* stream, const char* name, const fire3dv_input& input) {
  if (fire3dv_declare_input(stream, name, &input) == FIRE3DV_OK) return {};
  return Error{"the control " + quote(name) + " is refused: " + fire3dv_last_error()};
}

fire3dv_input input_of(int kind) {
  fire3dv_input input{};
  input.struct_size = sizeof input;
  input.kind = kind;
  return input;
}

}  // namespace

std::array<double, 3> spring_force(const mjModel& m, const mjData& d, int body,
                                   const std::array<double, 3>& point_body,
                                   const std::array<double, 3>& target) {
  const std::array<double, 3> point = world_point(d, body, point_body);
  std::array<double, 3> stretch{}, force{};
  double length = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    stretch[axis] = target[axis] - point[axis];
    length += stretch[axis] * stretch[axis];
  }
  length = std::sqrt(length);
  const double longest = std::max<double>(m.stat.extent, kMinMass_kg);
  const double scale = length > longest ? longest / length : 1;
  const double mass = std::max<double>(m.body_subtreemass[body], kMinMass_kg);
  const double stiffness = static_cast<double>(m.vis.map.stiffness) * mass;
  const double damping = 2 * std::sqrt(stiffness * mass);
  mjtNum velocity[6];  // rotation, then motion of the body's frame, in the world's axes
  mj_objectVelocity(&m, &d, mjOBJ_XBODY, body, velocity, 0);
  double lever[3], turning[3];
  for (size_t axis = 0; axis < 3; ++axis)
    lever[axis] = point[axis] - d.xpos[3 * static_cast<size_t>(body) + axis];
  cross(velocity, lever, turning);
  for (size_t axis = 0; axis < 3; ++axis)
    force[axis] = stiffness * scale * stretch[axis] - damping * (velocity[3 + axis] + turning[axis]);
  return force;
}

Interaction::Interaction(const mjModel& m, bool is_running, double speed)
    : bodies_(m.nbody), reach_(reach_of(m)), run_(input_of(FIRE3DV_INPUT_RUN)) {
  run_.flags = FIRE3DV_INPUT_RUN_PAUSE | FIRE3DV_INPUT_STEP | FIRE3DV_INPUT_RESET;
  run_.value = is_running ? 1 : 0;
  if (speed > 0) {
    run_.flags |= FIRE3DV_INPUT_SPEED;
    run_.minimum = std::min(kMinSpeed, speed);
    run_.maximum = std::max(kMaxSpeed, speed);
    run_.speed = speed;
  }
  std::set<std::string> taken;
  for (int i = 0; i < std::min<int>(m.nu, kMaxSliders); ++i) {
    Slider slider{slider_name(m, i, taken)};
    const mjtNum* const range = m.actuator_ctrlrange + 2 * i;
    if (m.actuator_ctrllimited[i] && range[0] < range[1]) {
      slider.low = range[0];
      slider.high = range[1];
    }
    slider.value = slider.initial = std::clamp(0.0, slider.low, slider.high);
    actuators_[slider.name] = i;
    sliders_.push_back(std::move(slider));
  }
}

Result<void> Interaction::declare(fire3dv_stream* stream) const {
  if (Result<void> declared = declare_input(stream, kRun, run_); !declared) return declared;
  if (Result<void> declared = declare_input(stream, kDrag, input_of(FIRE3DV_INPUT_DRAG)); !declared)
    return declared;
  for (const Slider& slider : sliders_) {
    fire3dv_input input = input_of(FIRE3DV_INPUT_SLIDER);
    input.minimum = slider.low;
    input.maximum = slider.high;
    input.value = slider.value;
    if (Result<void> declared = declare_input(stream, slider.name.c_str(), input); !declared) return declared;
  }
  return {};
}

void Interaction::take(const fire3dv_event& event, size_t stream_number, Requests& requests) {
  const Holder holder(stream_number, event.source, event.viewer);
  switch (event.action) {
    case FIRE3DV_EVENT_RUN:
    case FIRE3DV_EVENT_PAUSE:
      requests.steps = 0;
      requests.is_running = event.action == FIRE3DV_EVENT_RUN;
      return set_running(*requests.is_running);
    case FIRE3DV_EVENT_STEP:
      requests.steps = static_cast<int>(std::min<double>(requests.steps + event.value, kMaxSteps));
      return;
    case FIRE3DV_EVENT_RESET:
      requests.steps = 0;
      requests.reset = true;
      return;
    case FIRE3DV_EVENT_SPEED:
      requests.speed = run_.speed = event.value;
      return;
    case FIRE3DV_EVENT_SET:
      if (const auto actuator = actuators_.find(event.input); actuator != actuators_.end())
        controls_[actuator->second] = sliders_[static_cast<size_t>(actuator->second)].value = event.value;
      return;
    case FIRE3DV_EVENT_BEGIN:
    case FIRE3DV_EVENT_MOVE: {
      const int body = static_cast<int>(event.node) + 1;  // the world's body is no node
      if (body >= bodies_) return;                        // a camera, a light or a tendon
      Pull& pull = pulls_[holder];
      pull.body = body;
      pull.point_body = within(reach_, event.node_point);
      std::copy_n(event.target, 3, pull.target.begin());
      return;
    }
    case FIRE3DV_EVENT_END:
      pulls_.erase(holder);
      return;
    default:
      return;
  }
}

Result<Interaction::Requests> Interaction::poll(fire3dv_stream* stream, size_t stream_number) {
  Requests requests;
  fire3dv_event event{};
  event.struct_size = sizeof event;
  int count = 0;
  for (int i = 0; i < kMaxEvents && (count = fire3dv_poll_events(stream, &event, 1)) == 1; ++i)
    take(event, stream_number, requests);
  if (count < 0) return Error{std::string("events are refused: ") + fire3dv_last_error()};
  return requests;
}

void Interaction::reset() {
  controls_.clear();
  for (Slider& slider : sliders_) slider.value = slider.initial;
}

void Interaction::apply(const mjModel& m, mjData& d) {
  for (const auto& [actuator, control] : controls_) d.ctrl[actuator] = control;
  for (const int body : pushed_) std::fill_n(d.xfrc_applied + 6 * body, 6, 0.0);
  pushed_.clear();
  if (pulls_.empty()) return;
  mj_kinematics(&m, &d);  // mj_step has left the poses of its beginning
  mj_comPos(&m, &d);
  mj_comVel(&m, &d);
  for (const auto& [holder, pull] : pulls_) {
    const std::array<double, 3> force = spring_force(m, d, pull.body, pull.point_body, pull.target);
    const std::array<double, 3> point = world_point(d, pull.body, pull.point_body);
    double lever[3], torque[3];
    for (size_t axis = 0; axis < 3; ++axis)
      lever[axis] = point[axis] - d.xipos[3 * static_cast<size_t>(pull.body) + axis];
    cross(lever, force.data(), torque);
    mjtNum* const applied = d.xfrc_applied + 6 * pull.body;
    for (size_t axis = 0; axis < 3; ++axis) {
      applied[axis] += force[axis];
      applied[3 + axis] += torque[axis];
    }
    pushed_.push_back(pull.body);
  }
}

}  // namespace fire3dv::mujoco
