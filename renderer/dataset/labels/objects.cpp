#include "renderer/dataset/labels/objects.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <tuple>

#include "base/nearest_names.h"
#include "base/plural.h"
#include "base/text.h"
#include "renderer/scene/clusters/clusters.h"
#include "renderer/scene/model/node_names.h"
#include "renderer/scene/model/vertices.h"

namespace fire3dv::dataset {
namespace {

bool has_triangles(const scene::Scene& scene, const scene::Mesh& mesh) {
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    const scene::Primitive& primitive = scene.primitives[p];
    if (primitive.topology == scene::Topology::triangles && primitive.index_count > 0) return true;
  }
  return false;
}

struct Shape {
  std::array<double, 3> scale;
  bool is_sheared;
};
Shape shape_of(const glm::mat4& world_from_node) {
  const glm::dmat3 m(world_from_node);
  Shape shape{{glm::length(m[0]), glm::length(m[1]), glm::length(m[2])}, false};
  constexpr double kMaxCosine = 1e-4;
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3;
    const double cosine =
        glm::dot(m[a], m[b]) / (shape.scale[static_cast<size_t>(a)] * shape.scale[static_cast<size_t>(b)]);
    if (!(std::abs(cosine) < kMaxCosine)) shape.is_sheared = true;
  }
  if (glm::determinant(m) < 0) shape.scale[0] = -shape.scale[0];
  // Rotations of rest poses have errors of single precision: equal sizes stay equal.
  for (double& each : shape.scale) {
    const double rounded = std::round(each * 1e5) / 1e5;
    if (std::abs(rounded - each) < 4e-6) each = rounded;
  }
  return shape;
}

using Point = std::array<double, 3>;

double squared_distance(const Point& a, const Point& b) {
  double sum = 0;
  for (size_t i = 0; i < 3; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

// Largest distance of two points. Points far from the centre come first, so that the search ends early;
// round bodies of many vertices end at the limit, with an error far below the size of a triangle.
double diameter_of(std::vector<Point> points) {
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 2) return 0;
  Point low = points.front(), high = low;
  for (const Point& point : points) {
    for (size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], point[i]);
      high[i] = std::max(high[i], point[i]);
    }
  }
  const Point centre{(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2};
  std::vector<std::pair<double, Point>> by_radius;
  for (const Point& point : points) by_radius.emplace_back(std::sqrt(squared_distance(point, centre)), point);
  std::sort(by_radius.begin(), by_radius.end(), std::greater<>());
  constexpr uint64_t kMaxPairs = 50'000'000;
  uint64_t pairs = 0;
  double best = 0;
  for (size_t i = 1; i < by_radius.size() && pairs < kMaxPairs; ++i) {
    if (by_radius[0].first + by_radius[i].first <= best) break;
    for (size_t j = 0; j < i; ++j, ++pairs) {
      if (by_radius[i].first + by_radius[j].first <= best) break;
      best = std::max(best, std::sqrt(squared_distance(by_radius[i].second, by_radius[j].second)));
    }
  }
  return best;
}

template <typename Visit>
void visit_triangles(const scene::Scene& scene, const scene::Mesh& mesh, Visit&& visit) {
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    const scene::Primitive& primitive = scene.primitives[p];
    if (primitive.topology == scene::Topology::triangles && primitive.index_count > 0) visit(primitive);
  }
}

void measure(const scene::Scene& scene, const scene::Mesh& mesh, const double (&scale)[3], Object& object) {
  std::vector<Point> points;
  visit_triangles(scene, mesh, [&](const scene::Primitive& primitive) {
    for (uint32_t v = primitive.first_vertex; v < primitive.first_vertex + primitive.vertex_count; ++v) {
      Point point{};
      for (int i = 0; i < 3; ++i)
        point[static_cast<size_t>(i)] = double{scene.positions[v][i]} * scale[i] * kMillimetres;
      points.push_back(point);
    }
  });
  for (size_t i = 0; i < 3; ++i) {
    double low = points.empty() ? 0 : points[0][i], high = low;
    for (const Point& point : points) {
      low = std::min(low, point[i]);
      high = std::max(high, point[i]);
    }
    object.min_mm[i] = low;
    object.size_mm[i] = high - low;
  }
  object.diameter_mm = diameter_of(std::move(points));
}

Result<std::set<uint32_t>> find_wanted(const scene::Scene& scene, std::span<const std::string> wanted) {
  std::set<uint32_t> nodes;
  for (const std::string& name : wanted) {
    std::vector<bool> is_below(scene.nodes.size());
    bool found = false;
    for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
      const scene::Node& node = scene.nodes[n];
      is_below[n] =
          node.name == name || node.path == name || (node.parent != scene::kNone && is_below[node.parent]);
      if (!is_below[n]) continue;
      found = true;
      nodes.insert(n);
    }
    if (!found)
      return Error{"--object: no node has the name or path " + quote(name) +
                   name_hint(name, scene::node_names(scene, name), "nodes")};
  }
  return nodes;
}

