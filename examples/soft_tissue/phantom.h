// Shape of a liver-like phantom: its surface, and a lattice of cells around it that is simulated. Metres, Y
// up.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "examples/common/mesh.h"

namespace soft_tissue {

using examples::Vec3;

// Cells of the surface; those of the lattice follow from them.
struct Detail {
  int along = 96;  // of its length, a multiple of 8
  int across = 48;
};

// Trilinear place in a lattice cell, and the offset from there at rest.
struct Anchor {
  std::array<uint32_t, 8> nodes{};
  std::array<float, 3> place{};  // 0 to 1 along x, y, z
};

// Nodes of the lattice, with those of the cut twice: one for each side.
struct Lattice {
  std::vector<Vec3> nodes;                     // rest positions
  std::vector<std::array<uint32_t, 2>> links;  // springs: edges and diagonals of the cells
  std::vector<uint32_t> held;                  // nodes of the underside that do not move
  std::vector<std::array<int, 4>> keys;  // of each node: its place in the grid, and 1 on the right of the cut
};

// The surface, with all vertices of the deepest cut: both sides of it have their own, and its walls lie on
// each other inside of the body until it opens. So the triangles never change.
struct Surface {
  examples::Mesh outside, inside;  // at rest; inside: the walls of the cut
  std::vector<Anchor> outside_anchors, inside_anchors;
  // Of each vertex, of outside and then of inside: those of one number share their normal.
  std::vector<uint32_t> normal_groups;
};

struct Phantom {
  Lattice lattice;
  Surface surface;
};

constexpr float kLength_m = 0.2f;

// cut: rows of surface cells that the cut is deep, from 0 to max_cut().
Phantom make_phantom(const Detail& detail, int cut);
int max_cut(const Detail& detail);
// A point of the cut's bottom, where the blade is. cut: may lie between two rows.
Vec3 cut_end(const Detail& detail, float cut);
// A point of the top. s along the length, t across it; both from -1 to 1.
Vec3 top_point(float s, float t);

}  // namespace soft_tissue
