// Member lists of Derived, as those of Scene in model/scene_fields.h.
#pragma once

#include "renderer/scene/derived/loaded_scene.h"

namespace fire3dv::scene {

template <typename Visit>
void visit_arrays(Derived& derived, Visit&& visit) {
  ClusteredGeometry& clusters = derived.clusters;
  visit(clusters.source_vertices);
  visit(clusters.clusters);
  visit(clusters.level_groups);
  visit(clusters.ray_boxes);
  visit(clusters.triangles);
  visit(clusters.primitives);
}

template <typename Visit>
void visit_members(Caster& c, Visit&& visit) {
  visit(c.shape, c.plane_node);
}

template <typename Visit>
void visit_members(Derived& d, Visit&& visit) {
  visit(d.casters, d.has_levels);
}

}  // namespace fire3dv::scene
