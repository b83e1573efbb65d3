#include "convert/mjcf/assets/builtin_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "convert/mjcf/assets/convex_hull.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

constexpr double kMeshPi = std::numbers::pi;

// Grid of vertices with rows that are closed or open, and its triangles.
class Grid {
 public:
  Grid(MeshData& mesh, uint32_t columns, bool is_closed)
      : mesh_(mesh), columns_(columns), quads_(is_closed ? columns : columns - 1) {}

  void join(uint32_t lower, uint32_t upper) {  // first vertices of two rows; upper is to the left
    for (uint32_t i = 0; i < quads_; ++i) {
      const uint32_t next = (i + 1) % columns_;
      mesh_.faces.push_back({lower + i, lower + next, upper + next});
      mesh_.faces.push_back({lower + i, upper + next, upper + i});
    }
  }
  void cap(uint32_t row, uint32_t tip, bool is_left) {
    for (uint32_t i = 0; i < quads_; ++i) {
      const uint32_t next = (i + 1) % columns_;
      mesh_.faces.push_back(is_left ? MeshData::Triangle{row + i, row + next, tip}
                                    : MeshData::Triangle{row + next, row + i, tip});
    }
  }

 private:
  MeshData& mesh_;
  uint32_t columns_, quads_;
};

uint32_t add(MeshData& mesh, const glm::dvec3& vertex) {
  mesh.vertices.emplace_back(vertex);
  return static_cast<uint32_t>(mesh.vertices.size() - 1);
}

// Power of a cosine or sine that keeps the sign.
double power(double value, double exponent) {
  return std::copysign(std::pow(std::abs(value), exponent), value);
}

Result<MeshData> sphere(int subdivisions) {
  const double golden = (1 + std::sqrt(5.0)) / 2;
  MeshData mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const double a : {-1.0, 1.0})
      for (const double b : {-golden, golden}) {
        glm::dvec3 vertex(0);
        vertex[axis] = a;
        vertex[(axis + 1) % 3] = b;
        add(mesh, glm::normalize(vertex));
      }
  Result<std::vector<MeshData::Triangle>> faces = convex_hull(mesh.vertices);
  if (!faces) return faces.error();
  mesh.faces = std::move(*faces);
  for (int level = 0; level < subdivisions; ++level) {
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
    const auto middle = [&](uint32_t a, uint32_t b) {
      const auto [known, is_new] = middles.try_emplace(std::minmax(a, b), 0);
      if (is_new) known->second = add(mesh, glm::normalize(glm::dvec3(mesh.vertices[a] + mesh.vertices[b])));
      return known->second;
    };
    std::vector<MeshData::Triangle> finer;
    for (const auto& [a, b, c] : std::exchange(mesh.faces, {})) {
      const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.faces = std::move(finer);
  }
  return mesh;
}

// Upper half of a subdivided octahedron, projected to the sphere, with a flat lower side.
MeshData hemisphere(int resolution) {
  MeshData mesh;
  const auto rows = static_cast<uint32_t>(resolution) + 1;
  add(mesh, {0, 0, 1});
  uint32_t above = 0;  // first vertex of the ring above
  for (uint32_t ring = 1; ring <= rows; ++ring) {
    const auto first = static_cast<uint32_t>(mesh.vertices.size());
    for (uint32_t i = 0; i < 4 * ring; ++i) {
      const double share = static_cast<double>(i % ring) / ring,
                   height = 1 - static_cast<double>(ring) / rows;
      const glm::dvec2 corners[] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
      const glm::dvec2 at = glm::mix(corners[i / ring], corners[(i / ring + 1) % 4], share) * (1 - height);
      add(mesh, glm::normalize(glm::dvec3(at, height)));
    }
    const auto outer = [&](uint32_t i) { return first + i % (4 * ring); };
    const auto inner = [&](uint32_t i) { return ring == 1 ? 0 : above + i % (4 * (ring - 1)); };
    for (uint32_t side = 0; side < 4; ++side)
      for (uint32_t i = 0; i < ring; ++i) {
        const uint32_t out = side * ring + i, in = side * (ring - 1) + i;
        mesh.faces.push_back({inner(in), outer(out), outer(out + 1)});
        if (i + 1 < ring) mesh.faces.push_back({inner(in), outer(out + 1), inner(in + 1)});
      }
    above = first;
  }
  Grid(mesh, 4 * rows, true).cap(above, add(mesh, {0, 0, 0}), false);
  return mesh;
}

MeshData supersphere(uint32_t resolution, double east_west, double north_south) {
  MeshData mesh;
  const uint32_t south = add(mesh, {0, 0, -1});
  for (uint32_t row = 1; row < resolution; ++row) {
    const double v = kMeshPi * (static_cast<double>(row) / resolution - 0.5);
    for (uint32_t i = 0; i < resolution; ++i) {
      const double u = kMeshPi * (2.0 * i / resolution - 1), wide = power(std::cos(v), north_south);
      add(mesh, {wide * power(std::cos(u), east_west), wide * power(std::sin(u), east_west),
                 power(std::sin(v), north_south)});
    }
  }
  const uint32_t north = add(mesh, {0, 0, 1});
  Grid grid(mesh, resolution, true);
  grid.cap(1, south, false);
  for (uint32_t row = 1; row + 1 < resolution; ++row)
    grid.join(1 + (row - 1) * resolution, 1 + row * resolution);
  grid.cap(1 + (resolution - 2) * resolution, north, true);
  return mesh;
}

