// Silhouettes of instances on the CPU: which instances have one, and the memory of their bits.
//
// Bits of the instances, 32 to a word: word slot / 32 of all pixels, bit slot % 32. Behind them one word for
// 32 slots: bits of the instances of which a part is outside of the image.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/passes/outputs/planes_and_boxes.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {
class SceneEdits;
}

namespace fire3dv::passes {

// Nodes with a mesh, in order: the index of a node is its slot.
std::vector<uint32_t> nodes_with_silhouettes(const scene::Scene& scene);

constexpr uint32_t silhouette_words(uint32_t slots) {
  return (slots + 31) / 32;
}

// Largest alpha of a primitive's surface: textures and vertex colours only lower it. edits null: none.
float largest_alpha(const scene::Scene& scene, const scene::SceneEdits* edits, uint32_t node,
                    const scene::Primitive& primitive);

// Nodes with triangles of which none is ever in labels: all are blended, with no more alpha than this.
// Hidden nodes are left out. edits null: none.
std::vector<uint32_t> nodes_without_labels(const scene::Scene& scene, const scene::SceneEdits* edits,
                                           float label_alpha);

// Most bytes of an image's silhouettes.
constexpr uint64_t kMaxSilhouetteBytes = uint64_t{256} << 20;
uint64_t silhouette_bytes(uint32_t slots, uint32_t width, uint32_t height);

// Adds the range of kAmodal behind the planes.
void add_silhouettes(std::vector<PlaneRange>& places, uint32_t slots, uint32_t width, uint32_t height);

}  // namespace fire3dv::passes
