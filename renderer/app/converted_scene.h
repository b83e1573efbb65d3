// Descriptions of robots and scenes (AMBF, URDF, MJCF) as scenes: converted when they are first shown, and
// kept for the next start.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "renderer/scene/scene_cache.h"

namespace fire3dv::app {

struct ConvertOptions {
  std::string models;      // AMBF's -l, or "all"; empty: as AMBF without it
  std::string name_space;  // AMBF's --ns
  std::vector<std::filesystem::path> package_folders;
};

// By its name's ending: .yaml, .yml, .urdf, .xml or .xacro.
bool is_description(const std::filesystem::path& file);

class ConvertedScene {
 public:
  // Converts, or finds what was converted before and still holds. should_stop: see run_converter.h.
  static Result<ConvertedScene> open(const std::filesystem::path& description, const ConvertOptions& options,
                                     const scene::SceneCacheSettings& cache,
                                     const std::function<bool()>& should_stop);
  ConvertedScene(ConvertedScene&& other) noexcept;
  ConvertedScene& operator=(const ConvertedScene&) = delete;
  ~ConvertedScene();

  // The binary glTF file, to be read for as long as this object lives.
  const std::filesystem::path& file() const { return file_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  bool was_kept() const { return was_kept_; }
  bool is_on_disk() const { return memory_ < 0; }

 private:
  ConvertedScene() = default;
  Result<void> convert_into_memory(std::vector<std::string> words, const std::filesystem::path& description,
                                   const std::function<bool()>& should_stop);

  std::filesystem::path file_;
  std::vector<std::string> warnings_;
  bool was_kept_ = false;
  int memory_ = -1;  // where nothing is kept: a file that has no place on a disk
};

}  // namespace fire3dv::app
