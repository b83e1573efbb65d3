// The nodes that MuJoCo moves, and where mjData has them: bodies, cameras, lights, and the pieces of spatial
// tendons. The names are those of the scene that is made of the model (tools/convert/mjcf_names.h).
#pragma once

#include <mujoco/mujoco.h>

#include <span>
#include <string>
#include <vector>

#include "tools/convert/mjcf_names.h"
#include "tools/convert/mjcf_tendons.h"

namespace fire3dv::mujoco {

class MovedNodes {
 public:
  MovedNodes(const mjModel& model, const convert::MjcfNames& names);

  const std::vector<std::string>& names() const { return names_; }

  // stream_from_node of all names(): 12 floats each, row-major, in MuJoCo's world, Z up, metres. What is in
  // mjData is written as it is: after mj_step that is the pose at the beginning of the step. Allocates
  // nothing after the first call.
  void write(const mjModel& model, const mjData& data, std::vector<float>& poses);

 private:
  std::vector<std::string> names_;
  std::vector<int> lights_, tendons_;
  std::vector<convert::TendonPiece> pieces_;
  std::vector<convert::TendonFrame> frames_;
};

}  // namespace fire3dv::mujoco
