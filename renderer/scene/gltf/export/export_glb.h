// Export of an edited scene: its glTF file with edits applied, as one .glb that names no other file.
// Everything that is not edited stays as it is in the file, so that the loaded result has the same nodes,
// materials and geometry, and edited transforms and factors are read back bit by bit where glTF can express
// them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/digest.h"
#include "base/error.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/scene_edits.h"

namespace fire3dv::scene {

struct ExportedTransform {
  glm::mat4 parent_from_node{1};
  bool has_parts = false;  // the matrix is that of these:
  glm::vec3 translation{0};
  glm::quat rotation{1, 0, 0, 0};
  glm::vec3 scale{1};
};

// glTF file whose displayed nodes follow the node that it was added with, in the scene and below it.
struct ExportedAsset {
  std::filesystem::path file = {};  // empty: not known, so that the node is left out, with a warning
  uint32_t node_count = 0;          // with instances
  uint32_t first_material = 0;      // of the scene, where its default material comes first
  uint32_t material_count = 0;      // with the default material
  Digest digest{};                  // of the file when it was loaded; zeros: not known
};

// Node that the file does not have.
struct ExportedNode {
  uint32_t node = 0;        // above all nodes of the file
  uint32_t parent = kNone;  // kNone: the root
  std::string name = {};    // empty: made from those of the copied node and of the copy
  uint32_t copied = kNone;  // node whose contents it has
  std::optional<Light> light = {};
  std::optional<Camera> camera = {};
  std::optional<ExportedAsset> asset = {};  // that is below it
};

// By number of the scene that was loaded from the file.
struct ExportedEdits {
  std::map<uint32_t, ExportedTransform> transforms;
  std::set<uint32_t> hidden;   // with their descendants
  std::set<uint32_t> removed;  // with their descendants and their lights
  std::map<uint32_t, Light> lights;
  MaterialEdits materials;
  uint32_t variant = kNone;               // becomes the default materials; kNone: those of the file
  std::vector<ExportedNode> added;        // parents first; a copy's nodes in a row, the first one with a name
  std::map<uint32_t, std::string> names;  // of edited nodes: a file that has others has changed
};

struct ExportedGlb {
  std::vector<std::byte> bytes;
  std::vector<std::string> warnings;  // edits that are left out or approximated, one sentence each
};

// Reads the file, added files and all files that they name, each within its folder, and applies the edits. An
// added file that cannot be read, or has changed, is left out with a warning. Thread-safe.
Result<ExportedGlb> export_glb(const std::filesystem::path& gltf, const ExportedEdits& edits,
                               const LoadLimits& limits = {});

}  // namespace fire3dv::scene
