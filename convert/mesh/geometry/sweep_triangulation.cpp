#include "convert/mesh/geometry/sweep_triangulation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace fire3dv::convert {

double doubled_area_of(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  const double p = (b.x - a.x) * (c.y - a.y), q = (b.y - a.y) * (c.x - a.x);
  constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();
  return std::abs(p - q) <= kRounding * (std::abs(p) + std::abs(q)) ? 0 : p - q;
}

SweepTriangulation::Status::Status(size_t edges) : nodes_(edges) {
  uint32_t state = 0x9e3779b9;  // xorshift: priorities need not be unpredictable, since each corner has one
  for (Node& node : nodes_) {
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    node.priority = state;
  }
}

void SweepTriangulation::Status::replace_child(uint32_t parent, uint32_t old_child, uint32_t child) {
  if (parent == kNone)
    root_ = child;
  else
    (nodes_[parent].low == old_child ? nodes_[parent].low : nodes_[parent].high) = child;
  if (child != kNone) nodes_[child].parent = parent;
}

// Makes the node the parent of its parent.
void SweepTriangulation::Status::rotate_up(uint32_t node) {
  const uint32_t parent = nodes_[node].parent;
  replace_child(nodes_[parent].parent, parent, node);
  uint32_t& moved = nodes_[parent].low == node ? nodes_[node].high : nodes_[node].low;
  uint32_t& place = nodes_[parent].low == node ? nodes_[parent].low : nodes_[parent].high;
  place = moved;
  if (moved != kNone) nodes_[moved].parent = parent;
  moved = parent;
  nodes_[parent].parent = node;
}

void SweepTriangulation::Status::insert_above(uint32_t lower, uint32_t edge) {
  Node& node = nodes_[edge];
  const uint32_t upper = lower == kNone ? lowest_ : nodes_[lower].above;
  node.low = node.high = node.parent = kNone;
  node.below = lower;
  node.above = upper;
  if (lower == kNone)
    lowest_ = edge;
  else
    nodes_[lower].above = edge;
  if (upper != kNone) nodes_[upper].below = edge;
  if (lower != kNone && nodes_[lower].high == kNone) {
    nodes_[lower].high = edge;
    node.parent = lower;
  } else if (upper != kNone) {
    nodes_[upper].low = edge;
    node.parent = upper;
  } else {
    root_ = edge;
  }
  while (node.parent != kNone && nodes_[node.parent].priority < node.priority) rotate_up(edge);
}

void SweepTriangulation::Status::erase(uint32_t edge) {
  Node& node = nodes_[edge];
  while (node.low != kNone || node.high != kNone) {
    const bool is_low =
        node.high == kNone || (node.low != kNone && nodes_[node.low].priority > nodes_[node.high].priority);
    rotate_up(is_low ? node.low : node.high);
  }
  replace_child(node.parent, edge, kNone);
  if (node.below == kNone)
    lowest_ = node.above;
  else
    nodes_[node.below].above = node.above;
  if (node.above != kNone) nodes_[node.above].below = node.below;
}

SweepTriangulation::SweepTriangulation(std::span<const glm::dvec2> points,
                                       std::span<const uint32_t> ring_ends)
    : points_(points), status_(points.size()) {
  edges_.resize(points.size());
  previous_.resize(points.size());
  uint32_t begin = 0;
  for (const uint32_t end : ring_ends) {
    for (uint32_t i = begin; i < end; ++i) {
      const uint32_t next = i + 1 == end ? begin : i + 1;
      const bool is_rightward = is_before(i, next);
      edges_[i] = {is_rightward ? i : next, is_rightward ? next : i, is_rightward, kNone};
      previous_[next] = i;
    }
    begin = end;
  }
}

std::optional<std::vector<SweepTriangulation::Triangle>> SweepTriangulation::cut(
    std::span<const glm::dvec2> points) {
  const auto end = static_cast<uint32_t>(points.size());
  SweepTriangulation sweep(points, std::span(&end, 1));
  if (!sweep.sweep()) return std::nullopt;
  return std::move(sweep.triangles_);
}

std::optional<std::vector<SweepTriangulation::Bridge>> SweepTriangulation::find_bridges(
    std::span<const glm::dvec2> points, std::span<const uint32_t> ring_ends) {
  SweepTriangulation sweep(points, ring_ends);
  if (!sweep.sweep()) return std::nullopt;
  // The leftmost corner of a hole comes first.
  std::vector<uint8_t> is_joined(ring_ends.size());
  std::vector<Bridge> bridges;
  for (const Bridge& bridge : sweep.bridges_) {
    const auto ring = static_cast<size_t>(
        std::upper_bound(ring_ends.begin(), ring_ends.end(), bridge.corner) - ring_ends.begin());
    if (ring != 0 && !std::exchange(is_joined[ring], 1)) bridges.push_back(bridge);
  }
  if (bridges.size() + 1 != ring_ends.size()) return std::nullopt;
  return bridges;
}

