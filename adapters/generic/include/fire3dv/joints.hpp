// C++17 API of robots by joint positions: the C API of joints.h with RAII, containers and exceptions. Header
// only. Units, frames, order of positions, thread-safety: see joints.h.
//
//   fire3dv::Robot robot("arm.glb");
//   stream.describe(robot.description());
//   loop { robot.set_positions(q); robot.publish(stream, sim_time); }
//
// Errors: failures throw fire3dv::ClientError.
#ifndef FIRE3DV_JOINTS_HPP
#define FIRE3DV_JOINTS_HPP

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "fire3dv/client.hpp"
#include "fire3dv/joints.h"

namespace fire3dv {

// 3x4 matrix in double precision, row-major.
using PrecisePose = std::array<double, 12>;

// Owner of a robot; movable, not copyable.
class Robot {
 public:
  // flags: FIRE3DV_ROBOT_*.
  explicit Robot(const std::string& file, uint32_t flags = 0)
      : robot_(fire3dv_open_robot(file.c_str(), flags)) {
    if (!robot_) throw ClientError(FIRE3DV_ERROR_ARGUMENT, fire3dv_last_error());
  }
  ~Robot() { fire3dv_close_robot(&robot_); }
  Robot(Robot&& other) noexcept : robot_(std::exchange(other.robot_, nullptr)) {}
  Robot& operator=(Robot&& other) noexcept {
    std::swap(robot_, other.robot_);
    return *this;
  }
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;

  // Names in the result are the robot's.
  std::vector<fire3dv_joint> joints() const {
    std::vector<fire3dv_joint> all(fire3dv_joint_count(robot_));
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i].struct_size = sizeof all[i];
      check(fire3dv_get_joint(robot_, i, &all[i]));
    }
    return all;
  }
  std::vector<double> positions() const {
    std::vector<double> all(fire3dv_position_count(robot_));
    check(fire3dv_get_positions(robot_, all.data(), all.size()));
    return all;
  }
  // flags: FIRE3DV_POSITIONS_*.
  void set_positions(const std::vector<double>& positions, uint32_t flags = 0) {
    check(fire3dv_set_positions(robot_, positions.data(), positions.size(), flags));
  }
  void set_joint(std::size_t joint, const std::vector<double>& positions, uint32_t flags = 0) {
    check(fire3dv_set_joint(robot_, joint, positions.data(), positions.size(), flags));
  }
  void set_base(const PrecisePose& stream_from_model) {
    check(fire3dv_set_base(robot_, stream_from_model.data()));
  }
  PrecisePose node_pose(const std::string& node) {
    PrecisePose pose{};
    check(fire3dv_get_node_pose(robot_, node.c_str(), pose.data()));
    return pose;
  }

  Description description() const {
    fire3dv_description raw{};
    raw.struct_size = sizeof raw;
    check(fire3dv_get_robot_description(robot_, &raw));
    Description made;
    made.node_names.assign(raw.node_names, raw.node_names + raw.node_count);
    made.world_from_stream.assign(raw.world_from_stream, raw.world_from_stream + 12);
    made.body_from_node.resize(raw.body_from_node_count);
    for (std::size_t i = 0; i < raw.body_from_node_count; ++i)
      std::memcpy(made.body_from_node[i].data(), raw.body_from_node + 12 * i, sizeof(Pose));
    return made;
  }
  // The stream has this robot's description. flags: FIRE3DV_FRAME_* bits.
  void publish(Stream& stream, std::chrono::nanoseconds sim_time, uint32_t flags = 0) {
    check(fire3dv_publish_robot(stream.get(), robot_, sim_time.count(), flags));
  }
  // Sets the joint positions as scalars of the group, which renderers plot.
  void set_scalars(Stream& stream, std::chrono::nanoseconds sim_time,
                   const std::string& group = "joint_positions") {
    check(fire3dv_set_joint_scalars(stream.get(), robot_, group.c_str(), sim_time.count()));
  }

  // Returns the C handle. The Robot keeps ownership.
  fire3dv_robot* get() const noexcept { return robot_; }

 private:
  static void check(int code) {
    if (code != FIRE3DV_OK) throw ClientError(code, fire3dv_last_error());
  }

  fire3dv_robot* robot_ = nullptr;
};

}  // namespace fire3dv

#endif
