// What drawing needs that follows from the scene alone. It is found once, when a scene is loaded, and takes
// longer than reading the file: so it is kept with the scene in a cache (scene_cache.h).
#pragma once

#include <vector>

#include "renderer/scene/caster_shape.h"
#include "renderer/scene/clusters.h"
#include "renderer/scene/load_gltf.h"

namespace fire3dv::scene {

struct Derived {
  ClusteredGeometry clusters;
  std::vector<Caster> casters;  // of each mesh
  bool has_levels = false;      // clusters hold levels of detail
};

// Which scenes get levels of detail: finding them takes seconds for each million triangles of the file.
enum class Levels : uint8_t {
  none,
  where_they_pay,  // few triangles that are drawn many times, or enough of them for a frame to notice
  all,
};
bool gets_levels(const Scene& scene, Levels levels);

// On all cores; the same whatever their number.
Derived derive(const Scene& scene, Levels levels = Levels::where_they_pay, const LoadProgress& progress = {});

}  // namespace fire3dv::scene
