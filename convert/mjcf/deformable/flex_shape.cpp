#include "convert/mjcf/deformable/flex_shape.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "base/text.h"
#include "convert/mjcf/xml/mjcf_attributes.h"
#include "convert/surfaces.h"

namespace fire3dv::convert {
namespace {

constexpr int64_t kMaxFlexPoints = 250'000;

class GridBuilder {
 public:
  GridBuilder(const FlexGrid& grid, int dimension) : grid_(grid), n_(grid.count) {
    shape_.dimension = dimension;
    for (int k = 0; k < 3; ++k) half_[k] = 0.5 * grid.spacing[k] * (n_[static_cast<size_t>(k)] - 1);
  }

  FlexShape line() {
    for (int i = 0; i < n_[0]; ++i) add_point(at(i, 0, 0), share(i, 0), 0);
    for (uint32_t i = 0; i + 1 < count(0); ++i) shape_.elements.insert(shape_.elements.end(), {i, i + 1});
    return take();
  }

  // Regular polygon; its last point is its first.
  FlexShape circle() {
    const uint32_t corners = count(0) - 1;
    const double angle = 2 * std::numbers::pi / corners, radius = grid_.spacing.x / std::sin(angle / 2) / 2;
    for (uint32_t i = 0; i < corners; ++i) {
      add_point({radius * std::cos(angle * i), radius * std::sin(angle * i), 0}, 0, 0);
      shape_.elements.insert(shape_.elements.end(), {i, (i + 1) % corners});
    }
    return take();
  }

  FlexShape sheet(bool is_disc) {
    for (int x = 0; x < n_[0]; ++x)
      for (int y = 0; y < n_[1]; ++y) add_point(sheet_point(x, y, is_disc), share(x, 0), share(y, 1));
    for (int x = 0; x + 1 < n_[0]; ++x)
      for (int y = 0; y + 1 < n_[1]; ++y) {
        const auto id = [&](int i, int k) { return static_cast<uint32_t>((x + i) * n_[1] + y + k); };
        // Diagonals of a disc point outwards.
        const glm::dvec3 corner = at(x, y, 0);
        const bool is_left = corner.x < -1e-14, is_right = !is_left, is_low = corner.y < -1e-14;
        if (is_disc && ((is_left && !is_low) || (is_right && is_low)))
          add_triangles({id(0, 0), id(1, 0), id(0, 1), id(1, 0), id(1, 1), id(0, 1)});
        else
          add_triangles({id(0, 0), id(1, 0), id(1, 1), id(0, 0), id(1, 1), id(0, 1)});
      }
    return take();
  }

  FlexShape block() {
    for (int x = 0; x < n_[0]; ++x)
      for (int y = 0; y < n_[1]; ++y)
        for (int z = 0; z < n_[2]; ++z) add_point(at(x, y, z), share(x, 0), share(y, 1));
    const uint32_t step[] = {count(1) * count(2), count(2), 1};
    constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    for (uint32_t x = 0; x + 1 < count(0); ++x)
      for (uint32_t y = 0; y + 1 < count(1); ++y)
        for (uint32_t z = 0; z + 1 < count(2); ++z)
          for (const auto& order : kOrders) {  // from one corner of the cell along its edges to the opposite
            uint32_t corner = x * step[0] + y * step[1] + z;
            shape_.elements.push_back(corner);
            for (const int axis : order) shape_.elements.push_back(corner += step[axis]);
          }
    return take();
  }

  // Surface of a box or of a shape that it is projected to; with a point at the centre for tetrahedra.
  FlexShape shell() {
    if (shape_.dimension == 3) add_point(glm::dvec3(0), 0, 0);
    const int x_end = n_[0] - 1, y_end = n_[1] - 1, z_end = n_[2] - 1;
    for (const int z : {0, z_end})
      for (int x = 0; x <= x_end; ++x)
        for (int y = 0; y <= y_end; ++y) add_shell_point(x, y, z, share(x, 0), share(y, 1));
    for (const int y : {0, y_end})
      for (int x = 0; x <= x_end; ++x)
        for (int z = 1; z < z_end; ++z) add_shell_point(x, y, z, share(x, 0), share(z, 2));
    for (const int x : {0, x_end})
      for (int y = 1; y < y_end; ++y)
        for (int z = 1; z < z_end; ++z) add_shell_point(x, y, z, share(y, 1), share(z, 2));
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {0, n_[static_cast<size_t>(axis)] - 1}) add_side(axis, side);
    return take();
  }