bool SweepTriangulation::is_before(uint32_t a, uint32_t b) const {
  const glm::dvec2 &p = points_[a], &q = points_[b];
  return p.x != q.x ? p.x < q.x : p.y < q.y;
}

bool SweepTriangulation::sweep() {
  std::vector<uint32_t> order(points_.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return is_before(a, b); });
  for (size_t first = 0; first < order.size();) {
    size_t end = first + 1;
    while (end < order.size() && points_[order[end]] == points_[order[first]]) ++end;
    if (!sweep_location(std::span(order).subspan(first, end - first))) return false;
    first = end;
  }
  return true;
}

// All corners at one location.
bool SweepTriangulation::sweep_location(std::span<const uint32_t> corners) {
  if (!find_left_edges(corners)) return false;
  sort_right_edges(corners);
  const uint32_t below =
      left_edges_.empty() ? find_below(points_[corners[0]]) : status_.below(left_edges_.front());
  if (!alternate(below)) return false;
  for (size_t i = 0; i + 1 < left_edges_.size(); ++i) {
    const Edge& edge = edges_[left_edges_[i]];
    if (edge.is_up == edges_[left_edges_[i + 1]].is_up) return false;
    if (edge.is_up) close(chains_[edge.chain], edge.right);
  }
  const bool is_good = left_edges_.empty()    ? split_region(below)
                       : right_edges_.empty() ? merge_regions(below)
                                              : continue_regions(below);
  if (!is_good) return false;
  for (const uint32_t edge : left_edges_) status_.erase(edge);
  uint32_t lower = below;
  for (size_t i = 0; i < right_edges_.size(); ++i) {
    Edge& edge = edges_[right_edges_[i]];
    status_.insert_above(lower, right_edges_[i]);
    lower = right_edges_[i];
    if (edge.is_up && i + 1 < right_edges_.size()) edge.chain = add_chain(edge.left);
  }
  return true;
}

// Edges that end here are neighbours on the sweep line.
bool SweepTriangulation::find_left_edges(std::span<const uint32_t> corners) {
  left_edges_.clear();
  const glm::dvec2 point = points_[corners[0]];
  size_t count = 0;
  uint32_t edge = kNone;
  for (const uint32_t corner : corners) {
    for (const uint32_t each : {corner, previous_[corner]}) {
      if (edges_[each].right != corner) continue;
      ++count;
      edge = each;
    }
  }
  if (count == 0) return true;
  const auto ends_here = [&](uint32_t each) { return each != kNone && points_[edges_[each].right] == point; };
  while (ends_here(status_.below(edge))) edge = status_.below(edge);
  for (; ends_here(edge); edge = status_.above(edge)) left_edges_.push_back(edge);
  return left_edges_.size() == count;
}

// The edge below a location where no edge ends. Where the location lies on an edge, the edges that begin here
// decide; of those that lie on it, too, the exterior has no width.
uint32_t SweepTriangulation::find_below(const glm::dvec2& point) const {
  return status_.highest([&](uint32_t each) {
    const Edge& edge = edges_[each];
    const double side = doubled_area_of(points_[edge.left], points_[edge.right], point);
    if (side != 0) return side > 0;
    const double next = turn(edge.left, edge.right, edges_[right_edges_.front()].right);
    return next != 0 ? next > 0 : !edge.is_up;
  });
}

void SweepTriangulation::sort_right_edges(std::span<const uint32_t> corners) {
  right_edges_.clear();
  for (const uint32_t corner : corners) {
    for (const uint32_t each : {corner, previous_[corner]})
      if (edges_[each].left == corner) right_edges_.push_back(each);
  }
  const glm::dvec2 point = points_[corners[0]];
  std::stable_sort(right_edges_.begin(), right_edges_.end(), [&](uint32_t a, uint32_t b) {
    return doubled_area_of(point, points_[edges_[a].right], points_[edges_[b].right]) > 0;
  });
}

// Edges that begin here have the interior above and below in turn. Those that lie on each other are exchanged
// for it.
bool SweepTriangulation::alternate(uint32_t below) {
  bool is_up = below != kNone && edges_[below].is_up;
  for (size_t i = 0; i < right_edges_.size(); ++i, is_up = !is_up) {
    size_t other = i;
    while (other < right_edges_.size() && edges_[right_edges_[other]].is_up == is_up &&
           turn(edges_[right_edges_[i]].left, edges_[right_edges_[i]].right,
                edges_[right_edges_[other]].right) == 0)
      ++other;
    if (other == right_edges_.size() || edges_[right_edges_[other]].is_up == is_up) return false;
    std::swap(right_edges_[i], right_edges_[other]);
  }
  return true;
}

