#include "convert/mjcf/assets/mesh_inertia.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

namespace fire3dv::convert {
namespace {

constexpr double kMinVolume = 1e-15;
// MuJoCo's limit, whatever the size: the frame of a small mesh may keep the axes of its file.
constexpr double kMaxOffDiagonal = 1e-12;

struct Facet {
  glm::dvec3 a, b, c;
  glm::dvec3 centre() const { return (a + b + c) / 3.0; }
  glm::dvec3 twice_area() const { return glm::cross(b - a, c - a); }
};

// Volume of the pyramid from the origin, or the area of a shell.
double weight(const Facet& facet, MeshVolume kind) {
  const glm::dvec3 twice_area = facet.twice_area();
  if (kind == MeshVolume::shell) return glm::length(twice_area) / 2;
  const double volume = glm::dot(facet.centre(), twice_area) / 6;
  return kind == MeshVolume::legacy ? std::abs(volume) : volume;
}

// Jacobi's method; columns of `axes` are the eigenvectors.
void diagonalise(glm::dmat3& matrix, glm::dmat3& axes) {
  axes = glm::dmat3(1);
  for (int sweep = 0; sweep < 60; ++sweep) {
    int p = 0, q = 1;
    for (const auto& [i, j] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)})
      if (std::abs(matrix[i][j]) > std::abs(matrix[p][q])) std::tie(p, q) = std::pair(i, j);
    const double off = matrix[p][q];
    if (std::abs(off) <= kMaxOffDiagonal) return;
    const double angle = 0.5 * std::atan2(2 * off, matrix[q][q] - matrix[p][p]);
    glm::dmat3 turn(1);
    turn[p][p] = turn[q][q] = std::cos(angle);
    turn[q][p] = std::sin(angle);
    turn[p][q] = -std::sin(angle);
    matrix = glm::transpose(turn) * matrix * turn;
    axes = axes * turn;
  }
}

}  // namespace

void add_mesh_inertia(const std::vector<glm::dvec3>& vertices, const std::vector<MeshData::Triangle>& faces,
                      MeshVolume kind, MjcfMesh& mesh) {
  const auto facet = [&](const MeshData::Triangle& face, const glm::dvec3& origin) {
    return Facet{vertices[face[0]] - origin, vertices[face[1]] - origin, vertices[face[2]] - origin};
  };
  glm::dvec3 middle(0);
  double area = 0;
  for (const MeshData::Triangle& face : faces) {
    const Facet f = facet(face, glm::dvec3(0));
    const double part = glm::length(f.twice_area()) / 2;
    middle += part * f.centre();
    area += part;
  }
  if (area > 0) middle /= area;
  double volume = 0;
  glm::dvec3 moment(0);
  for (const MeshData::Triangle& face : faces) {
    const Facet f = facet(face, middle);
    const double part = weight(f, kind);
    volume += part;
    moment += part * (kind == MeshVolume::shell ? 1.0 : 0.75) * f.centre();
  }
  const glm::dvec3 centre = middle + (volume > kMinVolume ? moment / volume : glm::dvec3(0));

  glm::dmat3 products(0);
  volume = 0;
  for (const MeshData::Triangle& face : faces) {
    const Facet f = facet(face, centre);
    const double part = weight(f, kind);
    volume += part;
    const glm::dvec3 sum = f.a + f.b + f.c;
    products += part / (kind == MeshVolume::shell ? 12 : 20) *
                (glm::outerProduct(sum, sum) + glm::outerProduct(f.a, f.a) + glm::outerProduct(f.b, f.b) +
                 glm::outerProduct(f.c, f.c));
  }
  glm::dmat3 axes;
  diagonalise(products, axes);
  // A small product is a large moment about the axis; MuJoCo sorts moments downwards.
  std::array<int, 3> order{0, 1, 2};
  std::stable_sort(order.begin(), order.end(), [&](int i, int j) { return products[i][i] < products[j][j]; });
  glm::dmat3 sorted(axes[order[0]], axes[order[1]], axes[order[2]]);
  if (glm::determinant(sorted) < 0) sorted[2] = -sorted[2];
  mesh.inertia_pose = {centre, glm::normalize(glm::quat_cast(sorted))};
  mesh.volume = volume;
  for (int i = 0; i < 3; ++i) {
    // Half extent of a box: its product of inertia is mass * half^2 / 3.
    const double product = products[order[static_cast<size_t>(i)]][order[static_cast<size_t>(i)]];
    mesh.inertia_half[i] = volume > kMinVolume ? std::sqrt(std::max(0.0, 3 * product / volume)) : 0;
  }
  mesh.low = glm::dvec3(1e300);
  mesh.high = glm::dvec3(-1e300);
  const glm::dquat to_inertia = glm::conjugate(mesh.inertia_pose.rotation);
  for (const glm::dvec3& vertex : vertices) {
    const glm::dvec3 local = to_inertia * (vertex - centre);
    mesh.low = glm::min(mesh.low, local);
    mesh.high = glm::max(mesh.high, local);
  }
  mesh.bound_radius = glm::length(glm::max(glm::abs(mesh.low), glm::abs(mesh.high)));
}

}  // namespace fire3dv::convert
