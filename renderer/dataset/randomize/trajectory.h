// Recorded path of a camera: poses over time, from a text file of the TUM format.
#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <string>
#include <vector>

#include "base/error.h"

namespace fire3dv::dataset {

struct Trajectory {
  struct Pose {
    double time_s = 0;
    glm::dvec3 position_m{0};
    glm::dquat world_from_camera{1, 0, 0, 0};  // OpenCV's axes: right, down, forward
  };
  std::vector<Pose> poses;  // ascending times, one at least
  std::string digest;       // of the file

  // Pose of a camera of glTF (right, up, backward) at this share of the duration, 0 to 1.
  glm::dmat4 at(double share) const;
};

// Lines "TIME X Y Z QX QY QZ QW", with comments after #: metres in the world, rotation from the camera's axes
// (OpenCV's) to the world's. Errors name the file and line.
Result<Trajectory> read_trajectory(const std::filesystem::path& file);

}  // namespace fire3dv::dataset
