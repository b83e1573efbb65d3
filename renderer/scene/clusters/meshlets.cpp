#include "renderer/scene/clusters/meshlets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace fire3dv::scene {
namespace {

constexpr uint32_t kNowhere = UINT32_MAX;
constexpr uint8_t kNoSlot = UINT8_MAX;
// Limits per step, since a vertex may have any number of triangles. Skipped triangles start later clusters.
constexpr uint32_t kMaxExamined = 256, kMaxCandidates = 512;
// A cluster takes a disconnected triangle only within this multiple of its radius ...
constexpr float kMaxRadii = 4;
constexpr uint32_t kFewTriangles = 16;  // ... or while it has fewer triangles than this
constexpr float kRankAlone = 0.5f;

using MeshletCorners = std::array<uint32_t, 3>;

// Triangles incident to each vertex.
class TriangleNeighbours {
 public:
  TriangleNeighbours(std::span<const uint32_t> indices, size_t vertex_count) : first_(vertex_count + 1, 0) {
    for (const uint32_t vertex : indices) ++first_[vertex + 1];
    for (size_t v = 0; v < vertex_count; ++v) first_[v + 1] += first_[v];
    triangles_.resize(indices.size());
    std::vector<uint32_t> next(first_.begin(), first_.end() - 1);
    for (uint32_t corner = 0; corner < indices.size(); ++corner)
      triangles_[next[indices[corner]]++] = corner / 3;
    left_.reserve(vertex_count);
    for (size_t v = 0; v < vertex_count; ++v) left_.push_back(first_[v + 1] - first_[v]);
    listed_ = left_;
  }

  uint32_t left(uint32_t vertex) const { return left_[vertex]; }
  void take_one(uint32_t vertex) { --left_[vertex]; }
  // Visits the untaken triangles of a vertex, at most kMaxExamined, and removes taken ones from its list.
  template <typename Do>
  void for_each_untaken(uint32_t vertex, const std::vector<uint8_t>& taken, Do&& what) {
    const uint32_t first = first_[vertex];
    for (uint32_t i = 0; i < std::min(listed_[vertex], kMaxExamined);) {
      const uint32_t triangle = triangles_[first + i];
      if (taken[triangle]) {
        triangles_[first + i] = triangles_[first + --listed_[vertex]];
        continue;
      }
      what(triangle);
      ++i;
    }
  }

 private:
  std::vector<uint32_t> first_, triangles_;
  // Per vertex: number of untaken triangles, and length of its list. Taken ones are removed lazily.
  std::vector<uint32_t> left_, listed_;
};

// Untaken triangles adjacent to the open cluster.
class Candidates {
 public:
  explicit Candidates(size_t triangle_count) : index_(triangle_count, kNowhere) {}

  size_t size() const { return triangles_.size(); }
  uint32_t operator[](size_t slot) const { return triangles_[slot]; }
  bool has(uint32_t triangle) const { return index_[triangle] != kNowhere; }

  void add(uint32_t triangle, const glm::vec3& center, const glm::vec3& normal, uint32_t new_vertices) {
    index_[triangle] = static_cast<uint32_t>(triangles_.size());
    triangles_.push_back(triangle);
    const auto needs = static_cast<float>(new_vertices);
    entries_.push_back({center, normal, needs, needs});
  }
  void remove(uint32_t triangle) {
    const uint32_t slot = index_[triangle];
    if (slot == kNowhere) return;
    index_[triangles_.back()] = slot;
    index_[triangle] = kNowhere;
    triangles_[slot] = triangles_.back();
    entries_[slot] = entries_.back();
    triangles_.pop_back();
    entries_.pop_back();
  }
  void clear() {
    for (const uint32_t triangle : triangles_) index_[triangle] = kNowhere;
    triangles_.clear();
    entries_.clear();
  }
  void needs_one_less(uint32_t triangle) {
    Candidate& entry = entries_[index_[triangle]];
    entry.new_vertices -= 1;
    if (entry.rank >= 1 || entry.new_vertices <= 0) entry.rank = entry.new_vertices;
  }
  void would_be_alone(uint32_t triangle) {
    if (has(triangle) && entries_[index_[triangle]].rank >= 1) entries_[index_[triangle]].rank = kRankAlone;
  }

  // Index of the best candidate: least rank, then least score. The score combines the squared distance of
  // centres, in units of reach, with the deviation of the normal from the cone axis.
  size_t best(const glm::vec3& center, const glm::vec3& axis, float per_reach2, float cone_weight) const {
    size_t found = 0;
    float least_rank = INFINITY, least_score = INFINITY;
    for (size_t i = 0; i < size(); ++i) {
      const Candidate& entry = entries_[i];
      if (entry.rank > least_rank) continue;
      const glm::vec3 away = entry.center - center;
      const float turned = std::max(1 - cone_weight * glm::dot(entry.normal, axis), 1e-3f);
      const float score = (1 + glm::dot(away, away) * per_reach2) * turned;
      if (entry.rank == least_rank && !(score < least_score)) continue;
      found = i;
      least_rank = entry.rank;
      least_score = score;
    }
    return found;
  }

