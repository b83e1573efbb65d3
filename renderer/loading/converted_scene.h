// Conversion of robot and scene description files (AMBF, URDF, MJCF, SDF) and mesh files (OBJ, STL, PLY, DAE,
// 3MF) to glTF, with a cache of the results. fire3dv-convert beside this program reads them, with limits on
// its time, memory and output.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/scene/cache/scene_cache.h"

namespace fire3dv::app {

struct ConvertOptions {
  std::string models;      // AMBF's -l, or "all"; empty: AMBF's default
  std::string name_space;  // AMBF's --ns
  std::vector<std::filesystem::path> package_folders;
  std::vector<std::string> xacro_arguments;  // NAME=VALUE
  // As of fire3dv-convert; empty: its defaults.
  std::string up, unit;         // of mesh files
  std::string dae_up, gltf_up;  // of meshes of URDF and SDF
  std::string smooth_angle;     // of meshes without normals, in degrees
  bool is_confined = false;     // a description of unknown origin
};

// True for files that are converted, by their extension: descriptions (.yaml, .yml, .urdf, .xml, .xacro,
// .mjcf, .sdf, .world) and mesh files (.obj, .stl, .ply, .dae, .3mf), and for model folders of Gazebo, with a
// model.config. A binary glTF file needs no conversion, whatever its name is.
bool needs_conversion(const std::filesystem::path& file);

class ConvertedScene {
 public:
  // Converts the description, or opens a valid cache entry. should_stop: polled ten times a
  // second; true ends the converter.
  static Result<ConvertedScene> open(const std::filesystem::path& description, const ConvertOptions& options,
                                     const scene::SceneCacheSettings& cache,
                                     const std::function<bool()>& should_stop);
  ConvertedScene(ConvertedScene&& other) noexcept;
  ConvertedScene& operator=(const ConvertedScene&) = delete;
  ~ConvertedScene();

  // The binary glTF file, readable for the lifetime of this object.
  const std::filesystem::path& file() const { return file_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  // The files that it was made of, or that are missing; known with a cache only.
  const std::vector<std::filesystem::path>& sources() const { return sources_; }
  bool is_cached() const { return is_cached_; }
  bool is_on_disk() const { return memory_ < 0; }

 private:
  ConvertedScene() = default;
  Result<void> convert_into_memory(std::vector<std::string> words, const std::filesystem::path& description,
                                   const std::function<bool()>& should_stop);

  std::filesystem::path file_;
  std::vector<std::string> warnings_;
  std::vector<std::filesystem::path> sources_;
  bool is_cached_ = false;
  int memory_ = -1;  // without a cache: memory file descriptor of the converted scene
};

}  // namespace fire3dv::app
