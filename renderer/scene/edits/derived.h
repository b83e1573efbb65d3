// Derived scene data: clusters, casters and LOD. It is a pure function of the scene, slower to compute than
// to load, and therefore part of the scene's cache entry (scene_cache.h).
#pragma once

#include <vector>

#include "renderer/scene/clusters/clusters.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/shadow_caster.h"

namespace fire3dv::scene {

struct Derived {
  ClusteredGeometry clusters;
  std::vector<Caster> casters;  // one per mesh
  bool has_levels = false;      // clusters include LOD
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

}  // namespace fire3dv::scene
