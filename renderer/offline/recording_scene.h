// The scene that a recording is drawn in: the file that the user named, or else the one that travels in the
// recording. Nothing that a recording says is taken for a path.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "protocol/error.h"
#include "protocol/record/playback.h"
#include "renderer/app/options.h"
#include "renderer/app/recorded_scene.h"
#include "renderer/app/scene_load.h"
#include "renderer/scene/scene_cache.h"

namespace fire3dv::offline {

class RecordingScene {
 public:
  // Begins to load it. The error says what could be named where there is none.
  static Result<std::unique_ptr<RecordingScene>> open(const app::Options& options,
                                                      const scene::SceneCacheSettings& cache,
                                                      record::Playback& playback,
                                                      std::function<bool()> should_stop);

  const std::string& title() const { return title_; }  // for people
  app::SceneLoad& load() { return *load_; }

 private:
  RecordingScene() = default;

  std::string title_;
  std::unique_ptr<app::RecordedScene> recorded_;  // where it is the recording's
  std::optional<app::SceneLoad> load_;
};

// The same for scenes that look the same: of all that is in it.
std::string content_of(const scene::Scene& scene);

}  // namespace fire3dv::offline
