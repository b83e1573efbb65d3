// Levels of detail: coarser clusters that stand for groups of finer ones where those are too small to tell.
//
// Neighbouring clusters are put into groups. A group's triangles are simplified to about half of them, all
// but its border, and cut into clusters anew; these are put into groups with others, whose borders run
// elsewhere, and so on. Each group has an error and a sphere that hold those of everything it was made from.
// So one question asked of each cluster alone, "is the error of the group that made me small enough here, and
// that of the group that I went into not?", chooses clusters that cover the surface once and meet at equal
// vertices, wherever the levels change: no crack, no seam to hide (shaders/common/level_choice.glsl).
// Vertices of all levels are those of the file, to the bit.
//
// What this means for shadows. Rays meet the file's own triangles; the camera sees points of a surface that
// may lie below those by surface_error. So a ray starts that much farther off the surface (twice, for what
// the samples of an error miss), which moves the edges of shadows by less than the error, and that is less
// than a pixel. In a large scene lights' maps hold coarser triangles, too, by the size of their own texels;
// they reach farther then, to all sides and towards the light, by the error that is allowed
// (shaders/common/light_raster.glsl). What a map lights a ray finds lit, too, but where it passes the edge of
// a caster closer than that: the shadow's edge moves by a quarter of a texel at most.
#pragma once

#include <functional>

#include "renderer/scene/clusters.h"

namespace fire3dv::scene {

// Appends to what cut_clusters() made of the scene: coarser clusters, their vertices and triangles, and
// groups. Of opaque and alpha-masked triangles that some node shows undeformed. The same bytes whatever the
// number of threads.
void add_cluster_levels(const Scene& scene, ClusteredGeometry& geometry,
                        const std::function<void(size_t done, size_t total)>& progress = {});

}  // namespace fire3dv::scene
