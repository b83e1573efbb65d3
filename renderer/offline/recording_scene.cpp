#include "renderer/offline/recording_scene.h"

#include <cstring>

#include "protocol/wire/check.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/scene/digest.h"
#include "renderer/scene/load_gltf.h"
#include "renderer/scene/member_bytes.h"

namespace fire3dv::offline {
namespace {

bool is_scene(const record::AttachmentIndex& attachment) {
  return attachment.media_type == "model/gltf-binary" || attachment.name.ends_with(".glb");
}

// What the adapters believed that they drove, as a hint for people.
std::string scene_hint(record::Playback& playback) {
  playback.rewind();
  record::Played played;
  wire::Decoder decoder;
  for (record::Playback::Step step; (step = playback.next(played)) != record::Playback::Step::end;) {
    if (step != record::Playback::Step::played || played.kind != record::Played::Kind::description) continue;
    const auto decoded = decoder.decode(played.message);
    const auto* description = decoded ? std::get_if<wire::StreamDescription>(&*decoded) : nullptr;
    if (description && !description->scene_uri.empty())
      return " (its stream says that it drives " + wire::printable(description->scene_uri) + ")";
    break;
  }
  return "";
}

}  // namespace

RecordingScene::RecordingScene(const app::Options& options, const scene::SceneCacheSettings& cache,
                               std::function<bool()> should_stop)
    : levels_(passes::levels_for(options.levels_of_detail)), title_(options.scene.string()) {
  if (!options.scene.empty())
    file_.emplace(options.scene, options.convert, cache, levels_, std::move(should_stop));
}

Result<const scene::LoadedScene*> RecordingScene::load(record::Playback& playback,
                                                       const std::string& recording) {
  if (file_) return file_->wait();
  if (auto loaded = load_attached(playback.reader(), recording); !loaded) return loaded.error();
  if (attached_) return &*attached_;
  return Error{wire::printable(recording, 4096) + " has no scene in it" + scene_hint(playback) +
               ": name one, as in fire3dv render FILE.mcap SCENE.glb"};
}

Result<void> RecordingScene::load_attached(record::Reader& reader, const std::string& recording) {
  const record::AttachmentIndex* chosen = nullptr;
  for (const record::AttachmentIndex& attachment : reader.index().attachments) {
    if (!is_scene(attachment)) continue;
    if (chosen)
      return Error{wire::printable(recording, 4096) + " has several scenes in it (" +
                   wire::printable(chosen->name) + ", " + wire::printable(attachment.name) +
                   "): name the one to draw, as in fire3dv render FILE.mcap SCENE.glb"};
    chosen = &attachment;
  }
  if (!chosen) return {};
  title_ = wire::printable(chosen->name) + " in " + wire::printable(recording, 4096);
  const scene::LoadLimits limits;
  if (chosen->data_bytes > limits.max_file_bytes) return Error{title_ + " is too long"};
  std::vector<std::byte> file;
  const auto read = reader.read_attachment(*chosen, [&](std::span<const std::byte> piece) -> Result<void> {
    file.insert(file.end(), piece.begin(), piece.end());
    return {};
  });
  if (!read) return read;
  Result<scene::Scene> scene = scene::load_glb(file, title_, limits);
  if (!scene) return scene.error();
  scene::Derived derived = scene::derive(*scene, levels_);
  attached_.emplace(scene::LoadedScene{std::move(*scene), std::move(derived)});
  return {};
}

const std::vector<std::string>& RecordingScene::notes() const {
  return file_ ? file_->notes() : no_notes_;
}

std::string content_of(const scene::Scene& of) {
  // The lists of members serve readers and writers, and so take what could be changed; a writer changes
  // nothing.
  auto& scene = const_cast<scene::Scene&>(of);
  std::vector<uint64_t> values;
  const auto add = [&](std::span<const std::byte> bytes) {
    scene::Checksum checksum;
    checksum.add(bytes);
    values.push_back(checksum.value());
  };
  scene::MemberWriter members;
  visit_members(scene, members);
  add(members.bytes());
  scene::visit_arrays(scene, [&](auto& array) { add(std::as_bytes(std::span(array))); });
  return scene::hex(scene::digest_of(std::as_bytes(std::span(values)))).substr(0, 32);
}

}  // namespace fire3dv::offline