 private:
  uint32_t count(size_t axis) const { return static_cast<uint32_t>(n_[axis]); }
  float share(int i, size_t axis) const {
    return static_cast<float>(i) / static_cast<float>(std::max(n_[axis] - 1, 1));
  }
  glm::dvec3 at(int x, int y, int z) const {
    return grid_.spacing * (glm::dvec3(x, y, z) - 0.5 * (glm::dvec3(n_[0], n_[1], n_[2]) - 1.0)) *
           glm::dvec3(1, shape_.dimension > 1, shape_.dimension > 2);
  }

  glm::dvec3 sheet_point(int x, int y, bool is_disc) const {
    const glm::dvec3 point = at(x, y, 0);
    if (!is_disc) return point;
    // MuJoCo multiplies the distance from the centre with the half size.
    const double distance = std::max(std::abs(point.x), std::abs(point.y));
    return direction(point) * distance * glm::dvec3(half_.x, half_.y, 0);
  }

  static glm::dvec3 direction(const glm::dvec3& v) {
    const double length = glm::length(v);
    return length > 1e-15 ? v / length : glm::dvec3(1, 0, 0);
  }

  void add_shell_point(int x, int y, int z, float u, float v) {
    const glm::dvec3 exact = 2.0 * glm::dvec3(x, y, z) / (glm::dvec3(n_[0], n_[1], n_[2]) - 1.0) - 1.0;
    glm::dvec3 point = exact;
    if (grid_.type == "cylinder") {
      const double distance = std::max(std::abs(exact.x), std::abs(exact.y));
      point = glm::dvec3(glm::dvec2(direction(glm::dvec3(exact.x, exact.y, 0))) * distance, exact.z);
    } else if (grid_.type == "ellipsoid") {
      point = direction(exact);
    }
    shell_[{x, y, z}] = static_cast<uint32_t>(shape_.points.size());
    add_point(point * half_, u, v);
  }

  void add_side(int axis, int side) {
    const size_t a = static_cast<size_t>(axis + 1) % 3, b = static_cast<size_t>(axis + 2) % 3;
    for (int i = 0; i + 1 < n_[a]; ++i)
      for (int k = 0; k + 1 < n_[b]; ++k) {
        const auto id = [&](int di, int dk) {
          std::array<int, 3> cell{};
          cell[static_cast<size_t>(axis)] = side;
          cell[a] = i + di;
          cell[b] = k + dk;
          return shell_.at(cell);
        };
        const bool is_upper = side > 0;
        const uint32_t first = id(is_upper, !is_upper), last = id(!is_upper, is_upper);
        add_triangles({id(0, 0), first, id(1, 1), id(0, 0), id(1, 1), last});
      }
  }

  void add_triangles(const std::array<uint32_t, 6>& corners) {
    for (size_t i = 0; i < 6; ++i) {
      if (shape_.dimension == 3 && i % 3 == 0) shape_.elements.push_back(0);
      shape_.elements.push_back(corners[i]);
    }
  }

  void add_point(const glm::dvec3& point, float u, float v) {
    shape_.points.push_back(point);
    shape_.uvs.emplace_back(u, v);
  }

  FlexShape take() {
    shape_.uv_elements = shape_.elements;
    return std::move(shape_);
  }

