// A scene on its way: converted where it is no glTF, read and prepared on a thread of its own, while the
// device opens and its pipelines are made.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "protocol/error.h"
#include "renderer/app/converted_scene.h"
#include "renderer/scene/scene_cache.h"

namespace fire3dv::app {

class SceneLoad {
 public:
  // Begins. should_stop: ends it early; asked on the thread that loads.
  SceneLoad(const std::filesystem::path& path, const ConvertOptions& convert, scene::SceneCacheSettings cache,
            scene::Levels levels, std::function<bool()> should_stop = {});

  // Whether take() would report an error, as far as is known by now: then nothing else has to be begun.
  bool has_failed() const;
  bool is_done() const;  // wait() does not wait
  // Waits, and says meanwhile how far it is. meanwhile: called several times a second. The scene stays for as
  // long as this object does.
  Result<const scene::LoadedScene*> wait(const std::function<void()>& meanwhile = {});
  // After wait(): what there is to say about the cache and a conversion, and whether the scene came out of
  // it.
  const std::vector<std::string>& notes() const { return notes_; }
  bool was_kept() const { return was_kept_; }
  // After wait(): keeps a scene that was not, on a thread, once. finish_keeping() waits for that; it has a
  // sentence where something went wrong.
  void begin_keeping();
  std::optional<Error> finish_keeping();

 private:
  Result<scene::LoadedScene> load();
  Result<scene::LoadedScene> load_gltf_file();
  void note(const char* stage, size_t done, size_t total);

  const std::filesystem::path path_;
  const ConvertOptions convert_;
  const std::function<bool()> should_stop_;
  std::filesystem::path gltf_;  // path_, or what it was converted to
  scene::SceneCacheSettings cache_settings_;
  scene::SceneCache cache_;
  scene::Levels levels_;
  std::vector<scene::SourceFile> sources_;
  std::vector<std::string> notes_;
  bool was_kept_ = false, keeps_ = false;
  std::optional<Error> keeping_error_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Result<scene::LoadedScene>> result_;
  const char* stage_ = "reading";
  size_t done_ = 0, total_ = 0;
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace fire3dv::app
