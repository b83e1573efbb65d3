// State of an image for policies: joint positions of the scene's robot, and poses of the other nodes that a
// recording moves.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "protocol/robot/joint_reader.h"
#include "protocol/robot/robot.h"
#include "renderer/scene/model/scene.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::dataset {

// Nodes of the scene that the streams of a recording move, ascending. It reads the file up to the last first
// description of a stream. The error names the file.
Result<std::vector<uint32_t>> find_moved_nodes(const std::string& recording, const scene::Scene& scene);

class RecordedState {
 public:
  // robot: of the scene's file. nullopt, one whose bodies no stream moves, or whose joints their poses do not
  // tell apart: the state is the poses of all moved nodes.
  RecordedState(const scene::Scene& scene, const std::optional<robot::Robot>& robot,
                const std::vector<uint32_t>& moved_nodes);

  // One for each number. State: joints (rad, m), else poses. Environment: poses, if the state is joints. A
  // pose in the world is "NODE.x", .y, .z (m), .qx, .qy, .qz, .qw (unit quaternion, w >= 0).
  const std::vector<std::string>& names() const { return names_; }
  const std::vector<std::string>& environment_names() const { return environment_names_; }
  // Why the joints of a robot are not the state; empty: they are, or there is none.
  const std::string& note() const { return note_; }

  struct Values {
    std::vector<double> state, environment;
  };
  // Of the poses that are shown now.
  Values read(const state::PoseState& poses) const;

 private:
  std::optional<robot::JointReader> joints_;
  robot::Transform model_from_world_;
  std::vector<uint32_t> node_of_body_;  // scene::kNone: the scene has no such node
  std::vector<uint32_t> posed_;         // nodes whose poses are values
  std::vector<std::string> names_, environment_names_;
  std::string note_;
};

}  // namespace fire3dv::dataset
