// Lenses that bend straight lines, as OpenCV calibrates them. Points lie on the plane at distance 1 before
// the camera, x to the right and y down.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>

#include "protocol/error.h"
#include "renderer/passes/view.h"

namespace fire3dv::passes {

enum class LensModel : uint8_t {
  none,
  plumb_bob,  // k1 k2 p1 p2 k3: cv::projectPoints
  fisheye,    // k1 k2 k3 k4 0: cv::fisheye::projectPoints
};

struct Lens {
  LensModel model = LensModel::none;
  std::array<float, 5> coefficients{};
  bool operator==(const Lens&) const = default;
};

// Where the lens puts what a pinhole shows at this point.
// plumb_bob: r2 = x^2 + y^2, x' = x (1 + k1 r2 + k2 r2^2 + k3 r2^3) + 2 p1 x y + p2 (r2 + 2 x^2), and y' with
// p1 and p2 changed over. fisheye: the angle t off the axis becomes t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4
// t^8).
glm::dvec2 distort(const Lens& lens, const glm::dvec2& point);

// How far from the axis points may lie so that the lens puts none in the place of another: the distances that
// it makes of theirs rise up to there. At most some 80 degrees, since a pinhole's image ends before 90.
double largest_radius(const Lens& lens);
// The point within largest_radius() that the lens puts there, if there is one.
std::optional<glm::dvec2> undistort(const Lens& lens, const glm::dvec2& distorted);

// A pinhole in the place of a camera with a lens, whose image holds all that is seen through the lens, with
// twice as many pixels along a line where the lens shows it largest. most_side: of that image, in pixels;
// where that does not do it has fewer. One sentence when too little is left.
Result<Intrinsics> pinhole_behind(const Intrinsics& intrinsics, const Lens& lens, uint32_t most_side);

}  // namespace fire3dv::passes
