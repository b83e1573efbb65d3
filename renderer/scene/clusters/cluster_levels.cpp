#include "renderer/scene/clusters/clusters.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "renderer/scene/clusters/level_steps.h"
#include "renderer/scene/clusters/meshlets.h"
#include "renderer/scene/model/vertices.h"

namespace fire3dv::scene {
namespace {

// A cluster that resisted simplification in this many different groups is not tried again.
constexpr uint32_t kMaxAttempts = 3;

// A cluster to be grouped. Numbers below lod0_clusters_ are LOD 0 clusters of the geometry; coarser clusters
// of the primitive follow.
struct Candidate {
  uint32_t cluster = 0;
  uint32_t attempts = 0;
  std::vector<OpenEdge> edges;
};

struct Simplified {
  std::vector<Cluster> clusters;
  std::vector<std::vector<OpenEdge>> edges;
  std::vector<uint32_t> vertices, triangles;  // of the clusters, concatenated
  LevelGroup group;
};

// Levels of one primitive.
struct Levels {
  uint32_t primitive = 0;
  UsedAttributes used;
  std::vector<uint32_t> welded;  // welded position of each vertex of the primitive
  std::vector<Candidate> candidates;
  ClusterGroups groups;
  std::vector<Cluster> clusters;
  std::vector<uint32_t> vertices, triangles;
  std::vector<LevelGroup> made;
};

class Builder {
 public:
  using Progress = std::function<void(size_t done, size_t total)>;

  Builder(const Scene& scene, ClusteredGeometry& geometry, const Progress& progress)
      : scene_(scene),
        geometry_(geometry),
        progress_(progress),
        lod0_clusters_(static_cast<uint32_t>(geometry.clusters.size())) {}

  void build() {
    choose_primitives();
    parallel_for(all_.size(), [&](size_t i) { begin(all_[i]); });
    while (simplify_once()) {
    }
    for (Levels& levels : all_) append(levels);
  }

 private:
  void choose_primitives() {
    std::vector<bool> shown(scene_.primitives.size());
    for (const Node& node : scene_.nodes) {
      if (node.mesh == kNone || is_deformed(node)) continue;
      const Mesh& mesh = scene_.meshes[node.mesh];
      std::fill_n(shown.begin() + mesh.first_primitive, mesh.primitive_count, true);
    }
    for (uint32_t p = 0; p < scene_.primitives.size(); ++p) {
      const Primitive& primitive = scene_.primitives[p];
      // Blended surfaces are drawn in the forward pass, without clusters.
      if (!shown[p] || primitive.topology != Topology::triangles ||
          drawn_alpha_mode(scene_.materials[primitive.material]) == AlphaMode::blend ||
          geometry_.primitives[p].cluster_count < 2) {
        continue;
      }
      Levels& levels = all_.emplace_back();
      levels.primitive = p;
    }
  }

  void begin(Levels& levels) {
    const Primitive& primitive = scene_.primitives[levels.primitive];
    levels.used = used_attributes(scene_, primitive);
    levels.welded.resize(primitive.vertex_count);
    meshopt_generateVertexRemap(levels.welded.data(), nullptr, primitive.vertex_count,
                                scene_.positions.data() + primitive.first_vertex, primitive.vertex_count,
                                sizeof(glm::vec3));
    const ClusteredPrimitive& cut = geometry_.primitives[levels.primitive];
    std::vector<uint32_t> corners;
    for (uint32_t c = cut.first_cluster; c < cut.first_cluster + cut.cluster_count; ++c) {
      corners.clear();
      each_corner(levels, c, [&](uint32_t vertex) { corners.push_back(welded_of(levels, vertex)); });
      levels.candidates.push_back({c, 0, open_edges(corners)});
    }
  }

  uint32_t welded_of(const Levels& levels, uint32_t vertex) const {
    return levels.welded[vertex - scene_.primitives[levels.primitive].first_vertex];
  }
  const Cluster& cluster_at(const Levels& levels, uint32_t c) const {
    return c < lod0_clusters_ ? geometry_.clusters[c] : levels.clusters[c - lod0_clusters_];
  }
  Cluster& cluster_at(Levels& levels, uint32_t c) {
    return c < lod0_clusters_ ? geometry_.clusters[c] : levels.clusters[c - lod0_clusters_];
  }