void warn_of(const std::vector<std::string>& names, const char* what, Description& description) {
  if (names.empty()) return;
  description.warnings.push_back(counted(names.size(), "node") + " " + what + ": " + list_names(names));
}

}  // namespace

Result<void> find_objects(const scene::Scene& scene, std::span<const std::string> wanted,
                          Description& description, const std::set<uint32_t>& without) {
  const auto chosen = find_wanted(scene, wanted);
  if (!chosen) return chosen.error();
  std::map<std::tuple<uint32_t, std::array<double, 3>>, uint32_t> object_of_shape;
  std::vector<std::string> sheared, deforming;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    const scene::Node& node = scene.nodes[n];
    if (node.mesh == scene::kNone || (!wanted.empty() && !chosen->contains(n)) || without.contains(n))
      continue;
    const scene::Mesh& mesh = scene.meshes[node.mesh];
    if (mesh.unbounded || !has_triangles(scene, mesh)) continue;
    const Shape shape = shape_of(node.world_from_node);
    if (shape.is_sheared) sheared.push_back(node.path);
    const bool deforms = scene::is_deformed(node);
    if (deforms) deforming.push_back(node.path);
    const auto [at, is_new] = object_of_shape.try_emplace({node.mesh, shape.scale},
                                                          static_cast<uint32_t>(description.objects.size()));
    Instance instance;
    instance.number = n + 1;
    instance.object = at->second;
    instance.semantic = node.semantic;
    instance.name = node.name;
    instance.path = node.path;
    std::copy(shape.scale.begin(), shape.scale.end(), instance.scale);
    if (is_new) {
      Object object;
      object.id = at->second + 1;
      object.name = !mesh.name.empty() ? mesh.name : !node.name.empty() ? node.name : "mesh";
      object.deforms = deforms;
      measure(scene, mesh, instance.scale, object);
      description.objects.push_back(object);
    }
    description.instances.push_back(instance);
  }
  if (description.instances.empty())
    return Error{"the scene has no node with triangles that could be labelled: name others with --object"};
  warn_of(sheared, "are sheared: their poses are no rotations, and R is the nearest one by columns",
          description);
  warn_of(deforming, "deform (skin or morph targets): their models are the rest poses", description);
  return {};
}

std::vector<uint8_t> encode_model(const scene::Scene& scene, const Description& description, size_t object) {
  const auto instance = std::find_if(description.instances.begin(), description.instances.end(),
                                     [&](const Instance& each) { return each.object == object; });
  const scene::Mesh& mesh = scene.meshes[scene.nodes[instance->number - 1].mesh];
  uint64_t vertices = 0, triangles = 0;
  visit_triangles(scene, mesh, [&](const scene::Primitive& primitive) {
    vertices += primitive.vertex_count;
    triangles += primitive.index_count / 3;
  });
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment millimetres\nelement vertex " +
      std::to_string(vertices) +
      "\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\n"
      "property float nz\nelement face " +
      std::to_string(triangles) + "\nproperty list uchar int vertex_indices\nend_header\n";
  std::vector<uint8_t> file(header.begin(), header.end());
  file.reserve(header.size() + vertices * 24 + triangles * 13);
  const auto put = [&](auto value) {
    static_assert(std::endian::native == std::endian::little);
    uint8_t bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    file.insert(file.end(), bytes, bytes + sizeof value);
  };
  const glm::dvec3 scale(instance->scale[0], instance->scale[1], instance->scale[2]);
  visit_triangles(scene, mesh, [&](const scene::Primitive& primitive) {
    for (uint32_t v = primitive.first_vertex; v < primitive.first_vertex + primitive.vertex_count; ++v) {
      const glm::dvec3 position = glm::dvec3(scene.positions[v]) * scale * kMillimetres;
      glm::dvec3 normal = glm::dvec3(scene::normal_of(scene.frames[v])) / scale;
      const double length = glm::length(normal);
      normal = length > 0 ? normal / length : glm::dvec3(0, 0, 1);
      for (int i = 0; i < 3; ++i) put(static_cast<float>(position[i]));
      for (int i = 0; i < 3; ++i) put(static_cast<float>(normal[i]));
    }
  });
  uint32_t base = 0;
  const bool is_mirrored = scale.x < 0;
  visit_triangles(scene, mesh, [&](const scene::Primitive& primitive) {
    for (uint32_t i = 0; i + 2 < primitive.index_count; i += 3) {
      put(uint8_t{3});
      for (uint32_t corner = 0; corner < 3; ++corner) {
        const uint32_t of = is_mirrored ? 2 - corner : corner;
        put(static_cast<int32_t>(base + scene.indices[primitive.first_index + i + of]));
      }
    }
    base += primitive.vertex_count;
  });
  return file;
}

}  // namespace fire3dv::dataset
