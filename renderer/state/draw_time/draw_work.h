// Estimate of the work of drawing content in one view: counts whose cost on one device is about the same
// each. Elements are sampled, so that an estimate costs little however large the content is.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "protocol/wire/marker.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::state {

struct DrawWork {
  double vertices = 0;   // transformed by vertex shaders or by the cluster rasteriser
  double fragments = 0;  // covered pixels, with those that other surfaces hide
  double rebuilt = 0;    // triangles whose acceleration structures are built again

  DrawWork& operator+=(const DrawWork& other) {
    vertices += other.vertices;
    fragments += other.fragments;
    rebuilt += other.rebuilt;
    return *this;
  }
};
inline DrawWork operator*(DrawWork work, double factor) {
  return {work.vertices * factor, work.fragments * factor, work.rebuilt * factor};
}

struct WorkView {
  glm::mat4 clip_from_world{1};
  glm::vec2 size_px{1};
};

// Upper bound of the vertices that a marker draws, by the levels of detail of the marker pass.
uint64_t max_marker_vertices(const wire::Marker& marker);
// Number of bytes of all texts: an upper bound of the glyphs.
uint64_t text_bytes(const wire::Marker& marker);

DrawWork marker_work(const wire::Marker& marker, const glm::mat4& world_from_marker, const WorkView& view);

// Of the mesh at one node. Levels of detail and occlusion are ignored.
DrawWork mesh_work(const scene::Scene& scene, const scene::Mesh& mesh, const glm::mat4& world_from_node,
                   const WorkView& view);
// Triangles of the mesh.
uint64_t triangle_count(const scene::Scene& scene, const scene::Mesh& mesh);

}  // namespace fire3dv::state
