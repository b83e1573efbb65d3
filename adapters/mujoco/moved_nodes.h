// Nodes that MuJoCo moves, with their poses from mjData: bodies, cameras, lights and segments of spatial
// tendons. Names match the scene that is converted from the model (tools/convert/mjcf/mjcf_names.h).
#pragma once

#include <mujoco/mujoco.h>

#include <span>
#include <string>
#include <vector>

#include "tools/convert/mjcf/mjcf_names.h"
#include "tools/convert/mjcf/mjcf_tendons.h"

namespace fire3dv::mujoco {

class StreamedNodes {
 public:
  StreamedNodes(const mjModel& model, const convert::MjcfNames& names);

  const std::vector<std::string>& names() const { return names_; }

  // Writes stream_from_node of all names(): 12 floats each, row-major, MuJoCo's world frame, Z up, metres.
  // mjData is used as it is: after mj_step it has the poses of the step's start. Allocates nothing after the
  // first call.
  void write(const mjModel& model, const mjData& data, std::vector<float>& poses);

 private:
  std::vector<std::string> names_;
  std::vector<int> lights_, tendons_;
  std::vector<convert::TendonPiece> pieces_;
  std::vector<convert::TendonFrame> frames_;
};

}  // namespace fire3dv::mujoco