  // use: called with vertex indices of the scene.
  template <typename Use>
  void each_corner(const Levels& levels, uint32_t c, const Use& use) const {
    const Cluster& cluster = cluster_at(levels, c);
    const uint32_t* vertices =
        (c < lod0_clusters_ ? geometry_.source_vertices : levels.vertices).data() + cluster.first_vertex;
    const uint32_t* triangles =
        (c < lod0_clusters_ ? geometry_.triangles : levels.triangles).data() + cluster.first_triangle;
    for (uint32_t t = 0; t < cluster.triangle_count; ++t) {
      for (uint32_t shift = 0; shift < 24; shift += 8) use(vertices[triangles[t] >> shift & 255]);
    }
  }

  // Adds one level to all primitives; returns false if nothing was simplified.
  bool simplify_once() {
    struct Task {
      Levels* levels;
      size_t group;
    };
    parallel_for(all_.size(), [&](size_t i) {
      Levels& levels = all_[i];
      std::vector<const std::vector<OpenEdge>*> edges;
      for (const Candidate& candidate : levels.candidates) edges.push_back(&candidate.edges);
      levels.groups = edges.size() > 1 ? group_neighbours(edges) : ClusterGroups{};
    });
    std::vector<Task> tasks;
    for (Levels& levels : all_) {
      for (size_t g = 0; g < levels.groups.count(); ++g) tasks.push_back({&levels, g});
    }
    std::vector<Simplified> results(tasks.size());
    // Each level has half the clusters of the previous one, and a group has about 16 clusters.
    const size_t expected = std::max<size_t>(lod0_clusters_ / 8, groups_done_ + tasks.size());
    parallel_for(
        tasks.size(),
        [&](size_t i) {
          results[i] = simplify(*tasks[i].levels, tasks[i].levels->groups.group(tasks[i].group));
        },
        [&](size_t done) {
          if (progress_) progress_(groups_done_ + done, expected);
        });
    groups_done_ += tasks.size();
    bool simpler = false;
    size_t task = 0;
    for (Levels& levels : all_) {
      std::vector<Candidate> next;
      for (size_t g = 0; g < levels.groups.count(); ++g, ++task) {
        simpler |= !results[task].clusters.empty();
        accept(levels, levels.groups.group(g), results[task], next);
      }
      levels.candidates = std::move(next);
    }
    return simpler;
  }

  Simplified simplify(const Levels& levels, std::span<const uint32_t> members) const {
    SurfacePatch piece;
    std::vector<uint32_t> vertices;
    for (uint32_t member : members) {
      each_corner(levels, levels.candidates[member].cluster, [&](uint32_t v) { piece.indices.push_back(v); });
    }
    vertices = piece.indices;
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    for (uint32_t& index : piece.indices) {
      index =
          static_cast<uint32_t>(std::lower_bound(vertices.begin(), vertices.end(), index) - vertices.begin());
    }
    std::vector<uint32_t> welded;
    for (uint32_t v : vertices) {
      piece.positions.push_back(scene_.positions[v]);
      piece.attributes.push_back(attributes_of(scene_, v));
      welded.push_back(welded_of(levels, v));
    }
    Simplified out;
    const std::vector<uint32_t> simpler = simplify_to_half(piece, welded, levels.used);
    if (simpler.empty()) return out;
    const LevelError step = measure_error(piece, simpler, levels.used);
    out.group = group_around(levels, members, step);
    // An error as large as the group is useless: the cluster would be selected below one pixel only.
    if (!(out.group.error < out.group.radius) || !std::isfinite(out.group.radius)) return out;

    const Meshlets cut(simpler, piece.positions);
    std::vector<uint32_t> corners;
    for (const GrownClusters::Run& run : cut.grown.runs) {
      Cluster cluster = cut.bounded(run, piece.positions);
      cluster.first_vertex = static_cast<uint32_t>(out.vertices.size());
      cluster.first_triangle = static_cast<uint32_t>(out.triangles.size());
      for (uint32_t v = 0; v < run.vertex_count; ++v) {
        out.vertices.push_back(vertices[cut.grown.vertices[run.first_vertex + v]]);
      }
      corners.clear();
      for (uint32_t t = 0; t < run.triangle_count; ++t) {
        const uint8_t* corner = &cut.grown.corners[size_t{3} * (run.first_triangle + t)];
        out.triangles.push_back(corner[0] | uint32_t{corner[1]} << 8 | uint32_t{corner[2]} << 16);
        for (int c = 0; c < 3; ++c)
          corners.push_back(welded[cut.grown.vertices[run.first_vertex + corner[c]]]);
      }
      out.clusters.push_back(cluster);
      out.edges.push_back(open_edges(corners));
    }
    return out;
  }

