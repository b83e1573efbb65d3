#include "convert/mesh/geometry/triangulate.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "base/plural.h"
#include "convert/mesh/geometry/sweep_triangulation.h"

namespace fire3dv::convert {
namespace {

// Corners that are compared in all polygons of one triangulator by ear clipping, and in one polygon. Larger
// polygons are swept, whose time is O(n log n) whatever their shape.
constexpr uint64_t kMaxSteps = 500'000'000;
constexpr uint64_t kMaxStepsOfPolygon = 1'000'000, kMaxStepsOfCorner = 128;

// Order of two points along the x axis, and along y where x is equal.
bool is_rightward(const glm::dvec2& from, const glm::dvec2& to) {
  return to.x != from.x ? to.x > from.x : to.y > from.y;
}

}  // namespace

const std::vector<PolygonTriangulator::Triangle>& PolygonTriangulator::triangulate(
    std::span<const glm::dvec3> corners) {
  const bool is_exact = cut(corners);
  double area = 0;
  bool has_area = false;
  for (const Triangle& t : triangles_) {
    const glm::dvec3 a = corners[t[1]] - corners[t[0]], b = corners[t[2]] - corners[t[0]];
    const double one = glm::length(glm::cross(a, b));
    area += std::isfinite(one) ? one : 0;
    has_area = has_area || one > 1e-6 * glm::length(a) * glm::length(b);
  }
  area_ += area;
  if (!is_exact && has_area) {
    ++approximated_;
    approximated_area_ += area;
  }
  return triangles_;
}

// Returns whether the triangles are exactly the polygon.
bool PolygonTriangulator::cut(std::span<const glm::dvec3> corners) {
  triangles_.clear();
  const auto count = static_cast<uint32_t>(corners.size());
  if (count < 3) return true;
  // Without a plane all corners lie on a line, or halves cancel each other.
  const bool has_plane = count == 3 || project(corners);
  if (count == 3 || !has_plane || is_convex()) {
    for (uint32_t i = 2; i < count; ++i) triangles_.push_back({0, i - 1, i});
    return has_plane;
  }
  const double area = doubled_area();
  const size_t steps = kMaxStepsOfPolygon + kMaxStepsOfCorner * points_.size();
  const bool is_whole = clip(std::min<uint64_t>(steps_ + steps, kMaxSteps));
  if (!is_whole && sweep(area)) return true;
  if (!is_whole) fan();
  return std::abs(clipped_area_ - area) <= 1e-3 * area && turns_once();
}

std::string PolygonTriangulator::warning() const {
  // Folded slivers, as many meshes have them, are not seen.
  constexpr double kSeen = 1e-3;
  if (approximated_ == 0 || approximated_area_ < kSeen * area_) return {};
  const bool is_one = approximated_ == 1;
  return counted(approximated_, "polygon") +
         (is_one ? " crosses itself, or is" : " cross themselves, or are") +
         " too large to be cut: the triangles may differ from those of other programs";
}

// Projects along the largest axis of Newell's normal, which keeps coordinates as they are in the file.
// Returns false for a polygon without an area.
bool PolygonTriangulator::project(std::span<const glm::dvec3> corners) {
  glm::dvec3 normal(0);
  for (size_t i = 2; i < corners.size(); ++i)
    normal += glm::cross(corners[i - 1] - corners[0], corners[i] - corners[0]);
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(normal[i]) > std::abs(normal[axis])) axis = i;
  if (!(std::abs(normal[axis]) > 0) || !std::isfinite(normal.x + normal.y + normal.z)) return false;
  int u = (axis + 1) % 3, v = (axis + 2) % 3;
  if (normal[axis] < 0) std::swap(u, v);
  points_.clear();
  corners_.clear();
  for (size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec2 point(corners[i][u], corners[i][v]);
    if (!points_.empty() && point == points_.back()) continue;
    points_.push_back(point);
    corners_.push_back(static_cast<uint32_t>(i));
  }
  while (points_.size() > 1 && points_.back() == points_.front()) {
    points_.pop_back();
    corners_.pop_back();
  }
  if (points_.size() < 3) return false;
  // Rows of corners lie along the longer side.
  glm::dvec2 low = points_[0], high = points_[0];
  for (const glm::dvec2& point : points_) {
    low = glm::min(low, point);
    high = glm::max(high, point);
  }
  if (high.y - low.y > high.x - low.x)
    for (glm::dvec2& point : points_) point = {point.y, -point.x};
  return true;
}

// All corners turn left, around the polygon once.
bool PolygonTriangulator::is_convex() const {
  const size_t count = points_.size();
  size_t reversals = 0;
  for (size_t i = 0; i < count; ++i) {
    const glm::dvec2 &a = points_[i], &b = points_[(i + 1) % count], &c = points_[(i + 2) % count];
    if (doubled_area_of(a, b, c) < 0) return false;
    if (is_rightward(a, b) != is_rightward(b, c)) ++reversals;
  }
  return reversals <= 2;
}

