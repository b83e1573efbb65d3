#include "adapters/mujoco/moved_nodes.h"

#include "protocol/base/error.h"
#include "tools/convert/glb/lights.h"

namespace fire3dv::mujoco {
namespace {

// rows: 3x3 matrix, row-major, as in mjData.
float* put(float* pose, const mjtNum* place, const mjtNum* rows) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) *pose++ = static_cast<float>(rows[3 * row + column]);
    *pose++ = static_cast<float>(place[row]);
  }
  return pose;
}

float* put(float* pose, const glm::dvec3& place, const glm::dmat3& linear) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) *pose++ = static_cast<float>(linear[column][row]);
    *pose++ = static_cast<float>(place[row]);
  }
  return pose;
}

glm::dvec3 vec3(const mjtNum* v) {
  return {v[0], v[1], v[2]};
}

}  // namespace

StreamedNodes::StreamedNodes(const mjModel& m, const convert::MjcfNames& names) {
  names_.assign(names.bodies.begin() + 1, names.bodies.end());  // skips the world body, which never moves
  names_.insert(names_.end(), names.cameras.begin(), names.cameras.end());
  for (int light = 0; light < m.nlight; ++light) {
    if (!convert::is_scene_light(m, light)) continue;
    lights_.push_back(light);
    names_.push_back(names.lights[static_cast<size_t>(light)]);
  }
  for (int tendon = 0; tendon < m.ntendon; ++tendon) {
    const auto& pieces = names.tendon_pieces[static_cast<size_t>(tendon)];
    const auto& ends = names.tendon_ends[static_cast<size_t>(tendon)];
    if (pieces.empty()) continue;
    tendons_.push_back(tendon);
    names_.insert(names_.end(), pieces.begin(), pieces.end());
    names_.insert(names_.end(), ends.begin(), ends.end());
  }
}

void StreamedNodes::write(const mjModel& m, const mjData& d, std::vector<float>& poses) {
  poses.resize(12 * names_.size());
  float* pose = poses.data();
  for (int body = 1; body < m.nbody; ++body) pose = put(pose, d.xpos + 3 * body, d.xmat + 9 * body);
  for (int camera = 0; camera < m.ncam; ++camera)
    pose = put(pose, d.cam_xpos + 3 * camera, d.cam_xmat + 9 * camera);  // looks along -Z, as in glTF
  for (const int light : lights_) {
    pose = put(pose, vec3(d.light_xpos + 3 * light),
               glm::mat3_cast(convert::shining(vec3(d.light_xdir + 3 * light))));
  }
  for (const int tendon : tendons_) {
    convert::tendon_frames(m, d, tendon, pieces_, frames_);
    for (const convert::TendonFrame& frame : frames_) {
      pose = put(pose, frame.place,
                 glm::dmat3(frame.scale.x * frame.turn[0], frame.scale.y * frame.turn[1],
                            frame.scale.z * frame.turn[2]));
    }
  }
  FIRE3DV_ASSERT(pose == poses.data() + poses.size());
}

}  // namespace fire3dv::mujoco
