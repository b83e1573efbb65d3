#include "renderer/app/document.h"

#include "base/log.h"
#include "renderer/app/stop_signals.h"
#include "renderer/camera/default_look.h"
#include "renderer/passes/scene_renderer.h"

namespace fire3dv::app {
namespace {

bool is_recording(const std::filesystem::path& file) {
  return file.extension() == ".mcap";
}

// Null without the option.
Result<std::unique_ptr<replay::ReplayLink>> open_replay(const Options& options) {
  const RecordingOptions& recording = options.recording;
  if (recording.replay.empty()) return std::unique_ptr<replay::ReplayLink>();
  replay::ReplayOptions replay_options;
  replay_options.streams = recording.streams;
  replay_options.speed = recording.speed;
  replay_options.start_s = recording.start_s;
  replay_options.end_s = recording.end_s;
  replay_options.loop = recording.loop;
  replay_options.each_frame = recording.step;
  replay_options.end_streams = options.exit_when_done;
  return replay::ReplayLink::open(recording.replay, replay_options);
}

}  // namespace

Result<std::unique_ptr<Document>> Document::open(const Options& options, const CacheLocations& caches) {
  std::unique_ptr<Document> document(new Document(options, caches.scenes));
  Result<std::unique_ptr<replay::ReplayLink>> replay = open_replay(options);
  if (!replay) return replay.error();
  document->replay_ = std::move(*replay);
  document->scene_path_ = options.scene;
  if (options.scene.empty()) {
    Result<std::unique_ptr<RecordedScene>> extracted =
        RecordedScene::extract(document->replay_->playback().reader());
    if (!extracted) return extracted.error();
    document->recorded_scene_ = std::move(*extracted);
    document->scene_path_ = document->recorded_scene_->path();
    log_message("scene \"" + document->recorded_scene_->name() + "\" of " + options.recording.replay);
  }
  document->load_.emplace(
      document->scene_path_, options.convert, caches.scenes,
      passes::levels_for(options.draw.levels_of_detail),
      LoadedLook{wants_key_light(options.key_light, lights_by_choice(options)), options.variant},
      [raw = document.get()] { return raw->abandoned_ || stop_was_requested(); });
  return document;
}

std::unique_ptr<SceneLoad> Document::load_again(std::function<bool()> should_stop) {
  return std::make_unique<SceneLoad>(
      scene_path_, options_.convert, cache_, passes::levels_for(options_.draw.levels_of_detail),
      LoadedLook{wants_key_light(options_.key_light, lights_by_choice(options_)), options_.variant},
      [this, stop = std::move(should_stop)] { return abandoned_ || stop_was_requested() || stop(); });
}

record::AttachedFile Document::scene_attachment() const {
  std::filesystem::path name = scene_path_.filename();
  if (recorded_scene_) name = std::filesystem::path(recorded_scene_->name()).filename();
  if (recorded_scene_ || needs_conversion(scene_path_)) name.replace_extension(".glb");
  return {load_->gltf_file().string(), name.string()};
}

std::string Document::title() const {
  if (!recorded_scene_) return scene_path_.string();
  return recorded_scene_->with_name(Error{scene_path_.string()}, options_.recording.replay).message;
}

Error Document::with_scene_name(Error error) const {
  return recorded_scene_ ? recorded_scene_->with_name(std::move(error), options_.recording.replay) : error;
}

Result<void> Document::restart_epoch() {
  Result<std::unique_ptr<replay::ReplayLink>> replay = open_replay(options_);
  if (!replay) return replay.error();
  replay_ = std::move(*replay);
  return {};
}

Options with_file(const Options& options, const std::filesystem::path& file) {
  Options other = options;
  other.recording = {};
  // Models and the frame of a mesh file are those of the first file.
  other.convert.models.clear();
  other.convert.name_space.clear();
  other.convert.up.clear();
  other.convert.unit.clear();
  other.exit_when_done = false;
  other.variant.clear();  // names are the file's own
  other.overlay.clear();
  if (is_recording(file)) {
    other.recording.replay = file.string();
    other.recording.loop = options.recording.loop;
    other.scene.clear();
  } else {
    other.scene = file;
  }
  return other;
}

void DocumentLoader::open(const std::filesystem::path& file) {
  if (is_ready_ && next_ && file == file_) return;
  const Options& now = now_.options();
  if (!now.out.empty() || !now.stats.empty() || !now.recording.record.empty() || now.lockstep)
    return notes_.push_back(
        error_line("--out, --stats, --record, --lockstep and --step allow one scene only: open " +
                   file.string() + " in another fire3dv"));
  Options options = with_file(now, file);
  Result<std::unique_ptr<Document>> opened = Document::open(options, caches_);
  if (!opened && is_recording(file)) {  // no attached scene: the recording may belong to the displayed scene
    options.scene = now.scene;
    if (!now.scene.empty()) opened = Document::open(options, caches_);
  }
  if (!opened) return notes_.push_back(error_line(opened.error().message));
  next_ = std::move(*opened);
  file_ = file;
  is_ready_ = false;
  notes_.push_back("loading " + file.string());
}

bool DocumentLoader::is_ready() {
  if (!next_ || !next_->load().is_done()) return false;
  const Result<const scene::LoadedScene*> loaded = next_->load().wait();
  const Result<void> can = loaded ? can_show_((*loaded)->scene) : Result<void>(loaded.error());
  is_ready_ = can.ok();
  if (is_ready_) return true;
  notes_.push_back(error_line(can.error().message));
  next_.reset();
  return false;
}

}  // namespace fire3dv::app
