// Scene of an offline run: the file named by the user, else the scene stored in the recording. No text of the
// recording is used as a path.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "protocol/base/error.h"
#include "protocol/record/playback.h"
#include "renderer/app/loading/recorded_scene.h"
#include "renderer/app/loading/scene_load.h"
#include "renderer/app/options/options.h"
#include "renderer/scene/cache/scene_cache.h"

namespace fire3dv::offline {

class RecordingScene {
 public:
  // Starts loading. If there is no scene, the error suggests one.
  static Result<std::unique_ptr<RecordingScene>> open(const app::Options& options,
                                                      const scene::SceneCacheSettings& cache,
                                                      record::Playback& playback,
                                                      std::function<bool()> should_stop);

  const std::string& title() const { return title_; }  // for messages
  app::SceneLoad& load() { return *load_; }

 private:
  RecordingScene() = default;

  std::string title_;
  std::unique_ptr<app::RecordedScene> recorded_;  // set if the recording stores the scene
  std::optional<app::SceneLoad> load_;
};

// Digest of the scene's content: equal scenes have equal digests.
std::string content_of(const scene::Scene& scene);

}  // namespace fire3dv::offline
