#include "convert/mesh/geometry/polygon_holes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "convert/mesh/geometry/sweep_triangulation.h"

namespace fire3dv::convert {
namespace {

// Edges that are compared in all calls: some seconds.
constexpr uint64_t kMaxEdges = 200'000'000;
constexpr uint64_t kMaxEdgesOfPolygon = 1'000'000;  // larger ones are swept

double side_of(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& point) {
  return (b.x - a.x) * (point.y - a.y) - (b.y - a.y) * (point.x - a.x);
}

bool lies_on(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& point) {
  return side_of(a, b, point) == 0 && glm::dot(point - a, point - b) <= 0;
}

bool do_meet(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d) {
  const double c_side = side_of(a, b, c), d_side = side_of(a, b, d);
  const double a_side = side_of(c, d, a), b_side = side_of(c, d, b);
  if (((c_side > 0 && d_side < 0) || (c_side < 0 && d_side > 0)) &&
      ((a_side > 0 && b_side < 0) || (a_side < 0 && b_side > 0)))
    return true;
  return lies_on(a, b, c) || lies_on(a, b, d) || lies_on(c, d, a) || lies_on(c, d, b);
}

}  // namespace

// Along the largest axis of the outline's normal. Returns false for an outline without an area.
bool HoleJoiner::project(std::span<const Ring> rings) {
  glm::dvec3 normal(0);
  const Ring& outline = rings[0];
  for (size_t i = 2; i < outline.size(); ++i)
    normal += glm::cross(outline[i - 1] - outline[0], outline[i] - outline[0]);
  if (!std::isfinite(normal.x + normal.y + normal.z)) return false;
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(normal[i]) > std::abs(normal[axis])) axis = i;
  if (!(std::abs(normal[axis]) > 0)) return false;
  int u = (axis + 1) % 3, v = (axis + 2) % 3;
  if (normal[axis] < 0) std::swap(u, v);
  points_.clear();
  for (const Ring& ring : rings) {
    for (const glm::dvec3& corner : ring) {
      points_.emplace_back(corner[u], corner[v]);
      if (!std::isfinite(corner[u]) || !std::isfinite(corner[v])) return false;
    }
  }
  return true;
}

double HoleJoiner::doubled_area(const Chain& chain) const {
  double sum = 0;
  for (size_t i = 2; i < chain.size(); ++i)
    sum += side_of(points_[chain[0]], points_[chain[i - 1]], points_[chain[i]]);
  return sum;
}

// The polygon is on the left of the chain. True if it begins with the direction of `to` at the corner.
bool HoleJoiner::opens_to(const Chain& chain, size_t corner, const glm::dvec2& to) const {
  const size_t count = chain.size();
  const glm::dvec2 &before = points_[chain[(corner + count - 1) % count]], &here = points_[chain[corner]],
                   &after = points_[chain[(corner + 1) % count]];
  const bool is_left_of_both = side_of(before, here, to) > 0 && side_of(here, after, to) > 0;
  if (side_of(before, here, after) > 0) return is_left_of_both;
  return side_of(before, here, to) > 0 || side_of(here, after, to) > 0;
}

// True if no edge of the chain meets the segment, apart from edges that share one of its ends.
bool HoleJoiner::is_free(const glm::dvec2& from, const glm::dvec2& to, const Chain& chain) {
  const glm::dvec2 low = glm::min(from, to), high = glm::max(from, to);
  steps_ += chain.size();
  for (size_t i = 0; i < chain.size(); ++i) {
    const glm::dvec2 &a = points_[chain[i]], &b = points_[chain[(i + 1) % chain.size()]];
    if (std::max(a.x, b.x) < low.x || std::min(a.x, b.x) > high.x || std::max(a.y, b.y) < low.y ||
        std::min(a.y, b.y) > high.y)
      continue;
    const bool shares_end = a == from || a == to || b == from || b == to;
    if (!shares_end && do_meet(from, to, a, b)) return false;
  }
  return true;
}

// Replaces the outline by one that goes to the hole and back.
bool HoleJoiner::add_hole(Chain& outline, const std::vector<Chain>& holes, size_t hole) {
  const Chain& ring = holes[hole];
  const auto rightmost = static_cast<size_t>(
      std::max_element(ring.begin(), ring.end(),
                       [&](uint32_t a, uint32_t b) { return points_[a].x < points_[b].x; }) -
      ring.begin());
  const glm::dvec2 start = points_[ring[rightmost]];
  std::vector<size_t> candidates(outline.size());
  std::iota(candidates.begin(), candidates.end(), size_t{0});
  const auto distance = [&](size_t corner) { return glm::length(points_[outline[corner]] - start); };
  std::sort(candidates.begin(), candidates.end(),
            [&](size_t a, size_t b) { return distance(a) < distance(b); });
  constexpr uint64_t kStepsOfSorting = 16;
  steps_ += kStepsOfSorting * candidates.size();
  for (const size_t corner : candidates) {
    if (steps_ > kMaxEdges) return false;
    const glm::dvec2 end = points_[outline[corner]];
    if (end == start || !opens_to(outline, corner, start) || !opens_to(ring, rightmost, end)) continue;
    bool is_visible = is_free(start, end, outline);
    for (size_t other = hole; other < holes.size() && is_visible; ++other)
      is_visible = is_free(start, end, holes[other]);
    if (!is_visible) continue;
    Chain joined(outline.begin(), outline.begin() + static_cast<std::ptrdiff_t>(corner) + 1);
    for (size_t i = 0; i <= ring.size(); ++i) joined.push_back(ring[(rightmost + i) % ring.size()]);
    joined.insert(joined.end(), outline.begin() + static_cast<std::ptrdiff_t>(corner), outline.end());
    outline = std::move(joined);
    return true;
  }
  return false;
}

