#include "renderer/passes/post/lens.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace fire3dv::passes {
namespace {

constexpr double kMaxAngleRad = 1.4;
constexpr double kPixelsForOne = 2;  // resolution of the pinhole image relative to the lens image, along a
                                     // line
constexpr double kMinPixelsForOne = 0.5;

// Radial term without p1 and p2: distorted radius and its derivative.
struct Radial {
  double value, slope;
};
Radial radial(const Lens& lens, double r) {
  const auto& k = lens.coefficients;
  if (lens.model == LensModel::plumb_bob) {
    const double r2 = r * r;
    return {r * (1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))),
            1 + r2 * (3 * k[0] + r2 * (5 * k[1] + r2 * 7 * k[4]))};
  }
  if (lens.model == LensModel::fisheye) {
    const double t = std::atan(r), t2 = t * t;
    return {t * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))),
            (1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])))) / (1 + r * r)};
  }
  return {r, 1};
}

// Jacobian of the distortion, column-major.
glm::dmat2 slope_of(const Lens& lens, const glm::dvec2& point) {
  constexpr double kStep = 1e-6;
  const glm::dvec2 x(kStep, 0), y(0, kStep);
  return {(distort(lens, point + x) - distort(lens, point - x)) / (2 * kStep),
          (distort(lens, point + y) - distort(lens, point - y)) / (2 * kStep)};
}

double radius_before(const Lens& lens, double distorted, double largest) {
  double low = 0, high = largest, r = std::min(distorted, largest);
  for (int i = 0; i < 60; ++i) {
    const Radial at = radial(lens, r);
    (at.value < distorted ? low : high) = r;
    const double next = r - (at.value - distorted) / at.slope;
    const double before = std::exchange(r, next > low && next < high ? next : 0.5 * (low + high));
    if (std::abs(r - before) < 1e-12) break;
  }
  return r;
}

std::optional<glm::dvec2> undistort(const Lens& lens, const glm::dvec2& distorted, double largest) {
  if (lens.model == LensModel::none) return distorted;
  const double d = glm::length(distorted);
  glm::dvec2 point(0);
  if (d > 0) point = distorted * (radius_before(lens, d, largest) / d);
  if (lens.model == LensModel::plumb_bob) {
    for (int i = 0; i < 8; ++i) {
      const glm::dvec2 step = glm::inverse(slope_of(lens, point)) * (distort(lens, point) - distorted);
      if (!std::isfinite(step.x + step.y)) return {};
      point -= step;
    }
  }
  const bool found = glm::length(distort(lens, point) - distorted) < 1e-6 * std::max(1.0, d);
  return found && glm::length(point) <= largest ? std::optional(point) : std::nullopt;
}

// Extent of the visible field, and the largest magnification.
struct Seen {
  glm::dvec2 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};
  double most_enlarged = 1;
};
void add(Seen& seen, const Lens& lens, const glm::dvec2& point) {
  seen.low = glm::min(seen.low, point);
  seen.high = glm::max(seen.high, point);
  const glm::dmat2 slope = slope_of(lens, point);
  const double larger = std::max(glm::length(slope[0]), glm::length(slope[1]));
  if (std::isfinite(larger)) seen.most_enlarged = std::max(seen.most_enlarged, larger);
}