// A polygon that does not cross itself turns by 360 degrees in sum. True where edges fold back exactly, since
// their angle has no sign.
bool PolygonTriangulator::turns_once() const {
  const size_t count = points_.size();
  double sum = 0;
  for (size_t i = 0; i < count; ++i) {
    const glm::dvec2 a = points_[(i + 1) % count] - points_[i];
    const glm::dvec2 b = points_[(i + 2) % count] - points_[(i + 1) % count];
    const double sine = doubled_area_of(points_[i], points_[(i + 1) % count], points_[(i + 2) % count]);
    const double cosine = glm::dot(a, b);
    if (sine == 0 && cosine < 0) return true;
    sum += std::atan2(sine, cosine);
  }
  return std::abs(sum - 2 * std::numbers::pi) < 1;
}

double PolygonTriangulator::doubled_area() const {
  double sum = 0;
  for (size_t i = 2; i < points_.size(); ++i) {
    const glm::dvec2 a = points_[i - 1] - points_[0], b = points_[i] - points_[0];
    sum += a.x * b.y - a.y * b.x;
  }
  return sum;
}

double PolygonTriangulator::turn(uint32_t a, uint32_t b, uint32_t c) const {
  return doubled_area_of(points_[a], points_[b], points_[c]);
}

void PolygonTriangulator::add(uint32_t a, uint32_t b, uint32_t c) {
  triangles_.push_back({corners_[a], corners_[b], corners_[c]});
  clipped_area_ += std::abs(turn(a, b, c));
}

void PolygonTriangulator::remove(uint32_t node) {
  const uint32_t before = previous_[node], after = next_[node];
  next_[before] = after;
  previous_[after] = before;
  const auto forget = [&](uint32_t each) {
    reflex_left_ -= is_reflex_[each];
    is_reflex_[each] = 0;
  };
  forget(node);
  for (const uint32_t each : {before, after})
    if (turn(previous_[each], each, next_[each]) > 0) forget(each);
  --left_;
  constexpr size_t kFewNodes = 64;
  if (row_nodes_.size() > kFewNodes && reflex_left_ < row_nodes_.size() / 2) build_rows();
}

// Removes corners on the line through their neighbours. Returns whether there were any; node stays in the
// list.
bool PolygonTriangulator::remove_flat(uint32_t& node) {
  bool any = false;
  for (size_t i = left_; i > 0 && left_ > 3; --i) {
    ++steps_;
    const uint32_t here = node;
    node = next_[node];
    if (turn(previous_[here], here, node) != 0) continue;
    remove(here);
    any = true;
  }
  return any;
}

size_t PolygonTriangulator::row_of(double y) const {
  const double row = (y - low_y_) * rows_per_unit_;
  return row > 0 ? static_cast<size_t>(std::min(row, static_cast<double>(row_count() - 1))) : 0;
}

// Sorts the corners that are left and not convex by rows, and along each row.
void PolygonTriangulator::build_rows() {
  row_nodes_.clear();
  low_y_ = INFINITY;
  high_y_ = -INFINITY;
  for (uint32_t i = 0; i < points_.size(); ++i) {
    if (!is_reflex_[i]) continue;
    row_nodes_.push_back(i);
    low_y_ = std::min(low_y_, points_[i].y);
    high_y_ = std::max(high_y_, points_[i].y);
  }
  reflex_left_ = row_nodes_.size();
  constexpr size_t kFewNodes = 16;
  const size_t rows = reflex_left_ <= kFewNodes || !(high_y_ > low_y_)
                          ? 1
                          : static_cast<size_t>(std::sqrt(static_cast<double>(reflex_left_)));
  rows_per_unit_ = rows > 1 ? static_cast<double>(rows) / (high_y_ - low_y_) : 0;
  row_starts_.assign(rows + 1, 0);
  for (const uint32_t node : row_nodes_) ++row_starts_[row_of(points_[node].y) + 1];
  for (size_t row = 0; row < rows; ++row) row_starts_[row + 1] += row_starts_[row];
  std::sort(row_nodes_.begin(), row_nodes_.end(), [&](uint32_t a, uint32_t b) {
    const size_t row_a = row_of(points_[a].y), row_b = row_of(points_[b].y);
    return row_a != row_b ? row_a < row_b : points_[a].x < points_[b].x;
  });
}

// From the lowest to the highest x of the triangle in a row.
std::pair<double, double> PolygonTriangulator::range_in_row(const Triangle& triangle, size_t row) const {
  // Wider than the row, so that rounding leaves nothing out.
  constexpr double kMore = 1e-6;
  const double height = rows_per_unit_ > 0 ? 1 / rows_per_unit_ : 0;
  const double low = low_y_ + std::max(0.0, static_cast<double>(row) - kMore) * height;
  const double high =
      row + 1 == row_count() ? high_y_ : low_y_ + (static_cast<double>(row) + 1 + kMore) * height;
  double left = INFINITY, right = -INFINITY;
  for (size_t edge = 0; edge < 3; ++edge) {
    glm::dvec2 a = points_[triangle[edge]], b = points_[triangle[(edge + 1) % 3]];
    if (a.y > b.y) std::swap(a, b);
    if (b.y < low || a.y > high) continue;
    const auto x_at = [&](double y) { return a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x); };
    const double first = a.y < low ? x_at(low) : a.x, last = b.y > high ? x_at(high) : b.x;
    left = std::min({left, first, last});
    right = std::max({right, first, last});
  }
  const auto [least, most] =
      std::minmax({points_[triangle[0]].x, points_[triangle[1]].x, points_[triangle[2]].x});
  const double more = kMore * (right - left) + 1e-9 * (most - least);
  return {left - more, right + more};
}

