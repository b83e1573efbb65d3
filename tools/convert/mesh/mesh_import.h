// Mesh import through assimp: one file to surfaces, directly or in a child process. Parsers of this many
// formats have memory faults, so readers use the child process.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "tools/convert/model.h"

namespace fire3dv::convert {

// Material as in the file: displayed (sRGB) colours, image names of the file.
struct ImportedMaterial {
  std::string name;
  glm::vec3 diffuse{1}, emission{0};
  float opacity = 1;
  float roughness = 0.5f, metallic = 0;
  bool is_default = false;                  // the file defines no material for its surfaces
  std::string diffuse_image, normal_image;  // empty: none; *N: embedded image N
};

// Encoded image file inside the mesh file (GLB).
struct EmbeddedImage {
  std::string name;
  std::vector<std::byte> bytes;
};

// up_axis of a DAE file.
enum class DaeUp : uint8_t { ignore, apply };

struct ImportedMesh {
  std::vector<ImportedMaterial> materials;
  std::vector<Surface> surfaces;  // material: index into materials
  std::vector<EmbeddedImage> images;
  Sources besides;  // further files that were read or requested
};

// Accepts obj, stl, ply, 3ds, dae, glb and gltf by file name. The list is short to keep the attack surface
// small.
bool is_mesh_file_name(const std::filesystem::path& file);

// file: regular file. Files that it references (.mtl, .bin) must lie below its folder.
Result<ImportedMesh> import_mesh(const std::filesystem::path& file, DaeUp dae_up = DaeUp::ignore);

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

  Result<ImportedMesh> import(const std::filesystem::path& file, DaeUp dae_up = DaeUp::ignore);

 private:
  bool start();
  // Returns the size of the answer; 0 without one.
  size_t ask(const std::filesystem::path& file, DaeUp dae_up);
  // Returns the waitpid status; 0 where it is lost.
  int end();

  pid_t child_ = -1;
  int requests_ = -1;  // socket: paths to the child, answer sizes back
  int answer_ = -1;    // shared memory file with the answer
};

}  // namespace fire3dv::convert
