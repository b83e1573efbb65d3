// Document on display: a loaded scene with its optional recording. The scene loads on its own thread; a file
// dropped on the window replaces it after loading.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/replay/replay_link.h"
#include "renderer/app/options/options.h"
#include "renderer/app/recording.h"
#include "renderer/loading/disk_caches.h"
#include "renderer/loading/scene_load.h"

namespace fire3dv::app {

class Document {
 public:
  // Opens the recording, if any, and starts loading the scene.
  static Result<std::unique_ptr<Document>> open(const Options& options, const CacheLocations& caches);
  ~Document() { abandon(); }
  Document(const Document&) = delete;
  Document& operator=(const Document&) = delete;

  const Options& options() const { return options_; }  // effective options of this document
  // The newest load that keep() took, else the first one.
  SceneLoad& load() { return reloaded_ ? *reloaded_ : *load_; }
  // Loads the scene's file again. This object outlives the result. should_stop: cancels, in addition.
  std::unique_ptr<SceneLoad> load_again(std::function<bool()> should_stop);
  // Keeps a load whose scene is displayed now, and destroys the one before, but not the first.
  void keep(std::unique_ptr<SceneLoad> reloaded) { reloaded_ = std::move(reloaded); }
  // False for a scene of a recording, whose file is temporary.
  bool has_own_file() const { return !recorded_scene_; }
  // After load().wait(): the scene as one glTF file, and its name in recordings.
  record::AttachedFile scene_attachment() const;
  std::string title() const;  // the user's file, for messages
  // The error with the user's file in place of the temporary one.
  Error with_scene_name(Error error) const;
  std::unique_ptr<replay::ReplayLink> take_replay() { return std::move(replay_); }  // null: none
  // Prepares another run: restarts the recording.
  Result<void> restart_epoch();
  // Cancels loading.
  void abandon() { abandoned_ = true; }

 private:
  Document(const Options& options, scene::SceneCacheSettings cache)
      : options_(options), cache_(std::move(cache)) {}

  const Options options_;
  const scene::SceneCacheSettings cache_;
  std::filesystem::path scene_path_;
  std::unique_ptr<replay::ReplayLink> replay_;
  std::unique_ptr<RecordedScene> recorded_scene_;
  std::atomic<bool> abandoned_ = false;
  std::optional<SceneLoad> load_;  // last, with the next: their threads use the above
  std::unique_ptr<SceneLoad> reloaded_;
};

// Loader of the next document.
class DocumentLoader {
 public:
  // Checks before the displayed scene is replaced.
  using CanShow = std::function<Result<void>(const scene::Scene& scene)>;
  // Borrows both, which belong to the displayed scene.
  DocumentLoader(const Document& now, const CacheLocations& caches, CanShow can_show)
      : now_(now), caches_(caches), can_show_(std::move(can_show)) {}

  // A file that is_ready() is not loaded again.
  void open(const std::filesystem::path& file);
  bool is_ready();  // otherwise reports why it never will be
  void note(std::string text) { notes_.push_back(std::move(text)); }
  std::unique_ptr<Document> take() { return std::move(next_); }
  std::vector<std::string> take_log_messages() { return std::exchange(notes_, {}); }

 private:
  const Document& now_;
  const CacheLocations& caches_;
  const CanShow can_show_;
  std::unique_ptr<Document> next_;
  std::filesystem::path file_;  // of next_
  bool is_ready_ = false;
  std::vector<std::string> notes_;
};

// Options of the same run with another file. A recording replaces the recording, and the scene if it has one
// attached; any other file replaces the scene.
Options with_file(const Options& options, const std::filesystem::path& file);

}  // namespace fire3dv::app
