#include "renderer/offline/recording_scene.h"

#include <algorithm>

#include "protocol/base/digest.h"
#include "protocol/record/mcap/attachments.h"
#include "protocol/wire/check.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/scene/cache/member_bytes.h"

namespace fire3dv::offline {
namespace {

// Scene name that the adapters reported, as a hint in errors.
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

Result<std::unique_ptr<RecordingScene>> RecordingScene::open(const app::Options& options,
                                                             const scene::SceneCacheSettings& cache,
                                                             record::Playback& playback,
                                                             std::function<bool()> should_stop) {
  std::unique_ptr<RecordingScene> scene(new RecordingScene);
  std::filesystem::path path = options.scene;
  scene->title_ = path.string();
  if (path.empty()) {
    const std::string file = wire::printable(playback.reader().name(), 4096);
    const auto& attachments = playback.reader().index().attachments;
    const auto scenes =
        std::ranges::count(attachments, record::kGlbType, &record::AttachmentIndex::media_type);
    if (scenes != 1)
      return Error{file + " has " + (scenes == 0 ? "no scene" : std::to_string(scenes) + " scenes") +
                   " in it" + scene_hint(playback) +
                   ": name the one to draw, as in fire3dv render FILE.mcap SCENE.glb"};
    auto recorded = app::RecordedScene::extract(playback.reader());
    if (!recorded) return recorded.error();
    scene->recorded_ = std::move(*recorded);
    path = scene->recorded_->path();
    scene->title_ = scene->recorded_->name() + " in " + file;
  }
  scene->load_.emplace(path, options.convert, cache, passes::levels_for(options.levels_of_detail),
                       std::move(should_stop));
  return scene;
}

std::string content_of(const scene::Scene& of) {
  // Member visitors take a mutable scene for readers and writers; a writer does not modify it.
  auto& scene = const_cast<scene::Scene&>(of);
  std::vector<uint64_t> values;
  const auto add = [&](std::span<const std::byte> bytes) {
    Checksum checksum;
    checksum.add(bytes);
    values.push_back(checksum.value());
  };
  scene::MemberWriter members;
  visit_members(scene, members);
  add(members.bytes());
  scene::visit_arrays(scene, [&](auto& array) { add(std::as_bytes(std::span(array))); });
  return hex(digest_of(std::as_bytes(std::span(values)))).substr(0, 32);
}

}  // namespace fire3dv::offline
