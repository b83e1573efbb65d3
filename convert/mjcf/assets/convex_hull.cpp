#include "convert/mjcf/assets/convex_hull.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

namespace fire3dv::convert {
namespace {

constexpr size_t kMaxPoints = 5000;

struct Face {
  MeshData::Triangle corners;
  glm::dvec3 normal;
  double offset;
};

// Incremental hull: each point outside replaces the faces that it sees by a cone to their outline.
class Hull {
 public:
  explicit Hull(const std::vector<glm::vec3>& points) : points_(points.begin(), points.end()) {
    glm::dvec3 low(points_[0]), high(points_[0]);
    for (const glm::dvec3& p : points_) {
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
    tolerance_ = 1e-9 * glm::length(high - low);
  }

  bool start() {
    const std::array<size_t, 2> line{
        farthest([&](const glm::dvec3& p) { return -p.x; }),
        farthest([&](const glm::dvec3& p) { return glm::distance(p, points_[0]); })};
    const size_t a = line[1];
    const size_t b = farthest([&](const glm::dvec3& p) { return glm::distance(p, points_[a]); });
    const glm::dvec3 along = points_[b] - points_[a];
    if (glm::length(along) <= tolerance_) return false;
    const size_t c =
        farthest([&](const glm::dvec3& p) { return glm::length(glm::cross(along, p - points_[a])); });
    const glm::dvec3 normal = glm::cross(along, points_[c] - points_[a]);
    if (glm::length(normal) <= tolerance_ * glm::length(along)) return false;
    const size_t d =
        farthest([&](const glm::dvec3& p) { return std::abs(glm::dot(normal, p - points_[a])); });
    if (std::abs(glm::dot(normal, points_[d] - points_[a])) <= tolerance_ * glm::length(normal)) return false;
    inside_ = 0.25 * (points_[a] + points_[b] + points_[c] + points_[d]);
    for (const std::array<size_t, 3> corners : {std::array{a, b, c}, {a, b, d}, {a, c, d}, {b, c, d}})
      add(corners[0], corners[1], corners[2]);
    return true;
  }

  void add_point(size_t index) {
    const glm::dvec3& point = points_[index];
    std::set<std::pair<size_t, size_t>> edges;  // of visible faces, in their direction
    std::vector<Face> hidden;
    for (const Face& face : faces_) {
      if (glm::dot(face.normal, point) - face.offset <= tolerance_) {
        hidden.push_back(face);
        continue;
      }
      for (size_t i = 0; i < 3; ++i) edges.emplace(face.corners[i], face.corners[(i + 1) % 3]);
    }
    if (hidden.size() == faces_.size()) return;
    faces_ = std::move(hidden);
    for (const auto& [from, to] : edges)
      if (!edges.contains({to, from})) add(from, to, index);
  }

  std::vector<MeshData::Triangle> triangles() const {
    std::vector<MeshData::Triangle> all;
    for (const Face& face : faces_) all.push_back(face.corners);
    return all;
  }

 private:
  template <typename Measure>
  size_t farthest(Measure&& measure) const {
    size_t best = 0;
    double most = measure(points_[0]);
    for (size_t i = 1; i < points_.size(); ++i)
      if (const double value = measure(points_[i]); value > most) {
        most = value;
        best = i;
      }
    return best;
  }

  void add(size_t a, size_t b, size_t c) {
    glm::dvec3 normal = glm::cross(points_[b] - points_[a], points_[c] - points_[a]);
    const double length = glm::length(normal);
    if (length > 0) normal /= length;
    if (glm::dot(normal, inside_ - points_[a]) > 0) {
      std::swap(b, c);
      normal = -normal;
    }
    faces_.push_back({{static_cast<uint32_t>(a), static_cast<uint32_t>(b), static_cast<uint32_t>(c)},
                      normal,
                      glm::dot(normal, points_[a])});
  }

  std::vector<glm::dvec3> points_;
  std::vector<Face> faces_;
  glm::dvec3 inside_{0};
  double tolerance_ = 0;
};

}  // namespace

Result<std::vector<MeshData::Triangle>> convex_hull(const std::vector<glm::vec3>& points) {
  if (points.size() < 4) return Error{"it has no faces, and fewer than 4 vertices"};
  if (points.size() > kMaxPoints)
    return Error{"it has no faces, and more than " + std::to_string(kMaxPoints) + " vertices"};
  Hull hull(points);
  if (!hull.start()) return Error{"it has no faces, and its vertices lie in a plane"};
  for (size_t i = 0; i < points.size(); ++i) hull.add_point(i);
  return hull.triangles();
}

}  // namespace fire3dv::convert