  const FlexGrid& grid_;
  const std::array<int, 3> n_;
  glm::dvec3 half_{0};
  FlexShape shape_;
  std::map<std::array<int, 3>, uint32_t> shell_;
};

// Sides of tetrahedra that belong to one of them only, seen from outside.
std::vector<std::array<size_t, 3>> outer_sides(const FlexShape& shape) {
  std::map<std::array<uint32_t, 3>, std::pair<int, std::array<size_t, 3>>> sides;
  for (size_t e = 0; e + 4 <= shape.elements.size(); e += 4)
    for (size_t k = 0; k < 4; ++k) {
      std::array<size_t, 3> corners{e + (k + 1) % 4, e + (k + 2) % 4, e + (k + 3) % 4};
      const auto point = [&](size_t corner) { return shape.points[shape.elements[corner]]; };
      const glm::dvec3 a = point(corners[0]);
      const glm::dvec3 normal = glm::cross(point(corners[1]) - a, point(corners[2]) - a);
      if (glm::dot(normal, point(e + k) - a) > 0) std::swap(corners[1], corners[2]);
      std::array<uint32_t, 3> key;
      for (size_t i = 0; i < 3; ++i) key[i] = shape.elements[corners[i]];
      std::sort(key.begin(), key.end());
      auto& [uses, first] = sides.try_emplace(key, 0, corners).first->second;
      ++uses;
    }
  std::vector<std::array<size_t, 3>> outer;
  for (const auto& [key, side] : sides)
    if (side.first == 1) outer.push_back(side.second);
  return outer;
}

void add_capsule(const FlexShape& shape, size_t element, double radius, FlexSurface& to) {
  const uint32_t ends[] = {shape.elements[element], shape.elements[element + 1]};
  const glm::dvec3 from = shape.points[ends[0]], way = shape.points[ends[1]] - from;
  const glm::dquat rotation = mjcf_z_rotation(way).value_or(glm::dquat(1, 0, 0, 0));
  const Surface shown = capsule(radius, glm::length(way) / 2);
  const auto first = static_cast<uint32_t>(to.points.size());
  for (const glm::vec3& position : shown.positions) {
    to.surface.positions.emplace_back(from + way / 2.0 + rotation * glm::dvec3(position));
    to.points.push_back(ends[position.z > 0]);
  }
  for (const uint32_t index : shown.indices) to.surface.indices.push_back(first + index);
}

}  // namespace

Result<FlexShape> flex_grid(const FlexGrid& grid, int dimension) {
  const std::string& type = grid.type;
  const bool is_shell = type == "box" || type == "cylinder" || type == "ellipsoid";
  const bool is_sheet = type == "square" || type == "disc";
  if (type != "grid" && type != "circle" && !is_shell && !is_sheet)
    return Error{"type=" + quote(type) + " is not supported"};
  if (type == "circle" && dimension != 1) return Error{"a circle needs dim=1"};
  if (is_shell && dimension < 2) return Error{"a " + type + " needs dim=2 or 3"};
  const int used = is_shell ? 3 : is_sheet ? 2 : dimension;
  int64_t points = 1, inside = 1;
  for (int k = 0; k < used; ++k) {
    const int count = grid.count[static_cast<size_t>(k)];
    if (count < (type == "circle" ? 4 : 2)) return Error{"count is too small in a direction"};
    if (count > kMaxFlexPoints || points > kMaxFlexPoints * 100) return Error{"count is too large"};
    if (!(grid.spacing[k] > 0 && grid.spacing[k] < 1e6)) return Error{"spacing is not positive"};
    points *= count;
    inside *= count - 2;
  }
  if ((is_shell ? points - inside : points) > kMaxFlexPoints)
    return Error{"it has more than " + std::to_string(kMaxFlexPoints) + " points"};
  GridBuilder builder(grid, is_sheet ? 2 : dimension);
  if (is_shell) return builder.shell();
  if (is_sheet) return builder.sheet(type == "disc");
  if (type == "circle") return builder.circle();
  return dimension == 1 ? builder.line() : dimension == 2 ? builder.sheet(false) : builder.block();
}

FlexSurface flex_surface(const FlexShape& shape, double radius, bool is_flat) {
  FlexSurface made;
  if (shape.dimension == 1) {
    for (size_t e = 0; e + 2 <= shape.elements.size(); e += 2) add_capsule(shape, e, radius, made);
    return made;
  }
  std::vector<std::array<size_t, 3>> triangles;  // corners of elements
  if (shape.dimension == 3)
    triangles = outer_sides(shape);
  else
    for (size_t e = 0; e + 3 <= shape.elements.size(); e += 3) triangles.push_back({e, e + 1, e + 2});
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> known;  // by point and texture coordinate
  const bool has_uvs = !shape.uv_elements.empty();
  for (const std::array<size_t, 3>& triangle : triangles)
    for (const size_t corner : triangle) {
      const uint32_t point = shape.elements[corner], uv = has_uvs ? shape.uv_elements[corner] : 0;
      const auto next = static_cast<uint32_t>(made.points.size());
      const auto [vertex, is_new] = known.try_emplace({point, uv}, next);
      if (is_new || is_flat) {
        made.points.push_back(point);
        made.surface.positions.emplace_back(shape.points[point]);
        if (has_uvs) made.surface.uvs.push_back(shape.uvs[uv]);
      }
      made.surface.indices.push_back(is_flat ? next : vertex->second);
    }
  return made;
}

}  // namespace fire3dv::convert
