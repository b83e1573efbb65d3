#include "renderer/scene/derived.h"

#include "renderer/scene/cluster_levels.h"

namespace fire3dv::scene {

Derived derive(const Scene& scene, bool with_levels, const LoadProgress& progress) {
  Derived derived;
  derived.clusters = cut_clusters(scene, [&](size_t done) {
    if (progress) progress("clusters", done, scene.primitives.size());
  });
  derived.casters = casters_of(scene);
  if (with_levels) {
    add_cluster_levels(scene, derived.clusters, [&](size_t done, size_t total) {
      if (progress) progress("levels of detail", done, total);
    });
  }
  derived.has_levels = with_levels;
  return derived;
}

}  // namespace fire3dv::scene
