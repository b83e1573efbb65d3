// Mesh import through assimp, glTF by the renderer's loader: one file to surfaces, directly or in a child
// process. Parsers of this many formats have memory faults, so readers use the child process.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "base/error.h"
#include "convert/model.h"

namespace fire3dv::convert {

// Material as in the file: displayed (sRGB) colours, image names of the file.
struct ImportedMaterial {
  std::string name;
  glm::vec3 diffuse{1}, emission{0};
  float opacity = 1;
  float roughness = 0.5f, metallic = 0;
  bool is_default = false;                  // the file defines no material for its surfaces
  std::string diffuse_image, normal_image;  // empty: none; *N: embedded image N
  std::string emission_image, roughness_image, metallic_image;  // of scenes; the last two are grey
  std::string opacity_image;                                    // multiplied with opacity
  OpacityChannel opacity_channel = OpacityChannel::automatic;
  float alpha_cutoff = -1;  // opacities below are invisible, others opaque; negative: none
  bool is_blended = false;  // by an image, whatever the opacity is
  bool is_exact = false;    // factors beside images are meant, also if they are 0
  ImagePlacement diffuse_placement, normal_placement, emission_placement, opacity_placement;
  ImagePlacement roughness_placement;  // of the metallic image, too
};

// Encoded image file inside the mesh file (GLB).
struct EmbeddedImage {
  std::string name;
  std::vector<std::byte> bytes;
};

// Node of a mesh file. Its transform is rigid: scales of the file are in the vertices.
struct ImportedNode {
  std::string name;
  int64_t parent = -1;  // precedes its children; -1: none
  glm::dmat4 file_from_node{1.0};
  std::string mesh_name;  // of its first mesh, such as the name of a DAE's geometry
};

// up_axis of a DAE file.
enum class DaeUp : uint8_t { ignore, apply };

// apply: glTF's +Y up becomes +Z up, as in RViz since 2025 and Drake. ignore: as in the file, for Gazebo.
enum class GltfUp : uint8_t { ignore, apply };

// merge: surfaces in the frame of the file, with vertex colours of glTF
// only. keep: surfaces in the frames of their
// nodes, with vertex colours.
enum class Nodes : uint8_t { merge, keep };

struct ImportRequest {
  DaeUp dae_up = DaeUp::ignore;
  Nodes nodes = Nodes::merge;
  GltfUp gltf_up = GltfUp::ignore;
};

struct ImportedMesh {
  std::vector<ImportedMaterial> materials;
  std::vector<Surface> surfaces;  // material: index into materials
  std::vector<EmbeddedImage> images;
  std::vector<std::string> warnings;  // parts of the file that are not as in the file
  Sources besides;                    // further files that were read or requested
  // Nodes::keep:
  std::vector<ImportedNode> nodes;
  std::vector<size_t> surface_nodes;  // of each surface
  std::vector<std::string> losses;    // contents of the file that are left out, such as "its lights"
};

// Accepts obj, stl, ply, 3ds, dae, glb and gltf by file name. The list is short to keep the attack surface
// small.
bool is_mesh_file_name(const std::filesystem::path& file);

// file: regular file. Files that it references (.mtl, .bin) must lie below its folder.
Result<ImportedMesh> import_mesh(const std::filesystem::path& file, ImportRequest request = {});

// Checks that all indices are in bounds and all numbers finite.
Result<void> check_imported(const ImportedMesh& mesh);

// Sandboxed import_mesh in a child process with limits on CPU time and memory. A file that crashes or hangs
// the importer, or exhausts its memory, causes an error. One child serves many files and is replaced when it
// dies.
class MeshImportProcess {
 public:
  MeshImportProcess() = default;
  ~MeshImportProcess() { end(); }
  MeshImportProcess(const MeshImportProcess&) = delete;
  MeshImportProcess& operator=(const MeshImportProcess&) = delete;

  Result<ImportedMesh> import(const std::filesystem::path& file, ImportRequest request = {});

 private:
  bool start();
  // Returns the size of the answer; 0 without one.
  size_t ask(const std::filesystem::path& file, ImportRequest request);
  // Returns the waitpid status; 0 where it is lost.
  int end();

  pid_t child_ = -1;
  int requests_ = -1;  // socket: paths to the child, answer sizes back
  int answer_ = -1;    // shared memory file with the answer
};

}  // namespace fire3dv::convert
