// Models of this tree for tests of the MuJoCo publisher, and their published poses.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "adapters/mujoco/compiled/load.h"
#include "adapters/mujoco/publisher.h"
#include "adapters/mujoco/simulation.h"

namespace fire3dv::mujoco {

inline constexpr const char* kCrane = "tests/assets/robots/crane.xml";

inline std::filesystem::path in_tree(const char* file) {
  return std::filesystem::path(FIRE3DV_SOURCE_DIR) / file;
}

inline Simulation loaded(const std::filesystem::path& file, Drive drive = Drive::sine,
                         const std::string& keyframe = "") {
  Result<Simulation> simulation = Simulation::load(file, keyframe, drive);
  EXPECT_TRUE(simulation.ok()) << simulation.error().message;
  return std::move(*simulation);  // a test cannot go on without one
}

inline glm::dmat4 matrix_of(const float* rows) {
  glm::dmat4 matrix(1);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      matrix[column][row] = static_cast<double>(rows[4 * row + column]);
  return matrix;
}

inline std::map<std::string, glm::dmat4> poses_of(const Simulation& simulation) {
  StreamedNodes nodes(simulation.model(), convert::names_of(simulation.model()));
  std::vector<float> poses;
  nodes.write(simulation.model(), simulation.data(), poses);
  std::map<std::string, glm::dmat4> by_name;
  for (size_t i = 0; i < nodes.names().size(); ++i) by_name[nodes.names()[i]] = matrix_of(&poses[12 * i]);
  EXPECT_EQ(by_name.size(), nodes.names().size()) << "a name is there twice";
  return by_name;
}

inline double apart(const glm::dmat4& a, const glm::dmat4& b) {
  double most = 0;
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row) most = std::max(most, std::abs(a[column][row] - b[column][row]));
  return most;
}

}  // namespace fire3dv::mujoco
