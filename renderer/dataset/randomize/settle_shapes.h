// Shapes of a scene's nodes for settle(): the bodies that fall, and the triangles that they fall onto.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "renderer/dataset/randomize/settle.h"
#include "renderer/scene/model/scene.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::dataset {

class SettleShapes {
 public:
  // Borrows the scene.
  explicit SettleShapes(const scene::Scene& scene) : scene_(scene) {}

  // Nodes of the frame that fall, each with those below it, and nodes that are hidden with those below them.
  // Of falling nodes below each other the upper one counts.
  void begin_frame(const std::set<uint32_t>& falling, const std::set<uint32_t>& hidden);
  bool falls(uint32_t node) const { return !is_hidden(node) && body_of_[node] == node; }

  // Poses are those before the fall. Deforming nodes are left out.
  FixedTriangles fixed_triangles(const state::PoseState& poses) const;
  // Without hulls if the body has no triangles.
  FallingBody falling_body(const state::PoseState& poses, uint32_t body);

 private:
  bool is_hidden(uint32_t node) const;
  const Hull& hull_of_mesh(uint32_t mesh);

  const scene::Scene& scene_;
  std::set<uint32_t> hidden_;
  std::vector<uint32_t> body_of_;   // by node; kNone: it is fixed
  std::map<uint32_t, Hull> hulls_;  // by mesh, in its axes
};

}  // namespace fire3dv::dataset
