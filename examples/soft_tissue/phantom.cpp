#include "examples/soft_tissue/phantom.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace soft_tissue {
namespace {

constexpr float kHalfPi = 1.5707963f;
constexpr int kColumnsPerCell = 4;  // surface cells along a lattice cell
constexpr int kWallCells = 6;       // from the underside to the top of the cut's walls

// Half width and height of the section at s. The left lobe is smaller.
float half_width(float s) {
  return 0.062f * (1 - 0.22f * s) * std::sqrt(std::max(0.0f, 1 - std::pow(std::abs(s), 2.6f)));
}
float height(float s) {
  return 0.046f * (1 - 0.38f * s) * std::pow(std::max(0.0f, 1 - std::pow(std::abs(s), 3.0f)), 0.42f);
}

// w: 0 on the underside, 1 on the top.
Vec3 body_point(float s, float t, float w) {
  const float across = std::sin(t * kHalfPi);
  const float rise = std::abs(t) < 1 ? std::cos(t * kHalfPi) : 0;  // the rim is one line, to the bit
  const float x = 0.5f * kLength_m * s, z = 0.012f * s * s + half_width(s) * across;
  const float lumps =
      1 + 0.05f * std::sin(31 * x + 1.3f) * std::sin(47 * z) + 0.03f * std::sin(83 * x - 61 * z);
  const float top = height(s) * std::pow(rise, 0.8f) * lumps, bottom = -0.28f * height(s) * rise;
  return {x, 0.0115f + bottom + (top - bottom) * w, z};
}

// Springs and cells of a regular grid around the body.
class Grid {
 public:
  Grid(const Detail& detail, int cut) : detail_(detail), cells_along_(detail.along / kColumnsPerCell) {
    size_m_ = kLength_m / static_cast<float>(cells_along_);
    cut_cell_ = cells_along_ / 2;
    cut_end_z_ = cut > 0 ? cut_end(detail, static_cast<float>(cut)).z : 1e9f;
  }

  // side: 1 on the right of the cut.
  Anchor anchor(const Vec3& point, int side) {
    std::array<int, 3> cell = cell_of(point);
    cell[0] = side ? std::max(cell[0], cut_cell_) : cell[0];
    if (!side && point.x <= 1e-6f) cell[0] = std::min(cell[0], cut_cell_ - 1);
    add_cell(cell);
    Anchor anchor;
    const float of_point[] = {point.x - low(0), point.y - low(1), point.z - low(2)};
    for (size_t axis = 0; axis < 3; ++axis)
      anchor.place[axis] = of_point[axis] / size_m_ - static_cast<float>(cell[axis]);
    for (uint32_t corner = 0; corner < 8; ++corner) anchor.nodes[corner] = node(cell, corner);
    return anchor;
  }

  // Cells between those of the surface, so that the inside is full.
  void fill() {
    std::map<std::pair<int, int>, std::pair<int, int>> columns;
    for (const auto& cell : cells_) {
      const auto [found, is_new] = columns.try_emplace({cell[0], cell[2]}, cell[1], cell[1]);
      found->second = {std::min(found->second.first, cell[1]), std::max(found->second.second, cell[1])};
    }
    for (const auto& [column, range] : columns)
      for (int y = range.first; y <= range.second; ++y) add_cell({column.first, y, column.second});
  }

  Lattice lattice() {
    Lattice made;
    std::set<std::array<uint32_t, 2>> links;
    std::map<std::array<int, 2>, int> lowest;
    for (const auto& cell : cells_) {
      for (uint32_t a = 0; a < 8; ++a)
        for (uint32_t b = a + 1; b < 8; ++b) {
          const uint32_t first = node(cell, a), second = node(cell, b);
          links.insert({std::min(first, second), std::max(first, second)});
        }
      const auto [found, is_new] = lowest.try_emplace({cell[0], cell[2]}, cell[1]);
      found->second = std::min(found->second, cell[1]);
    }
    made.links.assign(links.begin(), links.end());
    made.keys = keys_;
    for (const auto& key : keys_) made.nodes.push_back(position(key));
    // It lies on its support along the spine, and hangs free at both rims.
    for (uint32_t i = 0; i < made.nodes.size(); ++i) {
      const auto column = lowest.find({std::min(keys_[i][0], cells_along_ - 1), keys_[i][2]});
      const bool is_low = column != lowest.end() && keys_[i][1] == column->second;
      if (is_low && made.nodes[i].z < 0.012f) made.held.push_back(i);
    }
    return made;
  }

