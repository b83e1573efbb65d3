// Transforms of the wire format: `a_from_b` maps coordinates of frame b to frame a; 3x4, row-major, [row * 4
// + column].
#pragma once

#include <array>

namespace fire3dv::wire {

// Pose matrix, identical on the wire and on the GPU: the layout of VkTransformMatrixKHR.
struct Affine3x4 {
  std::array<float, 12> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};  // row-major, [row * 4 + column]
  bool operator==(const Affine3x4&) const = default;
};
static_assert(sizeof(Affine3x4) == 48);

struct Affine3x4d {
  std::array<double, 12> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  bool operator==(const Affine3x4d&) const = default;
};

}  // namespace fire3dv::wire