 private:
  // rank: number of new vertices; kRankAlone if the triangle needs some but would otherwise be left alone.
  struct Candidate {
    glm::vec3 center, normal;
    float rank, new_vertices;
  };
  std::vector<uint32_t> index_, triangles_;
  std::vector<Candidate> entries_;
};

class Growth {
 public:
  Growth(std::span<const uint32_t> indices, std::span<const glm::vec3> positions, const GrowthLimits& limits)
      : indices_(indices),
        positions_(positions),
        limits_(limits),
        neighbours_(indices, positions.size()),
        candidates_(indices.size() / 3),
        taken_(indices.size() / 3, 0),
        slot_(positions.size(), kNoSlot) {
    double area = 0;
    for (uint32_t t = 0; t < taken_.size(); ++t) area += area_of(t);
    const double of_cluster =
        area / std::max<double>(1, static_cast<double>(taken_.size())) * limits.triangles;
    const auto reach2 = static_cast<float>(0.25 * of_cluster);
    reach2_ = reach2 > 0 && std::isfinite(reach2) ? reach2 : 1;
  }

  GrownClusters run() {
    out_.vertices.reserve(positions_.size() + positions_.size() / 2);
    out_.corners.reserve(indices_.size());
    for (uint32_t begin = 0; begin != kNowhere; begin = next_component()) {
      if (!takes_part(begin)) close();
      take(begin);
      while (candidates_.size() > 0) take_next();
    }
    close();
    return std::move(out_);
  }

 private:
  MeshletCorners corners(uint32_t triangle) const {
    const uint32_t* corner = &indices_[size_t{3} * triangle];
    return {corner[0], corner[1], corner[2]};
  }
  glm::vec3 center_of(uint32_t triangle) const {
    const MeshletCorners c = corners(triangle);
    return (positions_[c[0]] + positions_[c[1]] + positions_[c[2]]) / 3.0f;
  }
  glm::vec3 double_area_normal(uint32_t triangle) const {
    const MeshletCorners c = corners(triangle);
    return glm::cross(positions_[c[1]] - positions_[c[0]], positions_[c[2]] - positions_[c[0]]);
  }
  double area_of(uint32_t triangle) const {  // double, since squares of valid coordinates overflow float
    const MeshletCorners c = corners(triangle);
    const glm::dvec3 a(positions_[c[0]]), b(positions_[c[1]]), d(positions_[c[2]]);
    return 0.5 * glm::length(glm::cross(b - a, d - a));
  }
  glm::vec3 normal_of(uint32_t triangle) const {
    const glm::vec3 normal = double_area_normal(triangle);
    const float length = std::sqrt(glm::dot(normal, normal));
    return length > 0 ? normal / length : glm::vec3(0);
  }
  uint32_t new_vertices(uint32_t triangle) const {
    uint32_t count = 0;
    for (const uint32_t vertex : corners(triangle)) count += slot_[vertex] == kNoSlot;
    return count;
  }
  bool fits(uint32_t triangle) const {
    return triangle_count() < limits_.triangles &&
           open_vertices_.size() + new_vertices(triangle) <= limits_.vertices;
  }
  uint32_t triangle_count() const { return static_cast<uint32_t>(open_triangles_.size()); }
  glm::vec3 center() const { return centers_ / static_cast<float>(std::max(triangle_count(), 1u)); }

  void take_next() {
    const float turning = std::sqrt(glm::dot(normals_, normals_));
    const size_t best = candidates_.best(center(), turning > 0 ? normals_ / turning : glm::vec3(0),
                                         (1 - limits_.cone_weight) / reach2_, limits_.cone_weight);
    if (fits(candidates_[best])) return take(candidates_[best]);
    const uint32_t begin = least_connected();
    close();
    take(begin);
  }

  // The candidate with the fewest untaken neighbours; left behind, it would need a cluster of its own.
  uint32_t least_connected() const {
    const auto around = [&](uint32_t triangle) {
      uint64_t count = 0;
      for (const uint32_t vertex : corners(triangle)) count += neighbours_.left(vertex);
      return count;
    };
    uint32_t found = candidates_[0];
    uint64_t fewest = around(found);
    for (size_t i = 1; i < candidates_.size(); ++i) {
      const uint64_t count = around(candidates_[i]);
      if (count >= fewest) continue;
      fewest = count;
      found = candidates_[i];
    }
    return found;
  }

