// Reload of the displayed scene when its file changes on disk. The next version loads on a thread and
// replaces the displayed one when it is whole; streams keep driving nodes by their names, and the camera
// stays. A version that cannot be loaded is reported once, and the displayed scene stays.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/digest.h"
#include "renderer/live_scene/live_scene.h"
#include "renderer/loading/file_watch.h"
#include "renderer/loading/scene_load.h"

namespace fire3dv::app {

class SceneReload {
 public:
  struct Hooks {
    // Starts loading the file. should_stop cancels.
    std::function<std::unique_ptr<SceneLoad>(std::function<bool()> should_stop)> load;
    // Takes the load of the scene that is displayed now, and adapts the view. The scene before is no longer
    // used.
    std::function<void(std::unique_ptr<SceneLoad> shown)> keep;
    std::function<Result<void>(const scene::Scene& scene)> can_show;
    // Animations of the scene that play; reports those that it lacks.
    std::function<std::vector<uint32_t>(const scene::Scene& scene)> animations;
  };
  // shown: the finished load of the displayed scene.
  SceneReload(const SceneLoad& shown, Hooks hooks);
  ~SceneReload() { *ended_ = true; }
  SceneReload(const SceneReload&) = delete;
  SceneReload& operator=(const SceneReload&) = delete;

  // Looks at the files, and replaces the scene when a new version is ready. Called between two frames, before
  // LiveScene::follow().
  void poll(LiveScene& live);
  std::vector<std::string> take_log_messages() { return std::exchange(messages_, {}); }

 private:
  void show(LiveScene& live);
  void report(const std::string& fault);

  const std::filesystem::path file_;
  const Hooks hooks_;
  FileWatch watch_;
  std::optional<Digest> reported_;  // contents of the last version that could not be shown
  std::vector<std::string> messages_;
  const std::shared_ptr<std::atomic<bool>> ended_ = std::make_shared<std::atomic<bool>>(false);
  std::unique_ptr<SceneLoad> next_;  // null: none is loading
};

}  // namespace fire3dv::app