// True if the polygon enters the triangle. Corners may touch it: those of the edge to a hole are doubled.
bool PolygonTriangulator::is_blocked(uint32_t before, uint32_t tip, uint32_t after, Touch touch) {
  const std::array<uint32_t, 3> triangle = {before, tip, after};
  const auto edge_area = [&](size_t edge, uint32_t node) {
    return turn(triangle[edge], triangle[(edge + 1) % 3], node);
  };
  const auto [lowest, highest] = std::minmax({points_[before].y, points_[tip].y, points_[after].y});
  const size_t last_row = row_of(highest);
  for (size_t row = row_of(lowest); row <= last_row; ++row) {
    constexpr uint64_t kStepsOfRow = 8;
    steps_ += kStepsOfRow;
    const auto begin = row_nodes_.begin() + row_starts_[row], end = row_nodes_.begin() + row_starts_[row + 1];
    if (begin == end) continue;
    const auto [left, right] = range_in_row(triangle, row);
    const auto is_left = [&](uint32_t node, double x) { return points_[node].x < x; };
    for (auto at = std::lower_bound(begin, end, left, is_left); at != end && points_[*at].x <= right; ++at) {
      const uint32_t node = *at;
      ++steps_;
      if (!is_reflex_[node] || node == before || node == tip || node == after) continue;
      const double areas[] = {edge_area(0, node), edge_area(1, node), edge_area(2, node)};
      if (areas[0] < 0 || areas[1] < 0 || areas[2] < 0) continue;
      if (touch == Touch::avoid && areas[0] > 0 && areas[1] > 0) return true;
      const auto enters = [&](uint32_t neighbour) {
        for (size_t edge = 0; edge < 3; ++edge)
          if (areas[edge] == 0 && edge_area(edge, neighbour) <= 0) return false;
        return true;
      };
      if (enters(previous_[node]) || enters(next_[node])) return true;
    }
  }
  return false;
}

// Returns false, with some corners left, after max_steps.
bool PolygonTriangulator::clip(uint64_t max_steps) {
  const auto count = static_cast<uint32_t>(points_.size());
  previous_.resize(count);
  next_.resize(count);
  for (uint32_t i = 0; i < count; ++i) {
    previous_[i] = i == 0 ? count - 1 : i - 1;
    next_[i] = i + 1 == count ? 0 : i + 1;
  }
  left_ = count;
  clipped_area_ = 0;
  is_reflex_.resize(count);
  for (uint32_t i = 0; i < count; ++i) is_reflex_[i] = turn(previous_[i], i, next_[i]) <= 0;
  build_rows();
  uint32_t node = 0;
  first_left_ = 0;
  for (size_t misses = 0; left_ > 3; first_left_ = node) {
    if (steps_ >= max_steps) return false;
    const uint32_t before = previous_[node], after = next_[node];
    ++steps_;
    const bool is_convex = turn(before, node, after) > 0;
    // First ears without a corner on their third edge, which other triangles end at. Without any ear the
    // polygon crosses itself: a convex corner is cut off whatever is in it.
    const Touch touch = misses <= left_ ? Touch::avoid : Touch::accept;
    if (is_convex && (misses > 2 * left_ || !is_blocked(before, node, after, touch))) {
      add(before, node, after);
      remove(node);
      node = before;  // the only corners that may have become ears are its neighbours
      misses = 0;
      continue;
    }
    node = after;
    ++misses;
    if (misses == 2 * left_ && remove_flat(node)) misses = 0;
    if (misses > 3 * left_ + 2) return true;  // no corner is convex
  }
  fan();
  return true;
}

// Cuts the corners that are left into a fan.
void PolygonTriangulator::fan() {
  const uint32_t first = first_left_;
  for (uint32_t a = next_[first], b = next_[a]; b != first; a = b, b = next_[b])
    if (left_ > 3 || turn(first, a, b) > 0) add(first, a, b);
}

// Replaces the triangles if they cover the polygon exactly.
bool PolygonTriangulator::sweep(double area) {
  const std::optional<std::vector<Triangle>> swept = SweepTriangulation::cut(points_);
  if (!swept) return false;
  double swept_area = 0;
  for (const Triangle& t : *swept) swept_area += std::abs(turn(t[0], t[1], t[2]));
  if (!(std::abs(swept_area - area) <= 1e-9 * area)) return false;
  triangles_.clear();
  for (const Triangle& t : *swept) triangles_.push_back({corners_[t[0]], corners_[t[1]], corners_[t[2]]});
  return true;
}

}  // namespace fire3dv::convert
