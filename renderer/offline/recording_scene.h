// The scene that a recording is drawn in: the file that the user named, or else the one that travels in the
// recording. Nothing that a recording says is taken for a path.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "protocol/record/playback.h"
#include "renderer/app/options.h"
#include "renderer/app/scene_load.h"
#include "renderer/scene/scene_cache.h"

namespace fire3dv::offline {

class RecordingScene {
 public:
  // Begins to load the file that the options name, if they name one.
  RecordingScene(const app::Options& options, const scene::SceneCacheSettings& cache,
                 std::function<bool()> should_stop);

  // The scene, which stays as long as this does. The error says what could be named where there is none.
  Result<const scene::LoadedScene*> load(record::Playback& playback, const std::string& recording);
  const std::string& title() const { return title_; }  // for people
  const std::vector<std::string>& notes() const;
  app::SceneLoad* file() { return file_ ? &*file_ : nullptr; }

 private:
  Result<void> load_attached(record::Reader& reader, const std::string& recording);

  scene::Levels levels_;
  std::string title_;
  std::optional<app::SceneLoad> file_;
  std::optional<scene::LoadedScene> attached_;
  std::vector<std::string> no_notes_;
};

// The same for scenes that look the same: of all that is in it.
std::string content_of(const scene::Scene& scene);

}  // namespace fire3dv::offline