  void take(uint32_t triangle) {
    taken_[triangle] = 1;
    candidates_.remove(triangle);
    for (const uint32_t vertex : corners(triangle)) neighbours_.take_one(vertex);
    for (const uint32_t vertex : corners(triangle)) {
      if (slot_[vertex] == kNoSlot) open_up(vertex);
      if (neighbours_.left(vertex) != 1) continue;
      neighbours_.for_each_untaken(vertex, taken_,
                                   [&](uint32_t other) { candidates_.would_be_alone(other); });
    }
    centers_ += center_of(triangle);
    normals_ += normal_of(triangle);
    open_triangles_.push_back(triangle);
  }

  // Adds a vertex to the open cluster.
  void open_up(uint32_t vertex) {
    slot_[vertex] = static_cast<uint8_t>(open_vertices_.size());
    open_vertices_.push_back(vertex);
    neighbours_.for_each_untaken(vertex, taken_, [&](uint32_t triangle) {
      if (candidates_.has(triangle)) {
        candidates_.needs_one_less(triangle);
      } else if (candidates_.size() < kMaxCandidates) {
        candidates_.add(triangle, center_of(triangle), normal_of(triangle), new_vertices(triangle));
      }
    });
  }

  void close() {
    if (open_triangles_.empty()) return;
    // File order inside a cluster keeps the order of self-blending.
    std::sort(open_triangles_.begin(), open_triangles_.end());
    const auto first_triangle = static_cast<uint32_t>(out_.corners.size() / 3);
    for (const uint32_t triangle : open_triangles_) {
      for (const uint32_t vertex : corners(triangle)) out_.corners.push_back(slot_[vertex]);
    }
    const auto vertex_count = static_cast<uint32_t>(open_vertices_.size());
    out_.runs.push_back(
        {static_cast<uint32_t>(out_.vertices.size()), vertex_count, first_triangle, triangle_count()});
    out_.vertices.insert(out_.vertices.end(), open_vertices_.begin(), open_vertices_.end());
    for (const uint32_t vertex : open_vertices_) slot_[vertex] = kNoSlot;
    open_vertices_.clear();
    candidates_.clear();
    open_triangles_.clear();
    centers_ = normals_ = glm::vec3(0);
  }

  // Next untaken triangle along a Morton curve through all triangle centres (Morton 1966), so that a
  // disconnected part is near the previous one. kNowhere: none is left.
  uint32_t next_component() {
    if (!has_curve_) find_curve();
    while (next_on_curve_ < curve_.size() && taken_[curve_[next_on_curve_]]) ++next_on_curve_;
    return next_on_curve_ < curve_.size() ? curve_[next_on_curve_] : kNowhere;
  }
  bool takes_part(uint32_t triangle) const {
    if (open_triangles_.empty()) return true;
    if (!fits(triangle)) return false;
    const glm::vec3 away = center_of(triangle) - center();
    return triangle_count() < kFewTriangles || glm::dot(away, away) <= kMaxRadii * kMaxRadii * reach2_;
  }

  void find_curve() {
    has_curve_ = true;
    std::vector<uint32_t> left;
    for (uint32_t t = 0; t < taken_.size(); ++t) {
      if (!taken_[t]) left.push_back(t);
    }
    if (left.empty()) return;
    glm::vec3 low(INFINITY), high(-INFINITY);
    for (const uint32_t t : left) {
      low = glm::min(low, center_of(t));
      high = glm::max(high, center_of(t));
    }
    const glm::vec3 size = glm::max(high - low, glm::vec3(1e-30f));
    std::vector<std::pair<uint32_t, uint32_t>> keys;
    keys.reserve(left.size());
    for (const uint32_t t : left) {
      const glm::vec3 cell = (center_of(t) - low) / size * 1023.0f;
      uint32_t key = 0;
      for (int i = 0; i < 3; ++i) {
        const uint32_t along = cell[i] > 0 && cell[i] < 1024 ? static_cast<uint32_t>(cell[i]) : 0;
        for (uint32_t bit = 0; bit < 10; ++bit)
          key |= (along >> bit & 1) << (3 * bit + static_cast<uint32_t>(i));
      }
      keys.emplace_back(key, t);
    }
    std::sort(keys.begin(), keys.end());
    for (const auto& [key, t] : keys) curve_.push_back(t);
  }

  std::span<const uint32_t> indices_;
  std::span<const glm::vec3> positions_;
  const GrowthLimits limits_;
  TriangleNeighbours neighbours_;
  Candidates candidates_;
  std::vector<uint8_t> taken_;
  std::vector<uint8_t> slot_;  // per vertex: its slot in the open cluster
  float reach2_ = 1;           // squared radius of a flat cluster of average triangles
  // State of the open cluster.
  std::vector<uint32_t> open_vertices_, open_triangles_;
  glm::vec3 centers_{0}, normals_{0};  // sums over triangles
  std::vector<uint32_t> curve_;
  size_t next_on_curve_ = 0;
  bool has_curve_ = false;
  GrownClusters out_;
};

}  // namespace

