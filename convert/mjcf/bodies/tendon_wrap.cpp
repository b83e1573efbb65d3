#include "convert/mjcf/bodies/tendon_wrap.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fire3dv::convert {
namespace {

constexpr double kMin = 1e-15;

double cross(const glm::dvec2& a, const glm::dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

glm::dvec2 rotated(const glm::dvec2& v, double cosine, double sine) {
  return {cosine * v.x - sine * v.y, sine * v.x + cosine * v.y};
}

bool segments_cross(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d) {
  const double determinant = cross(b - a, d - c);
  if (std::abs(determinant) < kMin) return false;
  const double along_first = cross(c - a, d - c) / determinant,
               along_second = cross(c - a, b - a) / determinant;
  return along_first >= 0 && along_first <= 1 && along_second >= 0 && along_second <= 1;
}

// Contact of a path with a circle around the origin, and its length along the circle.
struct Contact {
  glm::dvec2 first, last;
  double arc = 0;
};

// Nearest point of a segment to the origin.
glm::dvec2 nearest(const glm::dvec2& from, const glm::dvec2& to) {
  const glm::dvec2 way = to - from;
  return from + way * std::clamp(-glm::dot(way, from) / glm::dot(way, way), 0.0, 1.0);
}

std::optional<Contact> wrap_outside(const glm::dvec2& from, const glm::dvec2& to, double radius,
                                    const std::optional<glm::dvec2>& side) {
  const double from_distance = glm::length(from), to_distance = glm::length(to);
  if (from_distance < radius || to_distance < radius || radius < kMin) return std::nullopt;
  if (glm::dot(to - from, to - from) < kMin) return std::nullopt;
  const glm::dvec2 middle = nearest(from, to);
  if (glm::length(middle) > radius && (!side || glm::dot(*side, middle) >= 0)) return std::nullopt;

  // Tangent points lie at the angle acos(radius / distance) from the direction of an end.
  const auto tangent = [&](const glm::dvec2& end, double distance, double turn) {
    const double cosine = radius / distance, sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    return rotated(end * (radius / distance), cosine, turn * sine);
  };
  std::optional<Contact> best;
  double best_score = 0;
  for (const double turn : {-1.0, 1.0}) {  // clockwise, then counter-clockwise
    Contact made{tangent(from, from_distance, turn), tangent(to, to_distance, -turn)};
    double score = -glm::dot(made.first - made.last, made.first - made.last);
    if (side) {
      const glm::dvec2 sum = made.first + made.last;
      score = glm::length(sum) > kMin ? glm::dot(glm::normalize(sum), *side) : side->x;
    }
    if (segments_cross(from, made.first, to, made.last)) score = -10000;
    const double angle =
        std::acos(std::clamp(glm::dot(made.first, made.last) / (radius * radius), -1.0, 1.0));
    const bool is_long = turn * cross(made.first, made.last) < 0;
    made.arc = radius * (is_long ? 2 * std::numbers::pi - angle : angle);
    if (best && score <= best_score) {
      if (score == best_score) best = made;
      continue;
    }
    best = made;
    best_score = score;
  }
  if (segments_cross(from, best->first, to, best->last)) return std::nullopt;
  return best;
}

// Path that touches a circle from inside at the point where it makes equal angles with both parts.
std::optional<Contact> wrap_inside(const glm::dvec2& from, const glm::dvec2& to, double radius) {
  const double from_distance = glm::length(from), to_distance = glm::length(to);
  if (from_distance <= radius || to_distance <= radius || radius < kMin) return std::nullopt;
  const glm::dvec2 way = to - from;
  if (glm::dot(way, way) > kMin) {
    const double share = -glm::dot(way, from) / glm::dot(way, way);
    if (share > 0 && share < 1 && glm::length(from + share * way) <= radius) return std::nullopt;
  }
  const glm::dvec2 sum = from + to;
  const glm::dvec2 halfway = radius * (glm::length(sum) > kMin ? glm::normalize(sum) : glm::dvec2(1, 0));
  const double a = radius / from_distance, b = radius / to_distance;
  const double cosine = glm::dot(from, to) / (from_distance * to_distance);
  if (cosine < -1 + kMin) return std::nullopt;
  if (cosine > 1 - kMin) return Contact{halfway, halfway};
  const double angle = std::acos(cosine);
  const auto excess = [&](double z) {
    return std::asin(a * z) + std::asin(b * z) - 2 * std::asin(z) + angle;
  };
  double low = 0, high = 1 - 1e-7;
  if (excess(high) > 0) return Contact{halfway, halfway};
  for (int i = 0; i < 100; ++i) {
    const double z = 0.5 * (low + high);
    (excess(z) > 0 ? low : high) = z;
  }
  const bool starts = cross(from, to) > 0;
  const double turn = std::asin(low) - std::asin((starts ? a : b) * low);
  const glm::dvec2 point =
      rotated(radius * glm::normalize(starts ? from : to), std::cos(turn), std::sin(turn));
  return Contact{point, point};
}

}  // namespace

std::optional<std::pair<glm::dvec3, glm::dvec3>> wrap_tendon(const glm::dvec3& from, const glm::dvec3& to,
                                                             const MjcfPose& pose, double radius,
                                                             bool is_sphere,
                                                             const std::optional<glm::dvec3>& side) {
  const glm::dquat to_local = glm::conjugate(pose.rotation);
  const auto local = [&](const glm::dvec3& point) { return to_local * (point - pose.position); };
  const glm::dvec3 first = local(from), last = local(to);
  if (glm::length(first) < kMin || glm::length(last) < kMin) return std::nullopt;
  glm::dvec3 x(1, 0, 0), y(0, 1, 0);
  if (is_sphere) {  // the path lies in the plane of both points and the centre
    x = glm::normalize(first);
    glm::dvec3 normal = glm::cross(first, last);
    if (glm::length(normal) < kMin) {
      glm::dvec3 other(1);
      int largest = 0;
      for (int i = 1; i < 3; ++i)
        if (std::abs(x[i]) > std::abs(x[largest])) largest = i;
      other[largest] = 0;
      normal = glm::cross(x, other);
    }
    y = glm::normalize(glm::cross(glm::normalize(normal), x));
  }
  const auto flat = [&](const glm::dvec3& point) {
    return glm::dvec2(glm::dot(point, x), glm::dot(point, y));
  };
  std::optional<Contact> contact;
  if (side && glm::length(local(*side)) < radius) {
    contact = wrap_inside(flat(first), flat(last), radius);
  } else {
    std::optional<glm::dvec2> side_point;
    if (side) {
      const glm::dvec2 projected = flat(local(*side));
      side_point = radius * (glm::length(projected) > kMin ? glm::normalize(projected) : glm::dvec2(1, 0));
    }
    contact = wrap_outside(flat(first), flat(last), radius, side_point);
  }
  if (!contact) return std::nullopt;
  glm::dvec3 touches = contact->first.x * x + contact->first.y * y;
  glm::dvec3 leaves = contact->last.x * x + contact->last.y * y;
  if (!is_sphere) {  // the height changes evenly along the path
    const double before = glm::distance(flat(first), contact->first);
    const double after = glm::distance(flat(last), contact->last);
    const double whole = before + contact->arc + after;
    if (whole > 0) {
      touches.z = glm::mix(first.z, last.z, before / whole);
      leaves.z = glm::mix(first.z, last.z, (before + contact->arc) / whole);
    }
  }
  return std::pair(pose * touches, pose * leaves);
}

}  // namespace fire3dv::convert
