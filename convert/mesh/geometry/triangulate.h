// Polygon triangulation in the polygon's plane, by ear clipping, and by a plane sweep where that would take
// long: O(n log n) in all. Concave polygons, and holes that a doubled edge joins to the outline, are exact.
// Polygons that cross themselves are approximated.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace fire3dv::convert {

class PolygonTriangulator {
 public:
  using Triangle = std::array<uint32_t, 3>;  // numbers of corners, in the order of the polygon

  // Convex polygons become the fan of their first corner. The result is valid until the next call; it is
  // empty for less than three corners.
  const std::vector<Triangle>& triangulate(std::span<const glm::dvec3> corners);

  // Warning about the polygons so far that were approximated; empty unless they have a thousandth of the area
  // of all.
  std::string warning() const;

 private:
  bool cut(std::span<const glm::dvec3> corners);
  bool project(std::span<const glm::dvec3> corners);
  bool is_convex() const;
  bool turns_once() const;
  double doubled_area() const;
  bool clip(uint64_t max_steps);
  void fan();
  bool sweep(double area);
  void build_rows();
  size_t row_count() const { return row_starts_.size() - 1; }
  size_t row_of(double y) const;
  std::pair<double, double> range_in_row(const Triangle& triangle, size_t row) const;
  // Whether corners may lie on the edge that cuts a triangle off.
  enum class Touch : uint8_t { avoid, accept };
  bool is_blocked(uint32_t before, uint32_t tip, uint32_t after, Touch touch);
  void remove(uint32_t node);
  bool remove_flat(uint32_t& node);
  void add(uint32_t a, uint32_t b, uint32_t c);
  double turn(uint32_t a, uint32_t b, uint32_t c) const;

  std::vector<Triangle> triangles_;
  // The polygon in its plane, counter-clockwise and without doubled neighbours.
  std::vector<glm::dvec2> points_;
  std::vector<uint32_t> corners_;  // of points_
  // Circular list of the corners that are left.
  std::vector<uint32_t> previous_, next_;
  size_t left_ = 0;
  uint32_t first_left_ = 0;  // one of them
  // Corners that are not convex, by rows along the longer side and their order in the row.
  std::vector<uint8_t> is_reflex_;
  std::vector<uint32_t> row_starts_, row_nodes_;
  size_t reflex_left_ = 0;
  double low_y_ = 0, high_y_ = 0, rows_per_unit_ = 0;
  double clipped_area_ = 0;
  uint64_t steps_ = 0;
  size_t approximated_ = 0;
  double area_ = 0, approximated_area_ = 0;  // doubled
};

}  // namespace fire3dv::convert
