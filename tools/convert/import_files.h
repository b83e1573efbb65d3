// File access of assimp: only the mesh file itself and files below its folder exist.
#pragma once

#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <filesystem>

#include "tools/convert/local_files.h"
#include "tools/convert/sources.h"

namespace fire3dv::convert {

class ImportFiles : public Assimp::IOSystem {
 public:
  // besides: receives all further files that assimp requests, found or not.
  ImportFiles(const std::filesystem::path& file, Sources& besides);

  bool Exists(const char* file) const override;
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* file, const char* mode) override;
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  std::filesystem::path file_;
  Sources& besides_;
  AllowedFolders folders_;
};

}  // namespace fire3dv::convert