 private:
  float low(int axis) const { return axis == 0 ? -0.5f * kLength_m : axis == 1 ? -0.02f : -0.1f; }
  Vec3 position(const std::array<int, 4>& key) const {
    const auto at = [&](int axis) {
      return low(axis) + size_m_ * static_cast<float>(key[static_cast<size_t>(axis)]);
    };
    return {at(0), at(1), at(2)};
  }
  std::array<int, 3> cell_of(const Vec3& point) const {
    const auto at = [&](float x, int axis) {
      return static_cast<int>(std::floor((x - low(axis)) / size_m_));
    };
    return {std::clamp(at(point.x, 0), 0, cells_along_ - 1), at(point.y, 1), at(point.z, 2)};
  }
  void add_cell(const std::array<int, 3>& cell) { cells_.insert(cell); }

  uint32_t node(const std::array<int, 3>& cell, uint32_t corner) {
    std::array<int, 4> key = {cell[0] + static_cast<int>(corner & 1),
                              cell[1] + static_cast<int>(corner >> 1 & 1),
                              cell[2] + static_cast<int>(corner >> 2), 0};
    const bool is_cut = key[0] == cut_cell_ && position(key).z > cut_end_z_ + 0.25f * size_m_;
    key[3] = is_cut && cell[0] >= cut_cell_ ? 1 : 0;
    const auto [found, is_new] = numbers_.try_emplace(key, static_cast<uint32_t>(keys_.size()));
    if (is_new) keys_.push_back(key);
    return found->second;
  }

  Detail detail_;
  int cells_along_ = 0, cut_cell_ = 0;
  float size_m_ = 0, cut_end_z_ = 0;
  std::set<std::array<int, 3>> cells_;
  std::map<std::array<int, 4>, uint32_t> numbers_;
  std::vector<std::array<int, 4>> keys_;
};

float s_of(const Detail& detail, int column) {
  return 2 * static_cast<float>(column) / static_cast<float>(detail.along) - 1;
}
float t_of(const Detail& detail, float row) {
  return 2 * row / static_cast<float>(detail.across) - 1;
}

class SurfaceBuilder {
 public:
  SurfaceBuilder(const Detail& detail, int cut, Grid& grid)
      : detail_(detail),
        first_split_row_(detail.across - max_cut(detail) + 1),
        first_cut_row_(detail.across - cut + 1),
        grid_(grid) {}

  Surface build() {
    for (const float w : {1.0f, 0.0f}) add_sheet(w);
    set_directions(surface_.outside);
    for (const int side : {0, 1}) add_wall(side);
    return std::move(surface_);
  }

 private:
  int middle() const { return detail_.along / 2; }
  bool is_split(int column, int row) const { return column == middle() && row >= first_split_row_; }

  // apart: vertices of another number have a normal of their own, even at the same place.
  void add_vertex(examples::Mesh& mesh, std::vector<Anchor>& anchors, const Vec3& point, int side, int apart,
                  float u, float v) {
    const auto number = static_cast<uint32_t>(groups_.size());
    surface_.normal_groups.push_back(
        groups_.try_emplace({point.x, point.y, point.z, static_cast<float>(apart)}, number).first->second);
    examples::Vertex vertex;
    vertex.position = point;
    vertex.u = u, vertex.v = v;
    mesh.vertices.push_back(vertex);
    anchors.push_back(grid_.anchor(point, side));
  }

