#include "renderer/scene/derived.h"

namespace fire3dv::scene {

Derived derive(const Scene& scene, const LoadProgress& progress) {
  Derived derived;
  derived.clusters = cut_clusters(scene, [&](size_t done) {
    if (progress) progress("clusters", done, scene.primitives.size());
  });
  derived.casters = casters_of(scene);
  return derived;
}

}  // namespace fire3dv::scene
