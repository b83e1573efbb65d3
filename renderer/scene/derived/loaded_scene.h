// Loaded scene: a scene with its derived data (clusters, casters, LOD), validated and extended as one.
// Derived data are a pure function of the scene, slower to compute than to load, and therefore part of the
// scene's cache entry (scene_cache.h). Casters and validation have their own source files.
#pragma once

#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/scene/clusters/clusters.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// Shadow caster class of a mesh: closed, planar or open. It decides which faces a conservative shadow map
// contains; see shaders/shading/shadow_maps.glsl.
enum class CasterShape : uint8_t {
  // Watertight with outward winding: light enters it through back faces.
  closed,
  planar,  // in one plane: casts no shadow on itself
  open,    // all other meshes
};

struct Caster {
  CasterShape shape = CasterShape::open;
  glm::vec4 plane_node{0};  // planar: dot(xyz, p) + w = 0 in node space
};

// Classifies a mesh. Alpha-masked, blended and deformed primitives make it open. Vertices are welded if their
// positions are equal; at borders, if they are equal except for rounding.
Caster classify_caster(const Scene& scene, const Mesh& mesh);

// Classifies all meshes of the scene.
std::vector<Caster> classify_casters(const Scene& scene);

struct Derived {
  ClusteredGeometry clusters;
  std::vector<Caster> casters;  // one per mesh
  bool has_levels = false;      // clusters include LOD
};

struct LoadedScene {
  Scene scene;
  Derived derived;
};

// LOD policy. Simplification takes seconds per million triangles.
enum class Levels : uint8_t {
  none,
  automatic_levels,  // at least 20 M rendered triangles from at most 1 M in the file
  all,
};
bool needs_levels(const Scene& scene, Levels levels);

// Runs on all cores; deterministic.
Derived derive(const Scene& scene, Levels levels = Levels::automatic_levels,
               const LoadProgress& progress = {});

// Validation of a scene that was read from a cache file: all indices, ranges and values. The glTF loader
// establishes the same invariants, and renderers rely on them without further checks.
// Runs on all cores. The error names the array, not the file.
Result<void> check_scene(const Scene& scene);
// Precondition: check_scene() succeeded.
Result<void> check_derived(const Scene& scene, const Derived& derived);

// A node that the file does not have. parent: kNone for the root. Returns its index.
uint32_t add_node(Scene& scene, const std::string& name, uint32_t parent, const glm::mat4& parent_from_node);

// Puts one scene behind another, with all that is derived of both: what was found for each is not looked for
// again. The asset's roots become children of `parent`. Its nodes are found by their paths alone: a name in
// it must not take that name from a node that was there before. Its animations are left out. What the scene
// held before keeps its places. The error says what there would be too much of.
Result<void> add_below(LoadedScene& to, const LoadedScene& asset, uint32_t parent);

}  // namespace fire3dv::scene
