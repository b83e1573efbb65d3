// Silhouettes of instances on the CPU: which instances have one, and the memory of their bits.
//
// Bits of the instances, 32 to a word: word slot / 32 of all pixels, bit slot % 32. Behind them one word for
// 32 slots: bits of the instances of which a part is outside of the image.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/passes/outputs/planes_and_boxes.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::passes {

// Nodes with a mesh, in order: the index of a node is its slot.
std::vector<uint32_t> nodes_with_silhouettes(const scene::Scene& scene);

constexpr uint32_t silhouette_words(uint32_t slots) {
  return (slots + 31) / 32;
}

// Nodes with triangles of which none is ever in labels: all are blended, with no more alpha than this.
std::vector<uint32_t> nodes_without_labels(const scene::Scene& scene, float label_alpha);

// Most bytes of an image's silhouettes.
constexpr uint64_t kMaxSilhouetteBytes = uint64_t{256} << 20;
uint64_t silhouette_bytes(uint32_t slots, uint32_t width, uint32_t height);

// Adds the range of kAmodal behind the planes.
void add_silhouettes(std::vector<PlaneRange>& places, uint32_t slots, uint32_t width, uint32_t height);

}  // namespace fire3dv::passes