std::vector<uint32_t> HoleJoiner::join(std::span<const Ring> rings) {
  if (rings.empty() || rings[0].size() < 3 || !project(rings)) return {};
  Chain outline(rings[0].size());
  std::iota(outline.begin(), outline.end(), uint32_t{0});
  std::vector<Chain> holes;
  auto first = static_cast<uint32_t>(outline.size());
  for (const Ring& ring : rings.subspan(1)) {
    Chain hole(ring.size());
    std::iota(hole.begin(), hole.end(), first);
    first += static_cast<uint32_t>(ring.size());
    const double area = hole.size() < 3 ? 0 : doubled_area(hole);
    if (area == 0) continue;  // covers nothing
    if (area > 0) std::reverse(hole.begin(), hole.end());
    holes.push_back(std::move(hole));
  }
  // From right to left: right of a hole there are only the outline and holes that it has already.
  const auto right_end = [&](const Chain& hole) {
    double right = points_[hole[0]].x;
    for (const uint32_t corner : hole) right = std::max(right, points_[corner].x);
    return right;
  };
  std::sort(holes.begin(), holes.end(),
            [&](const Chain& a, const Chain& b) { return right_end(a) > right_end(b); });
  size_t corners = outline.size();
  for (const Chain& hole : holes) corners += hole.size();
  if (corners * holes.size() > kMaxEdgesOfPolygon || steps_ > kMaxEdges) return join_by_sweep(outline, holes);
  for (size_t hole = 0; hole < holes.size(); ++hole)
    if (!add_hole(outline, holes, hole)) return {};
  return outline;
}

// In time n log n. The polygon is the face on the left of the outline, of the graph of all rings and bridges.
std::vector<uint32_t> HoleJoiner::join_by_sweep(const Chain& outline, const std::vector<Chain>& holes) const {
  Chain corners = outline;
  std::vector<uint32_t> ring_ends{static_cast<uint32_t>(corners.size())};
  for (const Chain& hole : holes) {
    corners.insert(corners.end(), hole.begin(), hole.end());
    ring_ends.push_back(static_cast<uint32_t>(corners.size()));
  }
  std::vector<glm::dvec2> points;
  for (const uint32_t corner : corners) points.push_back(points_[corner]);
  const auto bridges = SweepTriangulation::find_bridges(points, ring_ends);
  if (!bridges) return {};
  std::vector<uint32_t> next(points.size()), previous(points.size());
  uint32_t begin = 0;
  for (const uint32_t end : ring_ends) {
    for (uint32_t i = begin; i < end; ++i) {
      next[i] = i + 1 == end ? begin : i + 1;
      previous[next[i]] = i;
    }
    begin = end;
  }
  std::vector<std::pair<uint32_t, uint32_t>> ends;  // of bridges, both ways, by corner
  for (const SweepTriangulation::Bridge& bridge : *bridges) {
    if (points[bridge.corner] == points[bridge.other]) return {};
    ends.emplace_back(bridge.corner, bridge.other);
    ends.emplace_back(bridge.other, bridge.corner);
  }
  std::sort(ends.begin(), ends.end());
  // Clockwise angle at a corner between the directions to two others, in (0, 2 pi].
  const auto angle = [&](uint32_t at, uint32_t from, uint32_t to) {
    const glm::dvec2 a = points[from] - points[at], b = points[to] - points[at];
    const double turn = std::atan2(b.x * a.y - b.y * a.x, glm::dot(a, b));
    return turn > 0 ? turn : turn + 2 * std::numbers::pi;
  };
  Chain joined;
  const size_t most = points.size() + 2 * bridges->size();
  uint32_t from = previous[0], at = 0;
  do {
    if (joined.size() == most) return {};
    joined.push_back(corners[at]);
    uint32_t to = next[at];
    auto end = std::lower_bound(ends.begin(), ends.end(), std::pair(at, uint32_t{0}));
    if (end != ends.end() && end->first == at) {
      double least = to == from ? 2 * std::numbers::pi : angle(at, from, to);
      for (; end != ends.end() && end->first == at; ++end) {
        if (end->second == from) continue;
        if (const double turn = angle(at, from, end->second); turn < least) {
          least = turn;
          to = end->second;
        }
      }
    }
    from = std::exchange(at, to);
  } while (at != 0 || from != previous[0]);
  return joined.size() == most ? joined : Chain();
}

}  // namespace fire3dv::convert
