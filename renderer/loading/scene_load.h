// Asynchronous scene load: conversion to glTF if needed, reading and preprocessing on its own thread, while
// the device opens and pipelines compile.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/error.h"
#include "renderer/loading/converted_scene.h"
#include "renderer/loading/file_watch.h"
#include "renderer/scene/cache/scene_cache.h"

namespace fire3dv::app {

// Choices that the loaded scene contains.
struct LoadedLook {
  bool has_key_light = false;  // of a scene without lights, see key_light.h
  std::string variant = {};    // name of the scene's material variant; empty: the file's default materials
};

// Prints the scene's warnings and a summary of its contents.
void log_scene_summary(const std::filesystem::path& path, const scene::Scene& scene);

class SceneLoad {
 public:
  // Starts loading. should_stop: cancels; called on the loading thread.
  SceneLoad(const std::filesystem::path& path, const ConvertOptions& convert, scene::SceneCacheSettings cache,
            scene::Levels levels, LoadedLook look, std::function<bool()> should_stop = {});

  const std::filesystem::path& path() const { return path_; }
  // After wait(): the file and the files that it names, with stamps; the file's own is from before it was
  // read. Of a description or mesh file without a cache: only the file itself.
  std::vector<WatchedFile> watched_files() const;
  // True if loading has failed already: the caller need not start other work.
  bool has_failed() const;
  bool is_done() const;  // wait() would not block
  // Waits and displays progress. meanwhile: called several times a second. The scene lives as long as this
  // object.
  Result<const scene::LoadedScene*> wait(const std::function<void()>& meanwhile = {});
  // After wait(): messages about cache and conversion, and whether the scene came from the cache.
  const std::vector<std::string>& notes() const { return notes_; }
  bool is_cached() const { return is_cached_; }
  // After wait(): the glTF file that was loaded; of a description its conversion. Readable for the lifetime
  // of this object.
  const std::filesystem::path& gltf_file() const { return gltf_; }
  // After wait(): writes a new cache entry on a thread, once. finish_caching() waits for it and returns its
  // error.
  void begin_caching();
  std::optional<Error> finish_caching();

 private:
  Result<scene::LoadedScene> load();
  Result<scene::LoadedScene> load_gltf_file();
  Result<scene::LoadedScene> read_or_find();
  void note(const char* stage, size_t done, size_t total);

  const std::filesystem::path path_;
  const scene::FileStamp stamp_;  // from before loading
  const ConvertOptions convert_;
  const std::function<bool()> should_stop_;
  std::optional<ConvertedScene> converted_;  // of a description
  std::filesystem::path gltf_;               // path_, or the converted file
  scene::SceneCacheSettings cache_settings_;
  scene::SceneCache cache_;
  scene::Levels levels_;
  const LoadedLook look_;
  std::vector<scene::SourceFile> sources_;
  std::vector<std::string> notes_;
  bool is_cached_ = false, has_stored_ = false;
  std::optional<Error> store_error_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Result<scene::LoadedScene>> result_;
  const char* stage_ = "reading";
  size_t done_ = 0, total_ = 0;
  std::jthread thread_;  // last: it uses all members above
};

}  // namespace fire3dv::app
