// Holes of polygons: joins them to the outline by doubled edges (keyholes), as PolygonTriangulator takes
// them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace fire3dv::convert {

class HoleJoiner {
 public:
  using Ring = std::vector<glm::dvec3>;

  // rings: the outline, then the holes, in any direction. Returns one polygon: numbers of corners, counted
  // over all rings. Empty where no edge leads to a hole without crossing another one, such as for a hole
  // outside of the outline.
  std::vector<uint32_t> join(std::span<const Ring> rings);

 private:
  using Chain = std::vector<uint32_t>;  // closed

  bool project(std::span<const Ring> rings);
  double doubled_area(const Chain& chain) const;
  bool opens_to(const Chain& chain, size_t corner, const glm::dvec2& to) const;
  bool is_free(const glm::dvec2& from, const glm::dvec2& to, const Chain& chain);
  std::vector<uint32_t> join_by_sweep(const Chain& outline, const std::vector<Chain>& holes) const;
  bool add_hole(Chain& outline, const std::vector<Chain>& holes, size_t hole);

  std::vector<glm::dvec2> points_;  // of all rings, in their plane; the outline is counter-clockwise
  uint64_t steps_ = 0;
};

}  // namespace fire3dv::convert