  // The top or the underside. The rim belongs to both; its vertices have the same place and normal.
  void add_sheet(float w) {
    examples::Mesh& mesh = surface_.outside;
    std::map<std::array<int, 3>, uint32_t> numbers;
    const auto vertex = [&](int column, int row, bool right) {
      const int side = right && is_split(column, row) ? 1 : 0;
      const auto [found, is_new] =
          numbers.try_emplace({column, row, side}, static_cast<uint32_t>(mesh.vertices.size()));
      if (is_new) {
        const float s = s_of(detail_, column), t = t_of(detail_, static_cast<float>(row));
        const bool is_open = side == 1 && row >= first_cut_row_;
        add_vertex(mesh, surface_.outside_anchors, body_point(s, t, w), column > middle() ? 1 : side,
                   is_open ? 1 : 0, 3 * s, 2 * t + 7 * w);
      }
      return found->second;
    };
    for (int column = 0; column < detail_.along; ++column) {
      const bool right = column >= middle();
      for (int row = 0; row < detail_.across; ++row) {
        const uint32_t a = vertex(column, row, right), b = vertex(column + 1, row, right),
                       c = vertex(column + 1, row + 1, right), d = vertex(column, row + 1, right);
        if (w > 0) {
          mesh.indices.insert(mesh.indices.end(), {a, c, b, a, d, c});
        } else {
          mesh.indices.insert(mesh.indices.end(), {a, b, c, a, c, d});
        }
      }
    }
  }

  void add_wall(int side) {
    examples::Mesh& mesh = surface_.inside;
    const auto first = static_cast<uint32_t>(mesh.vertices.size());
    const int rows = max_cut(detail_);  // of cells, up to the rim
    for (int row = 0; row <= rows; ++row) {
      const float t = t_of(detail_, static_cast<float>(first_split_row_ - 1 + row));
      for (int i = 0; i <= kWallCells; ++i) {
        const float w = static_cast<float>(i) / kWallCells;
        add_vertex(mesh, surface_.inside_anchors, body_point(0, t, w), side, 2 + side, 4 * t, w);
        mesh.vertices.back().normal = {side ? -1.0f : 1.0f, 0, 0};
        mesh.vertices.back().tangent = {0, 0, 1};
      }
    }
    for (int row = 0; row < rows; ++row) {
      for (uint32_t i = 0; i < kWallCells; ++i) {
        const uint32_t a = first + static_cast<uint32_t>(row) * (kWallCells + 1) + i, b = a + 1,
                       d = a + kWallCells + 1, c = d + 1;
        if (side) {
          mesh.indices.insert(mesh.indices.end(), {a, d, c, a, c, b});
        } else {
          mesh.indices.insert(mesh.indices.end(), {a, c, d, a, b, c});
        }
      }
    }
  }

  // Normals by area, of vertices of one place; tangents along the length.
  static void set_directions(examples::Mesh& mesh) {
    std::map<std::array<float, 3>, Vec3> sums;
    const auto key = [&](uint32_t v) {
      const Vec3& p = mesh.vertices[v].position;
      return std::array{p.x, p.y, p.z};
    };
    for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
      const uint32_t* const t = &mesh.indices[i];
      const Vec3 a = mesh.vertices[t[0]].position;
      const Vec3 area = examples::cross(mesh.vertices[t[1]].position - a, mesh.vertices[t[2]].position - a);
      for (int k = 0; k < 3; ++k) sums[key(t[k])] = sums[key(t[k])] + area;
    }
    for (uint32_t v = 0; v < mesh.vertices.size(); ++v) {
      const Vec3 sum = sums[key(v)];
      examples::Vertex& vertex = mesh.vertices[v];
      vertex.normal = dot(sum, sum) > 0 ? normalized(sum) : Vec3{0, 1, 0};
      const Vec3 along = Vec3{1, 0, 0} - vertex.normal * vertex.normal.x;
      vertex.tangent = dot(along, along) > 1e-6f ? normalized(along) : Vec3{0, 0, 1};
    }
  }

  Detail detail_;
  int first_split_row_ = 0, first_cut_row_ = 0;
  Grid& grid_;
  Surface surface_;
  std::map<std::array<float, 4>, uint32_t> groups_;
};

}  // namespace

Phantom make_phantom(const Detail& detail, int cut) {
  Grid grid(detail, cut);
  Phantom phantom;
  phantom.surface = SurfaceBuilder(detail, cut, grid).build();
  grid.fill();
  phantom.lattice = grid.lattice();
  return phantom;
}

int max_cut(const Detail& detail) {
  return detail.across * 11 / 20;
}

Vec3 cut_end(const Detail& detail, float cut) {
  return body_point(0, t_of(detail, static_cast<float>(detail.across) - cut), 0.8f);
}

Vec3 top_point(float s, float t) {
  return body_point(s, t, 1);
}

}  // namespace soft_tissue
