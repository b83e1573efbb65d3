// Lens distortion models of OpenCV calibration. Points lie on the plane at distance 1 in front of the camera,
// x to the right and y down.
#pragma once

#include <glm/glm.hpp>
#include <optional>

#include "protocol/base/error.h"
#include "protocol/wire/image.h"
#include "renderer/passes/view.h"

namespace fire3dv::passes {

using wire::Lens;
using wire::LensModel;

// Distorts a pinhole point, as cv::projectPoints and cv::fisheye::projectPoints do.
// plumb_bob: r2 = x^2 + y^2, x' = x (1 + k1 r2 + k2 r2^2 + k3 r2^3) + 2 p1 x y + p2 (r2 + 2 x^2), and y' with
// p1 and p2 exchanged.
// fisheye: the angle t off the axis becomes t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8).
glm::dvec2 distort(const Lens& lens, const glm::dvec2& point);

// Largest radius of points up to which the distorted radius increases, so that distortion is injective. At
// most about 80 degrees, since a pinhole image ends before 90.
double largest_radius(const Lens& lens);
// Returns the point within largest_radius() that distorts to this one, if any.
std::optional<glm::dvec2> undistort(const Lens& lens, const glm::dvec2& distorted);

// Pinhole camera whose image contains the lens's visible field. Its resolution is twice the lens's at the
// largest magnification. most_side: maximum size of that image in pixels; larger images are scaled down.
// Returns an error when the resolution gets too low.
Result<Intrinsics> pinhole_behind(const Intrinsics& intrinsics, const Lens& lens, uint32_t most_side);

}  // namespace fire3dv::passes
