// People's hands on a MuJoCo simulation, by inputs of its streams (fire3dv/input.h): a run bar, a slider for
// each actuator, and dragging of bodies by a spring. One thread at a time.
#pragma once

#include <fire3dv/input.h>
#include <mujoco/mujoco.h>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "base/error.h"

namespace fire3dv::mujoco {

// Force of the spring by which a person drags a point of a body: stiffness * (target - point) - damping *
// velocity of the point, in N, in MuJoCo's world frame. The stiffness is that of MuJoCo's viewer,
// vis.map.stiffness (100 by default) in N/m for each kg of the body and all below it; the damping is critical
// for that mass. The spring is at most as long as the model's extent. data: as after mj_kinematics and
// mj_comPos. point_body: in the body's frame.
std::array<double, 3> spring_force(const mjModel& model, const mjData& data, int body,
                                   const std::array<double, 3>& point_body,
                                   const std::array<double, 3>& target);

class Interaction {
 public:
  static constexpr int kMaxSliders = 200;      // of the first actuators
  static constexpr int kMaxEvents = 1024;      // of one poll(): a renderer may send without end
  static constexpr int kMaxSteps = 1'000'000;  // requested at a time

  // speed: simulated seconds per second; 0: unpaced, without a control of the speed.
  Interaction(const mjModel& model, bool is_running, double speed);

  // Declares the inputs to a stream whose first nodes are the model's bodies, the world's excluded.
  Result<void> declare(fire3dv_stream* stream) const;

  struct Requests {
    std::optional<bool> is_running;
    int steps = 0;  // while paused, after the last run, pause or reset; at most kMaxSteps
    bool reset = false;
    std::optional<double> speed;
  };
  // Takes the events of a stream that declare() was called for. stream_number: to tell its viewers from those
  // of others.
  Result<Requests> poll(fire3dv_stream* stream, size_t stream_number);
  // The program has changed what the run bar shows.
  void set_running(bool is_running) { run_.value = is_running ? 1 : 0; }

  // Before mj_step: sets controls of actuators that people have moved, and xfrc_applied of the bodies that
  // they drag, or have released.
  void apply(const mjModel& model, mjData& data);
  // Actuators are driven by the program again; declare() says so to viewers.
  void reset();
  bool is_dragging() const { return !pulls_.empty(); }

 private:
  using Holder = std::tuple<size_t, uint64_t, uint32_t>;  // stream, renderer, viewer
  struct Pull {
    int body = 0;
    std::array<double, 3> point_body{}, target{};
  };
  struct Slider {
    std::string name;
    double low = -1, high = 1, initial = 0, value = 0;
  };
  void take(const fire3dv_event& event, size_t stream_number, Requests& requests);

  int bodies_;
  double reach_;  // no point of a body is farther from the body's frame
  fire3dv_input run_{};
  std::vector<Slider> sliders_;  // by actuator
  std::map<std::string, int> actuators_;
  std::map<int, double> controls_;  // of actuators that people have moved
  std::map<Holder, Pull> pulls_;
  std::vector<int> pushed_;  // bodies with a force in xfrc_applied
};

}  // namespace fire3dv::mujoco
