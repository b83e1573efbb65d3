// The phantom as a soft body of Bullet, a grasper that pulls at it and a blade that cuts it. Metres, Y up.
// The same steps give the same vertices. One thread.
#pragma once

#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "examples/soft_tissue/phantom.h"

namespace soft_tissue {

constexpr double kRate_hz = 60;
constexpr double kRun_s = 8;  // a run of the script

// Poses in the world, 3x4, row-major.
struct Instruments {
  std::array<float, 12> grasper, upper_jaw, lower_jaw, blade;
};

class Simulation {
 public:
  explicit Simulation(const Detail& detail);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  void step();
  double time_s() const { return static_cast<double>(steps_) / kRate_hz; }

  const Surface& surface() const { return phantom().surface; }
  size_t node_count() const { return phantom().lattice.nodes.size(); }
  // x y z of the vertices, outside and then inside, and their normals.
  const std::vector<float>& positions() const { return positions_; }
  const std::vector<float>& normals() const { return normals_; }
  const Instruments& instruments() const { return instruments_; }

 private:
  struct World;
  const Phantom& phantom() const { return phantoms_[static_cast<size_t>(cut_)]; }
  void make_body(int cut);
  void grasp(const Vec3& tip);
  void move_instruments();
  void rest_on_pad();
  void place_surface();
  void find_normals();

  Detail detail_;
  std::unique_ptr<World> world_;
  std::vector<Phantom> phantoms_;  // by the depth of the cut, made before the first step
  std::unique_ptr<btSoftBody> body_;
  int cut_ = 0;
  uint64_t steps_ = 0;
  struct Grasped {
    std::array<int, 4> key;
    Vec3 from_tip;
  };
  bool is_holding_ = false;
  std::vector<Grasped> grasped_;
  Vec3 tip_;
  std::vector<float> positions_, normals_;
  Instruments instruments_{};
};

}  // namespace soft_tissue
