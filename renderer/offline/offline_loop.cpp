#include "renderer/offline/offline_loop.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "base/log.h"
#include "base/process/progress.h"
#include "protocol/record/attachments.h"
#include "protocol/wire/check.h"
#include "renderer/camera/default_look.h"
#include "renderer/passes/path/path_pass.h"

namespace fire3dv::offline {

namespace {

float aspect_of(VkExtent2D extent) {
  return static_cast<float>(extent.width) / static_cast<float>(extent.height);
}

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
                                                             record::Playback* playback,
                                                             std::function<bool()> should_stop) {
  std::unique_ptr<RecordingScene> scene(new RecordingScene);
  std::filesystem::path path = options.scene;
  scene->title_ = path.string();
  if (path.empty() && !playback) return Error{"no scene is named"};
  if (path.empty()) {
    const std::string file = wire::printable(playback->reader().name(), 4096);
    const auto& attachments = playback->reader().index().attachments;
    const auto scenes =
        std::ranges::count(attachments, record::kGlbType, &record::AttachmentIndex::media_type);
    if (scenes != 1)
      return Error{file + " has " + (scenes == 0 ? "no scene" : std::to_string(scenes) + " scenes") +
                   " in it" + scene_hint(*playback) +
                   ": name the one to draw, as in fire3dv render FILE.mcap SCENE.glb"};
    auto recorded = app::RecordedScene::extract(playback->reader());
    if (!recorded) return recorded.error();
    scene->recorded_ = std::move(*recorded);
    path = scene->recorded_->path();
    scene->title_ = scene->recorded_->name() + " in " + file;
    scene->recording_ = file;
  }
  scene->load_.emplace(
      path, options.convert, cache, passes::levels_for(options.draw.levels_of_detail),
      app::LoadedLook{app::wants_key_light(options.key_light, app::lights_by_choice(options)),
                      options.variant},
      std::move(should_stop));
  return scene;
}

OfflineLoop::OfflineLoop(const Parts& parts, const FrameTimes& times)
    : parts_(parts),
      times_(times),
      changes_(parts.set ? parts.set->changes() : nullptr),
      unchanged_settings_(parts.renderer.settings().draw()),
      current_settings_(unchanged_settings_) {
  current_settings_.environment = parts_.environment;
  devices_.push_back(std::make_unique<DrawingDevice>(parts_.device, parts_.renderer, nullptr));
  for (const auto& each : parts_.secondary)
    devices_.push_back(std::make_unique<DrawingDevice>(each->device(), each->renderer(), each.get()));
  for (size_t i = 0; i < std::min(devices_.size(), parts_.provenance.size()); ++i)
    devices_[i]->provenance = parts_.provenance[i];
  // A free camera is fitted to the scene at rest, independent of the first rendered frame.
  const VkExtent2D extent = parts_.renderer.extent();
  for (const app::CameraRig& camera : parts_.cameras) (void)camera.view(parts_.poses, aspect_of(extent));
  const uint64_t cameras = parts_.cameras.size();
  const FlowPlan flow = plan_flow(parts_.set, cameras, extent);
  if (flow.frames != 0) flow_.emplace(parts_.device, times_.frames * cameras, flow);
}

Result<bool> OfflineLoop::run(const Part& part, const std::function<bool(uint64_t frame)>& is_wanted,
                              const std::function<bool()>& should_stop) {
  Progress progress("fire3dv", parts_.set ? "images:" : "frames:");
  const uint64_t end = part.first + part.frames;
  const uint64_t before = flow_ ? flow_->reach_before() : 0, after = flow_ ? flow_->reach_after() : 0;
  const auto is_of_part = [&](uint64_t image) {
    return image >= part.first && image < end && is_wanted(image);
  };
  // Images beside the part are drawn for the flow of its own.
  const uint64_t begin = part.first - std::min(before, part.first);
  const uint64_t last = std::min(end + after, times_.frames * parts_.cameras.size());
  uint64_t image = begin;
  for (; image < std::max(last, end) && !should_stop(); ++image) {
    const bool wanted = is_of_part(image);
    if (flow_ ? !flow_->is_needed(image, is_of_part) : !wanted) continue;
    if (auto advanced = advance(image / parts_.cameras.size()); !advanced) return advanced.error();
    const auto drawn = draw(image, wanted, should_stop);
    if (!drawn) return drawn.error();
    if (!*drawn) break;
    if (auto delivered = deliver(); !delivered) return delivered.error();
    if (wanted) progress.update_with_end(image + 1 - part.first, part.frames);
  }
  for (const auto& each : devices_) each->device.wait(each->device.last_submitted());
  if (auto delivered = deliver(); !delivered) return delivered.error();
  return image == std::max(last, end);
}

// Waits until all scene changes of the moment are loaded, so that the image is deterministic.
Result<void> OfflineLoop::advance(uint64_t frame) {
  const int64_t line_ns = times_.at_ns(frame);
  if (parts_.streams) parts_.streams->advance(line_ns);
  parts_.scene.follow();
  while (!parts_.scene.settled()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    parts_.scene.follow();
  }
  if (parts_.streams) {
    for (const std::string& note : parts_.streams->take_log_messages()) log_message(note);
  }
  for (const std::string& note : parts_.scene.take_log_messages()) log_message(note);
  const bool is_new_scene = posed_scene_ != parts_.scene.replaced();
  posed_scene_ = parts_.scene.replaced();
  if (parts_.robot && is_new_scene) parts_.robot->set_scene(parts_.scene.scene(), parts_.poses.names());
  const bool is_at_rest = parts_.scene.user_edits().transforms.empty() && !parts_.robot;
  const auto animated = [&] {
    return (*parts_.animations)->at(static_cast<double>(parts_.poses.sim_time_ns().value_or(line_ns)) * 1e-9);
  };
  if (changes_)
    return change(frame, is_new_scene,
                  parts_.animations ? animated() : state::rest_pose(parts_.scene.scene()));
  if (parts_.animations) {
    pose(animated());
  } else if (is_new_scene && !is_at_rest) {
    pose(state::rest_pose(parts_.scene.scene()));
  }
  return {};
}

// Each frame starts from the unchanged edits and settings: changes of earlier ones leave no trace.
Result<void> OfflineLoop::change(uint64_t frame, bool is_new_scene, const state::RestPose& rest) {
  if (is_new_scene) {
    unchanged_edits_ = parts_.scene.user_edits();
    if (auto good = changes_->set_scene(parts_.scene.scene(), unchanged_settings_); !good) return good;
  }
  state::UserEdits edits = unchanged_edits_;
  settings::DrawSettings settings = unchanged_settings_;
  if (auto changed = changes_->change_frame(frame, edits, settings); !changed) return changed;
  if (settings.environment && parts_.renderer.needs_new_renderer(settings)) {
    if (auto replaced = parts_.replace_renderer(settings); !replaced) return replaced;
  }
  parts_.renderer.apply(settings);
  if (!settings.environment) settings.environment = current_settings_.environment;
  current_settings_ = std::move(settings);
  parts_.scene.set_user_edits(edits);
  parts_.scene.follow();
  // Another material variant is a scene of its own, with the same nodes and the user's edits of the file.
  if (posed_scene_ != parts_.scene.replaced()) {
    posed_scene_ = parts_.scene.replaced();
    if (parts_.robot) parts_.robot->set_scene(parts_.scene.scene(), parts_.poses.names());
    if (auto good = changes_->set_scene(parts_.scene.scene(), unchanged_settings_); !good) return good;
    parts_.scene.set_user_edits(edits);
    parts_.scene.follow();
  }
  pose(rest);
  for (;;) {
    const Result<bool> added = changes_->add_transforms(parts_.poses, edits.transforms);
    if (!added) return added.error();
    if (!*added) return {};
    parts_.scene.set_user_edits(edits);
    pose(rest);
  }
}

// With the joint positions and transforms of --overlay, in the order of live runs.
void OfflineLoop::pose(state::RestPose rest) {
  if (parts_.robot) parts_.robot->apply(rest);
  state::apply_transforms(parts_.scene.user_edits().transforms, parts_.scene.scene(), rest);
  parts_.poses.set_rest(rest);
}

wire::ImageOutputs OfflineLoop::outputs_of_image() const {
  const wire::ImageOutputs outputs = parts_.set ? parts_.set->outputs() : wire::ImageOutputs();
  return wire::ImageOutputs(outputs.bits() | (flow_ ? flow_->further_outputs() : 0));
}

// Images that are not wanted are drawn for the flow of others.
passes::FrameRequest OfflineLoop::request_of(uint64_t image, bool is_wanted) const {
  wire::ImageOutputs outputs = outputs_of_image();
  if (!is_wanted) outputs = wire::ImageOutputs(uint32_t{wire::kMotion} | uint32_t{wire::kOcclusionU32});
  passes::FrameRequest request{.extent = parts_.renderer.extent(), .outputs = wire::with_sources(outputs)};
  request.markers = parts_.markers && is_wanted;
  request.keeps_surfaces = flow_ && flow_->has_later();
  if (request.keeps_surfaces) request.flow_from = flow_->earlier(image, parts_.scene.replaced());
  return request;
}

app::CameraRig::Placed OfflineLoop::place(uint64_t image, size_t camera) const {
  auto placed = parts_.cameras[camera].placed(parts_.poses, aspect_of(parts_.renderer.extent()));
  if (changes_) changes_->change_camera(image, parts_.poses, placed);
  return placed;
}

Result<OfflineLoop::DrawingDevice*> OfflineLoop::next_device() {
  DrawingDevice& next = *devices_[drawn_++ % devices_.size()];
  if (next.following) {
    if (auto shown = next.following->show(parts_.scene, current_settings_); !shown) return shown.error();
  }
  parts_.scene.show_markers();
  return &next;
}

Result<bool> OfflineLoop::draw(uint64_t image, bool is_wanted, const std::function<bool()>& should_stop) {
  const VkExtent2D extent = parts_.renderer.extent();
  const auto next = next_device();
  if (!next) return next.error();
  DrawingDevice& on = **next;
  const float aspect = aspect_of(extent);
  const size_t number = image % parts_.cameras.size();
  passes::View view = parts_.cameras[number].view(parts_.poses, aspect);
  const app::CameraRig::Placed camera = place(image, number);
  if (changes_) {
    passes::View changed = passes::make_view(camera.camera, camera.world_from_camera, aspect);
    changed.camera = view.camera;
    changed.ground = view.ground;
    view = changed;
  }
  Progress progress("fire3dv",
                    (parts_.set ? "image " : "frame ") + std::to_string(image) + ": samples per pixel:");
  passes::PathHooks hooks{.should_stop = should_stop};
  if (const passes::PathPass* const paths = parts_.renderer.path_tracer()) {
    hooks.progress = [&, samples = paths->settings().samples_per_pixel](uint64_t done, uint64_t total) {
      progress.update_with_end(done * samples / total, samples);
    };
    if (parts_.checkpoint)
      parts_.checkpoint->attach(
          {image, extent, parts_.poses, view, parts_.scene.scene(), parts_.scene.replaced()}, hooks);
  }
  const passes::FrameRequest request = request_of(image, is_wanted);
  auto begun = on.renderer.begin_next(on.frames, request, parts_.poses, view, hooks);
  if (!begun) return begun.error();
  if (!*begun) return false;
  gpu::Recorder& recorder = (*begun)->recorder;
  passes::CameraHistory history;
  if (const auto earlier = flow_ ? flow_->earlier(image, parts_.scene.replaced()) : nullptr)
    history = *earlier;
  on.renderer.record((*begun)->prepared, recorder, on.frames.staging(), parts_.poses, view,
                     flow_ ? &history : nullptr);
  if (flow_) flow_->recorded(recorder, parts_.renderer, image, parts_.scene.replaced(), history, is_wanted);
  if (is_wanted) capture(on, recorder, image, view, camera);
  const uint64_t submitted = on.frames.submit();
  on.captures.submitted(submitted);
  if (flow_) flow_->submitted(submitted);
  images_ += is_wanted ? 1 : 0;
  return true;
}

void OfflineLoop::capture(DrawingDevice& on, gpu::Recorder& recorder, uint64_t image,
                          const passes::View& view, const app::CameraRig::Placed& camera) {
  capture::Provenance provenance{image, view.camera, parts_.poses.shown(),
                                 capture::path_provenance(on.renderer)};
  provenance.run = on.provenance;
  undelivered_.push_back(image);
  if (parts_.set) {
    std::optional<app::CameraRig::Placed> other;
    if (const auto number = parts_.set->other_of_pair(image % parts_.cameras.size()))
      other = parts_.cameras[*number].placed(parts_.poses, aspect_of(parts_.renderer.extent()));
    parts_.set->add_poses(image, camera, other ? &*other : nullptr, parts_.poses);
    on.captures.record(recorder, on.renderer, outputs_of_image(), parts_.scene.scene(), parts_.poses,
                       std::move(provenance));
  } else {
    on.captures.record(recorder, on.renderer.image(), std::move(provenance));
  }
}

Result<void> OfflineLoop::deliver() {
  for (const auto& each : devices_) {
    each->captures.poll([&](sinks::FrameImage&& image) {
      const uint64_t number = image.frame_index;
      arrived_.emplace(number, std::move(image));
    });
    (void)each->frames.take_finished();  // GPU times are not used
  }
  while (!undelivered_.empty()) {
    auto next = arrived_.extract(undelivered_.front());
    if (next.empty()) break;
    undelivered_.pop_front();
    auto taken = flow_ ? flow_->add(std::move(next.mapped())) : parts_.sink.consume(std::move(next.mapped()));
    if (!taken) return taken;
  }
  return flow_ ? flow_->deliver(parts_.sink) : Result<void>();
}

}  // namespace fire3dv::offline