bool SweepTriangulation::continue_regions(uint32_t below) {
  if (below != kNone && edges_[below].is_up) {
    cut_high_end(chains_[edges_[below].chain], edges_[left_edges_.front()].right);
    if (edges_[left_edges_.front()].is_up) return false;
  }
  const Edge& old_edge = edges_[left_edges_.back()];
  Edge& edge = edges_[right_edges_.back()];
  if (old_edge.is_up != edge.is_up) return false;
  if (!edge.is_up) return true;
  cut_low_end(chains_[old_edge.chain], old_edge.right);
  edge.chain = old_edge.chain;
  return true;
}

// The regions below and above the edges that end here become one.
bool SweepTriangulation::merge_regions(uint32_t below) {
  const Edge &first = edges_[left_edges_.front()], &last = edges_[left_edges_.back()];
  const bool is_inside = below != kNone && edges_[below].is_up;
  if (is_inside != last.is_up || is_inside == first.is_up) return false;
  if (!is_inside) return true;
  Chain &lower = chains_[edges_[below].chain], &upper = chains_[last.chain];
  cut_high_end(lower, first.right);
  cut_low_end(upper, last.right);
  // The lowest corner of the upper chain is the highest of the lower one.
  links_[lower.high].above = links_[upper.low].above;
  if (links_[upper.low].above == kNone) return true;
  links_[links_[upper.low].above].below = lower.high;
  lower.rightmost = lower.high;
  lower.high = upper.high;
  return true;
}

// Edges begin here within a region, or outside.
bool SweepTriangulation::split_region(uint32_t below) {
  if (below == kNone || !edges_[below].is_up) return !edges_[right_edges_.back()].is_up;
  const uint32_t lower = edges_[below].chain;
  const Edge& first = edges_[right_edges_.front()];
  Edge& last = edges_[right_edges_.back()];
  if (!last.is_up) return false;
  // The rightmost corner sees the location, and ends both parts of the chain.
  const uint32_t seen = chains_[lower].rightmost;
  bridges_.push_back({first.left, links_[seen].corner});
  const uint32_t upper = add_chain(links_[seen].corner);
  links_[chains_[upper].low].above = links_[seen].above;
  if (links_[seen].above != kNone) {
    links_[links_[seen].above].below = chains_[upper].low;
    chains_[upper].high = chains_[lower].high;
  }
  links_[seen].above = kNone;
  chains_[lower].high = seen;
  cut_high_end(chains_[lower], first.left);
  cut_low_end(chains_[upper], last.left);
  last.chain = upper;
  return true;
}

uint32_t SweepTriangulation::add_link(uint32_t corner) {
  links_.push_back({corner});
  return static_cast<uint32_t>(links_.size() - 1);
}

uint32_t SweepTriangulation::add_chain(uint32_t corner) {
  const uint32_t link = add_link(corner);
  chains_.push_back({link, link, link});
  return static_cast<uint32_t>(chains_.size() - 1);
}

// Cuts the triangle off, counter-clockwise. Returns false if the tip is not convex. A tip without width,
// where the outline touches itself, is cut off without a triangle.
bool SweepTriangulation::cut_tip(uint32_t a, uint32_t tip, uint32_t b) {
  const double area = turn(a, tip, b);
  if (area > 0) triangles_.push_back({a, tip, b});
  return area > 0 || (area == 0 && glm::dot(points_[a] - points_[tip], points_[b] - points_[tip]) > 0);
}

// The corner ends the lower edge of the chain's region.
void SweepTriangulation::cut_low_end(Chain& chain, uint32_t corner) {
  while (chain.low != chain.high) {
    const uint32_t first = links_[chain.low].corner, second = links_[links_[chain.low].above].corner;
    if (!cut_tip(second, first, corner)) break;
    chain.low = links_[chain.low].above;
  }
  const uint32_t link = add_link(corner);
  links_[link].above = chain.low;
  links_[chain.low].below = link;
  chain.low = chain.rightmost = link;
}

void SweepTriangulation::cut_high_end(Chain& chain, uint32_t corner) {
  while (chain.low != chain.high) {
    const uint32_t first = links_[chain.high].corner, second = links_[links_[chain.high].below].corner;
    if (!cut_tip(corner, first, second)) break;
    chain.high = links_[chain.high].below;
  }
  const uint32_t link = add_link(corner);
  links_[link].below = chain.high;
  links_[chain.high].above = link;
  chain.high = chain.rightmost = link;
}

// Both edges of the region end at the corner, which sees the whole chain.
void SweepTriangulation::close(const Chain& chain, uint32_t corner) {
  for (uint32_t link = chain.low; link != chain.high; link = links_[link].above) {
    const uint32_t first = links_[link].corner, second = links_[links_[link].above].corner;
    if (turn(second, first, corner) != 0) triangles_.push_back({second, first, corner});
  }
}

}  // namespace fire3dv::convert
