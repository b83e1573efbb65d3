// Bullet simulation of a tray of objects that a rotating blade stirs. After a fixed period all objects return
// to their initial poses.
#pragma once

#include <memory>
#include <vector>

#include "examples/common/object.h"
#include "examples/two_simulators/simulator.h"

namespace two_simulators {

constexpr float kStirrerHub_m = 0.028f, kStirrerHubHalf_m = 0.048f;
constexpr examples::Vec3 kStirrerBladeHalf_m{0.092f, 0.007f, 0.026f};
constexpr float kStirrerBladeAt_m = 0.118f;  // centre of the blade, from the axis
constexpr float kStirrerZ_m = 0.062f;        // origin of the stirrer

// Objects around the tray centre, in stage directions, metres. Objects without mass are static and not
// streamed.
std::vector<examples::Object> heap_layout();
constexpr const char* kStirrerName = "heap_stirrer";

class Heap final : public Simulator {
 public:
  Heap();
  ~Heap() override;

  Frame frame() const override { return kHeapFrame; }
  const std::vector<std::string>& names() const override { return names_; }
  const std::vector<float>& poses() const override { return poses_; }
  bool step() override;

 private:
  struct World;
  void begin();
  void read_poses();

  std::unique_ptr<World> world_;
  uint64_t steps_ = 0;  // since the last reset
  std::vector<std::string> names_;
  std::vector<float> poses_;
};

}  // namespace two_simulators
