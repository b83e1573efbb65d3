// The whole simulation: the arm, the objects and the world that steps them. The same seed and rate give the
// same poses, bit by bit, on every run of the same build.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "examples/bullet_arm/layout.h"

namespace bullet_arm {

class Simulation {
 public:
  Simulation(uint64_t seed, double rate_hz);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  void step();
  uint64_t steps() const { return steps_; }
  int64_t sim_time_ns() const;

  // Streamed bodies: the arm first, then the objects that can move.
  const std::vector<std::string>& names() const { return names_; }
  // 12 floats a body in the order of names(): stream_from_body, row-major 3x4.
  const std::vector<float>& poses() const { return poses_; }
  const std::vector<Object>& layout() const { return layout_; }

 private:
  struct World;
  void read_poses();

  double rate_hz_;
  uint64_t steps_ = 0;
  std::vector<Object> layout_;
  std::unique_ptr<World> world_;
  std::vector<std::string> names_;
  std::vector<float> poses_;
};

// FNV-1a over the bits of all poses: two runs agree only if every pose of every step does.
class PoseHash {
 public:
  void add(const std::vector<float>& poses);
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = 0xcbf29ce484222325ull;
};

}  // namespace bullet_arm