MeshData supertorus(uint32_t resolution, double radius, double minor, double major) {
  MeshData mesh;
  for (uint32_t row = 0; row < resolution; ++row) {  // around the tube
    const double v = 2 * kMeshPi * row / resolution, wide = 1 + radius * power(std::cos(v), minor);
    for (uint32_t i = 0; i < resolution; ++i) {
      const double u = 2 * kMeshPi * i / resolution;
      add(mesh, {wide * power(std::cos(u), major), wide * power(std::sin(u), major),
                 radius * power(std::sin(v), minor)});
    }
  }
  Grid grid(mesh, resolution, true);
  for (uint32_t row = 0; row < resolution; ++row)
    grid.join(row * resolution, (row + 1) % resolution * resolution);
  return mesh;
}

// Centres of cells over a range of angles, on the unit sphere around -Z.
MeshData wedge(uint32_t columns, uint32_t rows, const glm::dvec2& half_deg, double fovea) {
  const auto edge = [&](uint32_t i, uint32_t count, double half) {
    const double x = 2.0 * i / count - 1;
    return glm::radians(half) * glm::mix(x, std::pow(x, 5), fovea);
  };
  MeshData mesh;
  for (uint32_t i = 0; i < columns; ++i)
    for (uint32_t k = 0; k < rows; ++k) {
      const double azimuth = (edge(i, columns, half_deg.x) + edge(i + 1, columns, half_deg.x)) / 2,
                   elevation = (edge(k, rows, half_deg.y) + edge(k + 1, rows, half_deg.y)) / 2;
      add(mesh, {std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                 -std::cos(elevation) * std::cos(azimuth)});
    }
  return mesh;
}

MeshData plate(uint32_t columns, uint32_t rows) {
  MeshData mesh;
  for (uint32_t k = 0; k < rows; ++k)
    for (uint32_t i = 0; i < columns; ++i)
      add(mesh, {(2 * i + 1.0) / columns - 1, (2 * k + 1.0) / rows - 1, -1});
  for (uint32_t k = 0; k + 1 < rows; ++k) Grid(mesh, columns, false).join(k * columns, (k + 1) * columns);
  return mesh;
}

MeshData cone(uint32_t edges, double top) {
  MeshData mesh;
  const auto ring = [&](double radius, double z) {
    for (uint32_t i = 0; i < edges; ++i) {
      const double angle = 2 * kMeshPi * i / edges;
      add(mesh, {radius * std::cos(angle), radius * std::sin(angle), z});
    }
  };
  const auto fan = [&](uint32_t first, bool is_upper) {
    for (uint32_t i = 1; i + 1 < edges; ++i)
      mesh.faces.push_back(is_upper ? MeshData::Triangle{first, first + i, first + i + 1}
                                    : MeshData::Triangle{first, first + i + 1, first + i});
  };
  ring(1, -1);
  fan(0, false);
  if (top > 0) {
    ring(top, 1);
    Grid(mesh, edges, true).join(0, edges);
    fan(edges, true);
  } else {
    Grid(mesh, edges, true).cap(0, add(mesh, {0, 0, 1}), true);
  }
  return mesh;
}

// Bounds of one parameter.
struct Range {
  double low, high;
};
constexpr double kMaxExponent = 1000, kMaxResolution = 1000, kMaxPlate = 2000, kMaxWedge = 70;
const std::map<std::string, std::vector<Range>> kParameters = {
    {"sphere", {{0, 4}}},
    {"hemisphere", {{0, 10}}},
    {"cone", {{3, 2000}, {0, 1e6}}},
    {"supersphere", {{3, kMaxResolution}, {0, kMaxExponent}, {0, kMaxExponent}}},
    {"supertorus", {{3, kMaxResolution}, {0, 1}, {0, kMaxExponent}, {0, kMaxExponent}}},
    {"wedge", {{1, kMaxWedge}, {1, kMaxWedge}, {0, 180}, {0, 90}, {0, 1}}},
    {"plate", {{1, kMaxPlate}, {1, kMaxPlate}}}};

}  // namespace

Result<MeshData> builtin_mesh(const std::string& kind, const std::vector<double>& parameters) {
  const auto known = kParameters.find(kind);
  if (known == kParameters.end()) return Error{"the builtin shape " + quote(kind) + " is unknown"};
  const std::vector<Range>& ranges = known->second;
  if (parameters.size() != ranges.size())
    return Error{"the builtin shape " + quote(kind) + " needs " + std::to_string(ranges.size()) +
                 " numbers in params, instead of " + std::to_string(parameters.size())};
  for (size_t i = 0; i < ranges.size(); ++i)
    if (!(parameters[i] >= ranges[i].low && parameters[i] <= ranges[i].high))
      return Error{"number " + std::to_string(i + 1) + " of params is not from " +
                   std::to_string(static_cast<int>(ranges[i].low)) + " to " +
                   std::to_string(static_cast<int>(ranges[i].high))};
  const auto count = [&](size_t i) { return static_cast<uint32_t>(parameters[i]); };
  const auto p = [&](size_t i) { return parameters[i]; };
  if (kind == "sphere") return sphere(static_cast<int>(count(0)));
  if (kind == "hemisphere") return hemisphere(static_cast<int>(count(0)));
  if (kind == "cone") return cone(count(0), p(1));
  if (kind == "supersphere") return supersphere(count(0), p(1), p(2));
  if (kind == "supertorus") return supertorus(count(0), p(1), p(2), p(3));
  if (kind == "wedge") return wedge(count(0), count(1), {p(2), p(3)}, p(4));
  return plate(count(0), count(1));
}

}  // namespace fire3dv::convert
