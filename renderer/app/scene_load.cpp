#include "renderer/app/scene_load.h"

#include <chrono>
#include <exception>

#include "renderer/app/progress.h"
#include "renderer/scene/load_gltf.h"

namespace fire3dv::app {

SceneLoad::SceneLoad(const std::filesystem::path& path, scene::SceneCacheSettings cache, scene::Levels levels)
    : path_(path), cache_(std::move(cache)), levels_(levels), thread_([this] {
        Result<scene::LoadedScene> loaded = load();
        const std::lock_guard lock(mutex_);
        result_.emplace(std::move(loaded));
        changed_.notify_all();
      }) {}

Result<scene::LoadedScene> SceneLoad::load() {
  const scene::LoadLimits limits;
  const scene::LoadProgress progress = [this](const char* stage, size_t done, size_t total) {
    note(stage, done, total);
  };
  try {
    std::optional<scene::LoadedScene> kept = cache_.find(path_, limits.max_file_bytes);
    notes_ = cache_.take_notes();
    // A run that wanted no levels of detail may have kept it.
    was_kept_ = kept && (kept->derived.has_levels || !scene::gets_levels(kept->scene, levels_));
    if (was_kept_) return std::move(*kept);
    Result<scene::Scene> scene = scene::load_gltf(path_, limits, progress, &sources_);
    if (!scene) return scene.error();
    scene::Derived derived = scene::derive(*scene, levels_, progress);
    return scene::LoadedScene{std::move(*scene), std::move(derived)};
  } catch (const std::bad_alloc&) {
    return Error{path_.string() + ": it does not fit into memory"};
  } catch (const std::exception& fault) {
    return Error{path_.string() + ": it cannot be loaded: " + fault.what()};
  }
}

void SceneLoad::note(const char* stage, size_t done, size_t total) {
  const std::lock_guard lock(mutex_);
  stage_ = stage;
  done_ = done;
  total_ = total;
}

bool SceneLoad::has_failed() const {
  const std::lock_guard lock(mutex_);
  return result_ && !result_->ok();
}

Result<const scene::LoadedScene*> SceneLoad::wait() {
  Progress progress("loading " + path_.filename().string() + ":");
  std::unique_lock lock(mutex_);
  while (!changed_.wait_for(lock, std::chrono::milliseconds(100), [this] { return result_.has_value(); })) {
    progress.update(stage_, done_, total_);
  }
  if (!result_->ok()) return result_->error();
  return &**result_;
}

void SceneLoad::begin_keeping() {
  if (was_kept_) return;
  thread_ = std::jthread([this] {
    try {
      if (Result<void> done = cache_.keep(path_, **result_, sources_); !done) keeping_error_ = done.error();
    } catch (const std::exception& fault) {
      keeping_error_ = Error{std::string("the scene could not be kept: ") + fault.what()};
    }
  });
}

std::optional<Error> SceneLoad::finish_keeping() {
  if (thread_.joinable()) thread_.join();
  return keeping_error_;
}

}  // namespace fire3dv::app