  // Error and sphere enclose those of all members, so that errors are monotonic from fine to coarse in every
  // view.
  LevelGroup group_around(const Levels& levels, std::span<const uint32_t> members,
                          const LevelError& step) const {
    LevelGroup group;
    std::vector<glm::vec4> spheres;
    for (uint32_t member : members) {
      const Cluster& cluster = cluster_at(levels, levels.candidates[member].cluster);
      if (cluster.made_by == kNone) {
        spheres.emplace_back(cluster.center, cluster.radius);
        continue;
      }
      const LevelGroup& finer = levels.made[cluster.made_by];
      spheres.emplace_back(finer.center, finer.radius);
      group.error = std::max(group.error, finer.error);
      group.surface_error = std::max(group.surface_error, finer.surface_error);
    }
    group.error = group.error * 1.00001f + step.appearance;
    group.surface_error = group.surface_error * 1.00001f + step.surface;
    glm::vec3 center(0);
    for (const glm::vec4& sphere : spheres) center += glm::vec3(sphere) / static_cast<float>(spheres.size());
    group.center = center;
    for (const glm::vec4& sphere : spheres) {
      group.radius = std::max(group.radius, glm::length(glm::vec3(sphere) - center) + sphere.w);
    }
    group.radius = group.radius * 1.00001f + 1e-6f * glm::length(center);
    return group;
  }

  void accept(Levels& levels, std::span<const uint32_t> members, Simplified& simplified,
              std::vector<Candidate>& next) {
    if (simplified.clusters.empty()) {
      for (uint32_t member : members) {
        Candidate& candidate = levels.candidates[member];
        if (++candidate.attempts < kMaxAttempts) next.push_back(std::move(candidate));
      }
      return;
    }
    const auto group = static_cast<uint32_t>(levels.made.size());
    levels.made.push_back(simplified.group);
    for (uint32_t member : members) cluster_at(levels, levels.candidates[member].cluster).merged_by = group;
    const auto first_vertex = static_cast<uint32_t>(levels.vertices.size());
    const auto first_triangle = static_cast<uint32_t>(levels.triangles.size());
    levels.vertices.insert(levels.vertices.end(), simplified.vertices.begin(), simplified.vertices.end());
    levels.triangles.insert(levels.triangles.end(), simplified.triangles.begin(), simplified.triangles.end());
    for (size_t c = 0; c < simplified.clusters.size(); ++c) {
      Cluster& cluster = simplified.clusters[c];
      cluster.made_by = group;
      cluster.first_vertex += first_vertex;
      cluster.first_triangle += first_triangle;
      next.push_back({lod0_clusters_ + static_cast<uint32_t>(levels.clusters.size()), 0,
                      std::move(simplified.edges[c])});
      levels.clusters.push_back(cluster);
    }
  }

  void append(Levels& levels) {
    const auto first_group = static_cast<uint32_t>(geometry_.level_groups.size());
    const auto first_vertex = static_cast<uint32_t>(geometry_.source_vertices.size());
    const auto first_triangle = static_cast<uint32_t>(geometry_.triangles.size());
    auto follow = [&](Cluster& cluster) {
      if (cluster.made_by != kNone) cluster.made_by += first_group;
      if (cluster.merged_by != kNone) cluster.merged_by += first_group;
    };
    ClusteredPrimitive& primitive = geometry_.primitives[levels.primitive];
    for (uint32_t c = 0; c < primitive.cluster_count; ++c)
      follow(geometry_.clusters[primitive.first_cluster + c]);
    primitive.first_level_cluster = static_cast<uint32_t>(geometry_.clusters.size());
    primitive.level_cluster_count = static_cast<uint32_t>(levels.clusters.size());
    for (Cluster& cluster : levels.clusters) {
      follow(cluster);
      cluster.first_vertex += first_vertex;
      cluster.first_triangle += first_triangle;
      geometry_.clusters.push_back(cluster);
    }
    auto join = [](auto& to, auto& from) {
      to.insert(to.end(), from.begin(), from.end());
      from = {};
    };
    join(geometry_.source_vertices, levels.vertices);
    join(geometry_.triangles, levels.triangles);
    join(geometry_.level_groups, levels.made);
  }

  const Scene& scene_;
  ClusteredGeometry& geometry_;
  const Progress& progress_;
  size_t groups_done_ = 0;
  const uint32_t lod0_clusters_;
  std::vector<Levels> all_;
};

}  // namespace

void add_cluster_levels(const Scene& scene, ClusteredGeometry& geometry,
                        const std::function<void(size_t done, size_t total)>& progress) {
  Builder(scene, geometry, progress).build();
}

}  // namespace fire3dv::scene
