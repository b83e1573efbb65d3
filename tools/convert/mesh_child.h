// import_mesh in a process of its own, with bounds on its time and memory: a file that makes the importer
// crash, hang or eat memory costs an error. One process serves file after file, and is replaced when it dies.
#pragma once

#include <sys/types.h>

#include <filesystem>

#include "protocol/error.h"
#include "tools/convert/mesh_import.h"

namespace fire3dv::convert {

class MeshChild {
 public:
  MeshChild() = default;
  ~MeshChild() { end(); }
  MeshChild(const MeshChild&) = delete;
  MeshChild& operator=(const MeshChild&) = delete;

  Result<ImportedMesh> import(const std::filesystem::path& file);

 private:
  bool start();
  // The size of the answer, 0 where there is none.
  size_t ask(const std::filesystem::path& file);
  // How the process ended, as waitpid says it; 0 where that is lost.
  int end();

  pid_t child_ = -1;
  int requests_ = -1;  // paths go to the child, sizes of answers come back
  int answer_ = -1;    // memory that both see
};

}  // namespace fire3dv::convert