GrownClusters grow_clusters(std::span<const uint32_t> indices, std::span<const glm::vec3> positions,
                            const GrowthLimits& limits) {
  if (indices.empty()) return {};
  return Growth(indices, positions, limits).run();
}

namespace {

// Weight of normal similarity: clusters with narrow normal cones are culled as a whole if they face away.
constexpr float kConeWeight = 0.25f;
// Minimum cosine between normals and cone axis; wider cones are hardly ever culled.
constexpr double kLeastCosine = 0.1;

// Bounding sphere in double precision: squares of valid coordinates overflow float, those of tiny areas
// underflow.
struct Sphere {
  glm::dvec3 center{0};
  double radius = 0;
};

// Near-minimal bounding sphere (Ritter 1990).
Sphere sphere_around(std::span<const glm::dvec3> points) {
  if (points.empty()) return {};
  std::array<glm::dvec3, 3> low, high;
  low.fill(points[0]);
  high.fill(points[0]);
  for (const glm::dvec3& point : points) {
    for (int i = 0; i < 3; ++i) {
      const auto axis = static_cast<size_t>(i);
      if (point[i] < low[axis][i]) low[axis] = point;
      if (point[i] > high[axis][i]) high[axis] = point;
    }
  }
  size_t widest = 0;
  for (size_t axis = 1; axis < 3; ++axis) {
    if (glm::distance(low[axis], high[axis]) > glm::distance(low[widest], high[widest])) widest = axis;
  }
  Sphere sphere{0.5 * (low[widest] + high[widest]), 0.5 * glm::distance(low[widest], high[widest])};
  for (const glm::dvec3& point : points) {
    const double away = glm::distance(point, sphere.center);
    if (!(away > sphere.radius)) continue;
    const double grown = 0.5 * (sphere.radius + away);
    sphere.center += (point - sphere.center) * ((away - grown) / away);
    sphere.radius = grown;
  }
  return sphere;
}

// Unit normals of non-degenerate triangles.
std::vector<glm::dvec3> normals_of(std::span<const uint8_t> corners, std::span<const glm::dvec3> points) {
  std::vector<glm::dvec3> normals;
  normals.reserve(corners.size() / 3);
  for (size_t c = 0; c < corners.size(); c += 3) {
    const glm::dvec3& a = points[corners[c]];
    const glm::dvec3 normal = glm::cross(points[corners[c + 1]] - a, points[corners[c + 2]] - a);
    const double length = std::sqrt(glm::dot(normal, normal));
    if (length > 0 && std::isfinite(length)) normals.push_back(normal / length);
  }
  return normals;
}

// Normal cone; cutoff 1 disables culling.
void find_cone(Cluster& cluster, std::span<const glm::dvec3> normals) {
  cluster.cone_cutoff = 1;
  const glm::dvec3 center = sphere_around(normals).center;
  const double length = std::sqrt(glm::dot(center, center));
  if (!(length > 0)) return;
  cluster.cone_axis = center / length;
  double least = 1;
  for (const glm::dvec3& normal : normals)
    least = std::min(least, glm::dot(normal, glm::dvec3(cluster.cone_axis)));
  if (!(least > kLeastCosine)) return;
  // Margin against rounding, so that visible triangles are never culled.
  cluster.cone_cutoff = static_cast<float>(std::min(std::sqrt(1 - least * least) + 1e-3, 1.0));
}

}  // namespace

Meshlets::Meshlets(std::span<const uint32_t> indices, std::span<const glm::vec3> positions)
    : grown(grow_clusters(indices, positions, {kClusterVertices, kClusterTriangles, kConeWeight})) {}

Cluster Meshlets::bounded(const GrownClusters::Run& run, std::span<const glm::vec3> positions) const {
  std::vector<glm::dvec3> points;
  points.reserve(run.vertex_count);
  for (uint32_t v = 0; v < run.vertex_count; ++v)
    points.emplace_back(positions[grown.vertices[run.first_vertex + v]]);
  Cluster cluster;
  cluster.center = sphere_around(points).center;
  double radius2 = 0;
  for (const glm::dvec3& point : points) {
    const glm::dvec3 offset = point - glm::dvec3(cluster.center);
    radius2 = std::max(radius2, glm::dot(offset, offset));
  }
  cluster.radius = static_cast<float>(std::sqrt(radius2) * 1.00001);
  const std::span<const uint8_t> corners(&grown.corners[size_t{3} * run.first_triangle],
                                         size_t{3} * run.triangle_count);
  find_cone(cluster, normals_of(corners, points));
  cluster.vertex_count = run.vertex_count;
  cluster.triangle_count = run.triangle_count;
  return cluster;
}

}  // namespace fire3dv::scene
