// Triangulation of a polygon by a plane sweep, in O(n log n) for any shape: Hertel and Mehlhorn, "Fast
// triangulation of simple polygons", 1983. Each interior region to the right of the sweep line has a chain of
// corners that cannot be cut yet; each new corner cuts triangles off the ends of its chains.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <vector>

namespace fire3dv::convert {

// Twice the area of a triangle; 0 where rounding hides the sign.
double doubled_area_of(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c);

class SweepTriangulation {
 public:
  using Triangle = std::array<uint32_t, 3>;

  // points: counter-clockwise, without equal neighbours. Parts of the outline may touch each other, such as a
  // doubled edge to a hole. nullopt: the polygon crosses itself. One that
  // does may also have triangles of another area.
  static std::optional<std::vector<Triangle>> cut(std::span<const glm::dvec2> points);

  // Segment that crosses no edge, from a corner of a hole to one of the outline or of another hole, left of
  // it.
  struct Bridge {
    uint32_t corner = 0, other = 0;
  };
  // points: of the outline, counter-clockwise, then of the holes, clockwise. ring_ends: behind the last point
  // of each. One bridge for each hole; together they join all of them. nullopt: a ring crosses itself or
  // another one, or touches it, or a hole lies outside.
  static std::optional<std::vector<Bridge>> find_bridges(std::span<const glm::dvec2> points,
                                                         std::span<const uint32_t> ring_ends);

 private:
  static constexpr uint32_t kNone = UINT32_MAX;

  // Edge from one corner to the next; its index is that of its first corner. Left and right: in the order of
  // the sweep, along x and then y.
  struct Edge {
    uint32_t left = 0, right = 0;  // corners
    bool is_up = false;            // the interior is above
    uint32_t chain = kNone;        // of the region above, if it is interior
  };
  // Edges that cross the sweep line, from low to high: a treap whose nodes are also a linked list.
  class Status {
   public:
    explicit Status(size_t edges);
    uint32_t below(uint32_t edge) const { return nodes_[edge].below; }
    uint32_t above(uint32_t edge) const { return nodes_[edge].above; }
    // lower: kNone inserts the edge below all others.
    void insert_above(uint32_t lower, uint32_t edge);
    void erase(uint32_t edge);
    // The highest edge that `is_below` holds for, kNone if none. It holds for all edges up to one.
    template <typename IsBelow>
    uint32_t highest(const IsBelow& is_below) const {
      uint32_t best = kNone;
      for (uint32_t at = root_; at != kNone;) {
        if (is_below(at)) {
          best = at;
          at = nodes_[at].high;
        } else {
          at = nodes_[at].low;
        }
      }
      return best;
    }

   private:
    struct Node {
      uint32_t low = kNone, high = kNone, parent = kNone;  // tree
      uint32_t below = kNone, above = kNone;               // list
      uint32_t priority = 0;
    };
    void replace_child(uint32_t parent, uint32_t old_child, uint32_t child);
    void rotate_up(uint32_t node);

    std::vector<Node> nodes_;
    uint32_t root_ = kNone, lowest_ = kNone;
  };
  // Corners between the lower and the upper edge of a region, from low to high.
  struct Chain {
    uint32_t low = 0, high = 0, rightmost = 0;  // links
  };
  struct Link {
    uint32_t corner = 0;
    uint32_t below = kNone, above = kNone;
  };

  SweepTriangulation(std::span<const glm::dvec2> points, std::span<const uint32_t> ring_ends);
  bool sweep();
  bool sweep_location(std::span<const uint32_t> corners);
  bool find_left_edges(std::span<const uint32_t> corners);
  uint32_t find_below(const glm::dvec2& point) const;
  void sort_right_edges(std::span<const uint32_t> corners);
  bool alternate(uint32_t below);
  bool continue_regions(uint32_t below);
  bool merge_regions(uint32_t below);
  bool split_region(uint32_t below);
  bool is_before(uint32_t a, uint32_t b) const;
  double turn(uint32_t a, uint32_t b, uint32_t c) const {
    return doubled_area_of(points_[a], points_[b], points_[c]);
  }
  bool cut_tip(uint32_t a, uint32_t tip, uint32_t b);
  uint32_t add_link(uint32_t corner);
  uint32_t add_chain(uint32_t corner);
  void cut_low_end(Chain& chain, uint32_t corner);
  void cut_high_end(Chain& chain, uint32_t corner);
  void close(const Chain& chain, uint32_t corner);

  std::span<const glm::dvec2> points_;
  std::vector<Edge> edges_;
  std::vector<uint32_t> previous_;  // corner of the same ring
  Status status_;
  std::vector<Chain> chains_;
  std::vector<Link> links_;
  std::vector<Triangle> triangles_;
  std::vector<Bridge> bridges_;
  std::vector<uint32_t> left_edges_, right_edges_;  // of the location, from low to high
};

}  // namespace fire3dv::convert
