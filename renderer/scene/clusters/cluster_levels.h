// Cluster LOD hierarchy: groups of adjacent clusters are simplified to about half and cut into clusters again
// (docs/design/levels-of-detail.md). Group borders are locked, and all levels reuse the file's vertices
// bit-exactly. Error and sphere of a group enclose those of its sources. A cluster is drawn if the error of
// made_by is below the limit and that of merged_by is not. This local test selects a watertight set without
// seams (shaders/visibility/level_choice.glsl).
//
// Rays hit LOD 0 triangles, so shadow rays start off the surface by twice surface_error (the factor covers
// sampling). Shadow maps of large scenes contain coarser triangles, dilated by the allowed error
// (shaders/visibility/light_raster.glsl); shadow edges move by at most a quarter of a texel.
#pragma once

#include <functional>

#include "renderer/scene/clusters/clusters.h"

namespace fire3dv::scene {

// Appends coarser clusters, their vertices, triangles and groups to the result of cut_clusters(). Covers
// opaque and alpha-masked triangles of undeformed nodes. The result is independent of the number of threads.
void add_cluster_levels(const Scene& scene, ClusteredGeometry& geometry,
                        const std::function<void(size_t done, size_t total)>& progress = {});

}  // namespace fire3dv::scene
