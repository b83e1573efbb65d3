#include "renderer/app/scene_load.h"

#include <chrono>

#include "renderer/app/progress.h"
#include "renderer/scene/load_gltf.h"

namespace fire3dv::app {
namespace {

Result<LoadedScene> load(const std::filesystem::path& path, const scene::LoadProgress& progress) {
  Result<scene::Scene> scene = scene::load_gltf(path, {}, progress);
  if (!scene) return scene.error();
  try {
    scene::Derived derived = scene::derive(*scene, progress);
    return LoadedScene{std::move(*scene), std::move(derived)};
  } catch (const std::bad_alloc&) {
    return Error{path.string() + ": it does not fit into memory"};
  }
}

}  // namespace

SceneLoad::SceneLoad(const std::filesystem::path& path)
    : path_(path), thread_([this] {
        Result<LoadedScene> loaded = load(path_, [this](const char* stage, size_t done, size_t total) {
          note(stage, done, total);
        });
        const std::lock_guard lock(mutex_);
        result_.emplace(std::move(loaded));
        changed_.notify_all();
      }) {}

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

Result<LoadedScene> SceneLoad::take() {
  Progress progress("loading " + path_.filename().string() + ":");
  std::unique_lock lock(mutex_);
  while (!changed_.wait_for(lock, std::chrono::milliseconds(100), [this] { return result_.has_value(); })) {
    progress.update(stage_, done_, total_);
  }
  return std::move(*result_);
}

}  // namespace fire3dv::app
