// Random poses of the worlds of a scene, published as simulators publish them: one stream per world.
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "protocol/wire/messages.h"
#include "renderer/scene/model/scene.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::bench {

class WorldPoses {
 public:
  // Moves the nodes with a mesh, the bodies.
  WorldPoses(const scene::Scene& scene, uint32_t worlds);

  // Computes the poses of a step: each body is turned about its own z axis, by up to 0.4 rad, at random.
  // Equal arguments give equal poses.
  void simulate(uint32_t step);
  // Publishes the computed poses to the pose state of each world.
  Result<void> publish();

  std::span<const state::PoseState* const> worlds() const { return worlds_; }
  size_t bodies() const { return bodies_.size(); }
  const std::vector<std::string>& names() const { return names_; }  // of the bodies' nodes
  // The computed poses: [world][body].
  std::span<const wire::Affine3x4> poses() const { return poses_; }

 private:
  struct Body {
    uint32_t node = 0;
    uint32_t parent = scene::kNone;  // body above it; kNone: the world
    glm::mat4 parent_from_body{1};   // at rest
  };
  void find_bodies(const scene::Scene& scene);

  std::vector<Body> bodies_;
  std::vector<std::string> names_;
  std::deque<state::PoseState> states_;
  std::vector<const state::PoseState*> worlds_;
  std::vector<state::StreamId> streams_;
  std::vector<wire::Affine3x4> poses_;  // of each world the bodies' poses
  uint64_t sequence_ = 0;
};

}  // namespace fire3dv::bench
