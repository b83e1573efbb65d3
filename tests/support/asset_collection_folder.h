// Folder of the public asset collection: FIRE3DV_ASSETS, or shared/assets beside the source tree. It is no
// part of the repository. Tests that read it begin with FIRE3DV_NEEDS_ASSETS() and are named Collection...:
// CTest runs them as an entry of their own, PROGRAM_collection, which is skipped without the collection.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace fire3dv::test {

inline std::filesystem::path asset_collection_folder() {
  const char* const given = std::getenv("FIRE3DV_ASSETS");
  return given ? std::filesystem::path(given)
               : std::filesystem::path(FIRE3DV_SOURCE_DIR) / ".." / "shared" / "assets";
}

}  // namespace fire3dv::test

#define FIRE3DV_NEEDS_ASSETS()                                                          \
  if (!std::filesystem::is_directory(fire3dv::test::asset_collection_folder()))         \
  GTEST_SKIP() << "no asset collection at " << fire3dv::test::asset_collection_folder() \
               << "; FIRE3DV_ASSETS names it"
