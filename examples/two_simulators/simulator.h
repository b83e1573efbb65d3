// What both programs run: something that has bodies, and goes on step by step.
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
  // 12 floats a body in the order of names(): stream_from_body, row-major 3x4.
  virtual const std::vector<float>& poses() const = 0;
  // Goes on by 1 / kStepsPerSecond. False: the bodies did not move there, they jumped.
  virtual bool step() = 0;
};

}  // namespace two_simulators
