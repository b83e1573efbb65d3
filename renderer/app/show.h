// One thing to show: a scene, which loads on a thread of its own, and the recording that is played on it. A
// file that the user drops on the window is shown instead, once it is loaded.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/replay/replay_link.h"
#include "renderer/app/cache_places.h"
#include "renderer/app/options.h"
#include "renderer/app/recorded_scene.h"
#include "renderer/app/scene_load.h"

namespace fire3dv::app {

class Show {
 public:
  // Opens the recording, where there is one, and begins to load the scene.
  static Result<std::unique_ptr<Show>> open(const Options& options, const CachePlaces& places);
  ~Show() { abandon(); }
  Show(const Show&) = delete;
  Show& operator=(const Show&) = delete;

  const Options& options() const { return options_; }  // as they hold for this
  const std::filesystem::path& scene_path() const { return scene_path_; }
  SceneLoad& load() { return *load_; }
  std::unique_ptr<replay::ReplayLink> take_replay() { return std::move(replay_); }  // null: none
  // It is shown once more: the recording from its beginning.
  Result<void> begin_again();
  // Nobody wants to see it any more: loading ends early.
  void abandon() { abandoned_ = true; }

 private:
  explicit Show(const Options& options) : options_(options) {}

  const Options options_;
  std::filesystem::path scene_path_;
  std::unique_ptr<replay::ReplayLink> replay_;
  std::unique_ptr<RecordedScene> recorded_scene_;
  std::atomic<bool> abandoned_ = false;
  std::optional<SceneLoad> load_;  // last: its thread uses the above
};

// The one that the user wants to see instead.
class NextShow {
 public:
  // What is known before it takes the place of what is shown.
  using CanShow = std::function<Result<void>(const scene::Scene& scene)>;
  // Both are borrowed, and are of what is shown.
  NextShow(const Show& now, const CachePlaces& places, CanShow can_show)
      : now_(now), places_(places), can_show_(std::move(can_show)) {}

  void open(const std::filesystem::path& file);
  bool is_ready();  // or says why it will never be
  void note(std::string text) { notes_.push_back(std::move(text)); }
  std::unique_ptr<Show> take() { return std::move(next_); }
  std::vector<std::string> take_notes() { return std::exchange(notes_, {}); }

 private:
  const Show& now_;
  const CachePlaces& places_;
  const CanShow can_show_;
  std::unique_ptr<Show> next_;
  std::vector<std::string> notes_;
};

// The same run with this file instead: a recording replaces the recording, and what it is of where a scene
// travels in it; anything else is a scene.
Options with_file(const Options& options, const std::filesystem::path& file);

}  // namespace fire3dv::app