Seen seen_through(const Intrinsics& intrinsics, const Lens& lens) {
  const double largest = largest_radius(lens);
  const glm::dvec2 focal(intrinsics.fx_px, intrinsics.fy_px),
      principal_point(intrinsics.cx_px, intrinsics.cy_px);
  const glm::dvec2 end = glm::dvec2(intrinsics.image_px) - 0.5;
  constexpr int kSteps = 64;
  Seen seen;
  bool all = true;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      // The border determines the extent; inside, a few points suffice for the magnification.
      const bool at_edge = i % kSteps == 0 || j % kSteps == 0;
      if (!at_edge && (i % 8 != 0 || j % 8 != 0)) continue;
      const glm::dvec2 pixel = glm::mix(glm::dvec2(-0.5), end, glm::dvec2(i, j) / double{kSteps});
      if (const auto point = undistort(lens, (pixel - principal_point) / focal, largest)) {
        add(seen, lens, *point);
      } else {
        all = false;
      }
    }
  }
  // The visible field ends inside the image, between two grid points.
  if (!all) {
    for (int i = 0; i < 4 * kSteps; ++i) {
      const double angle = 2 * M_PI * i / (4 * kSteps);
      const glm::dvec2 rim = largest * glm::dvec2(std::cos(angle), std::sin(angle));
      const glm::dvec2 pixel = focal * distort(lens, rim) + principal_point;
      if (glm::all(glm::greaterThanEqual(pixel, glm::dvec2(-1))) &&
          glm::all(glm::lessThanEqual(pixel, end + 1.0)))
        add(seen, lens, rim);
    }
  }
  return seen;
}

}  // namespace

glm::dvec2 distort(const Lens& lens, const glm::dvec2& point) {
  if (lens.model == LensModel::none) return point;
  const double r = glm::length(point);
  if (r == 0) return point;
  glm::dvec2 result = point * (radial(lens, r).value / r);
  if (lens.model == LensModel::plumb_bob) {
    const double p1 = lens.coefficients[2], p2 = lens.coefficients[3], xy = 2 * point.x * point.y;
    result += glm::dvec2(p1 * xy + p2 * (r * r + 2 * point.x * point.x),
                         p1 * (r * r + 2 * point.y * point.y) + p2 * xy);
  }
  return result;
}

double largest_radius(const Lens& lens) {
  constexpr int kSteps = 4096;
  double r = 0;
  for (int i = 1; i <= kSteps; ++i) {
    const double next = std::tan(kMaxAngleRad * i / kSteps);
    if (!(radial(lens, next).slope > 1e-3)) break;
    r = next;
  }
  return r;
}

std::optional<glm::dvec2> undistort(const Lens& lens, const glm::dvec2& distorted) {
  return undistort(lens, distorted, largest_radius(lens));
}

Result<Intrinsics> pinhole_behind(const Intrinsics& intrinsics, const Lens& lens, uint32_t most_side) {
  const Seen seen = seen_through(intrinsics, lens);
  if (!(seen.low.x <= seen.high.x))
    return Error{"the lens shows nothing at all within the image: look at cx, cy and its coefficients"};
  const glm::dvec2 size = seen.high - seen.low;
  const glm::dvec2 focal(intrinsics.fx_px, intrinsics.fy_px);
  const glm::dvec2 wanted = kPixelsForOne * seen.most_enlarged * focal * size;  // pixels
  // One more pixel on each side for bilinear filtering.
  const double room = static_cast<double>(most_side) - 4;
  const double share = std::min({1.0, room / std::max(wanted.x, 1.0), room / std::max(wanted.y, 1.0)});
  if (!(kPixelsForOne * share >= kMinPixelsForOne))
    return Error{
        "the lens shows too wide a view: an image of " + std::to_string(most_side) +
        " pixels would not hold it finely enough; ask for a smaller image, or for one that ends sooner"};
  Intrinsics pinhole = intrinsics;
  const glm::dvec2 used = share * kPixelsForOne * seen.most_enlarged * focal;
  pinhole.fx_px = static_cast<float>(used.x);
  pinhole.fy_px = static_cast<float>(used.y);
  pinhole.cx_px = static_cast<float>(1 - used.x * seen.low.x);
  pinhole.cy_px = static_cast<float>(1 - used.y * seen.low.y);
  const glm::dvec2 pixels = glm::ceil(used * size) + 3.0;
  if (!(pixels.x <= most_side && pixels.y <= most_side))
    return Error{"the lens has coefficients that no camera has; give them as OpenCV calibrates them"};
  pinhole.image_px = glm::uvec2(pixels);
  if (Result<void> good = check(pinhole); !good) return good.error();
  return pinhole;
}

}  // namespace fire3dv::passes
