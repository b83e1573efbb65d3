// Simulator interface of both programs: named bodies, poses and fixed time steps.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "examples/two_simulators/stage.h"

namespace two_simulators {

constexpr double kStepsPerSecond = 240;

class Simulator {
 public:
  virtual ~Simulator() = default;

  virtual Frame frame() const = 0;
  virtual const std::vector<std::string>& names() const = 0;
  // 12 floats per body in the order of names(): stream_from_body, 3x4 row-major.
  virtual const std::vector<float>& poses() const = 0;
  // Advances by 1 / kStepsPerSecond. Returns false when the bodies jumped (discontinuity).
  virtual bool step() = 0;
};

}  // namespace two_simulators
