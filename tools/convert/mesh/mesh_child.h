// Sandboxed import_mesh in a child process with limits on CPU time and memory. A file that crashes or hangs
// the importer, or exhausts its memory, causes an error. One child serves many files and is replaced when it
// dies.
#pragma once

#include <sys/types.h>

#include <filesystem>

#include "protocol/base/error.h"
#include "tools/convert/mesh/mesh_import.h"

namespace fire3dv::convert {

class MeshImportProcess {
 public:
  MeshImportProcess() = default;
  ~MeshImportProcess() { end(); }
  MeshImportProcess(const MeshImportProcess&) = delete;
  MeshImportProcess& operator=(const MeshImportProcess&) = delete;

  Result<ImportedMesh> import(const std::filesystem::path& file);

 private:
  bool start();
  // Returns the size of the answer; 0 without one.
  size_t ask(const std::filesystem::path& file);
  // Returns the waitpid status; 0 where it is lost.
  int end();

  pid_t child_ = -1;
  int requests_ = -1;  // socket: paths to the child, answer sizes back
  int answer_ = -1;    // shared memory file with the answer
};

}  // namespace fire3dv::convert
