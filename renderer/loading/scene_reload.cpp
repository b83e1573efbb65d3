#include "renderer/loading/scene_reload.h"

#include "base/clock.h"
#include "base/log.h"

namespace fire3dv::app {

SceneReload::SceneReload(const SceneLoad& shown, Hooks hooks)
    : file_(shown.path()), hooks_(std::move(hooks)), watch_(shown.watched_files()) {}

void SceneReload::poll(LiveScene& live) {
  if (next_) {
    // A build of streams' nodes ends first.
    if (next_->is_done() && live.can_replace_base()) show(live);
    return;
  }
  if (watch_.poll(monotonic_ns())) next_ = hooks_.load([ended = ended_] { return ended->load(); });
}

void SceneReload::show(LiveScene& live) {
  std::unique_ptr<SceneLoad> next = std::exchange(next_, nullptr);
  const Result<const scene::LoadedScene*> loaded = next->wait();
  // Also of a failed load: its files may be others than those of the displayed scene.
  watch_.watch(next->watched_files());
  if (!loaded) return report(loaded.error().message);
  const scene::LoadedScene& scene = **loaded;
  if (Result<void> can = hooks_.can_show(scene.scene); !can) return report(can.error().message);
  if (Result<void> replaced = live.replace_base(scene, hooks_.animations(scene.scene)); !replaced)
    return report(file_.string() + ": " + replaced.error().message);
  reported_.reset();
  for (const std::string& note : next->notes()) messages_.push_back(note);
  messages_.push_back("reloaded " + file_.string() + ", which has changed");
  log_scene_summary(file_, scene.scene);
  hooks_.keep(std::move(next));
}

// Once for the same contents: editors may write a file several times.
void SceneReload::report(const std::string& fault) {
  constexpr uint64_t kMaxHashedBytes = uint64_t{64} << 20;  // on this thread
  const Result<Digest> digest = digest_of_file(file_, kMaxHashedBytes);
  if (digest && reported_ == *digest) return;
  reported_ = digest ? std::optional<Digest>(*digest) : std::nullopt;
  messages_.push_back(warning("the file has changed, but the scene shown before stays: " + fault));
}

}  // namespace fire3dv::app
