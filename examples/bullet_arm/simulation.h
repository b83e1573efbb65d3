// Bullet simulation of arm, objects and world, and the layout of the objects. Equal seed and rate give
// bit-identical poses in every run of one build. One thread.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "examples/common/object.h"

namespace bullet_arm {

// Objects around the arm: names, shapes, materials and initial poses. The stream frame is Bullet's world: Z
// up, metres, arm base at the origin, cameras at -Y.

using examples::Object, examples::Shape, examples::Size;

// Positions shared by motion script and layout. Angles are azimuths about Z.
constexpr float kHeldBoxAzimuth_rad = -2.88f;
constexpr float kHeldBoxRadius_m = 0.62f;
constexpr float kHeldBoxHalf_m = 0.03f;
constexpr float kPlinthHeight_m = 0.06f;
constexpr float kDominoRadius_m = 0.86f;
constexpr float kFirstDominoAzimuth_rad = -2.75f;

std::vector<Object> make_layout(uint64_t seed);

// Joint of the arm: radians, or metres of one that slides.
struct JointState {
  const char* name = nullptr;
  bool slides = false;
  double position = 0, velocity = 0;
};

class Simulation {
 public:
  Simulation(uint64_t seed, double rate_hz);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  void step();
  uint64_t steps() const { return steps_; }
  int64_t sim_time_ns() const;

  // Names of streamed bodies: the arm, then movable objects.
  const std::vector<std::string>& names() const { return names_; }
  // 12 floats per body in the order of names(): stream_from_body, 3x4 row-major.
  const std::vector<float>& poses() const { return poses_; }
  // Contacts that carried a load in the last step: x, y, z in the stream frame. Empty before the first step.
  std::vector<std::array<float, 3>> contact_points() const;
  // In a constant order.
  std::vector<JointState> joints() const;
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

// FNV-1a hash over the bits of all poses of all steps.
class PoseHash {
 public:
  void add(const std::vector<float>& poses);
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = 0xcbf29ce484222325ull;
};

}  // namespace bullet_arm
