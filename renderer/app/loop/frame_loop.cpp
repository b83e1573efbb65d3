#include "renderer/app/loop/frame_loop.h"

#include <cmath>
#include <cstdio>
#include <span>
#include <string>
#include <string_view>

#include "base/files.h"
#include "base/log.h"
#include "base/plural.h"
#include "base/process/failure.h"
#include "base/text.h"
#include "renderer/app/start.h"
#include "renderer/app/stop_signals.h"
#include "renderer/camera/default_look.h"
#include "renderer/passes/path/path_pass.h"

namespace fire3dv::app {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds(Clock::duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

double milliseconds_since(Clock::time_point begin) {
  return milliseconds(Clock::now() - begin);
}

bool stands(const replay::TimelineControl& timeline) {
  const replay::TimelineState now = timeline.timeline();
  return !now.playing || now.at_end;
}

// Waits for messages: short while poses change, so that playout buffers are on time.
constexpr auto kBusyWait = std::chrono::milliseconds(1);
constexpr auto kIdleWait = std::chrono::milliseconds(50);
constexpr auto kWindowWait = std::chrono::milliseconds(15);  // between looks at the input of an idle window

// In lockstep peers wait for each other, data sets are as their streams say, and a replayed recording is the
// user's own: nothing is hidden.
state::DrawTimeSettings draw_time_settings(const FrameLoopContext& context) {
  const bool hides = !context.options.lockstep && !context.options.outputs.has_planes() && !context.timeline;
  return {.factor = hides ? context.options.draw_time_factor : 0,
          .is_software = context.device.report().type == gpu::DeviceType::software};
}

// Times of passes that draw markers alone.
state::DrawTimePolicy::Measured measured_times(const gpu::FrameTimes& times) {
  state::DrawTimePolicy::Measured measured;
  const auto ns_of = [](double milliseconds) { return static_cast<int64_t>(milliseconds * 1e6); };
  measured.total_ns = ns_of(times.total_ms);
  for (const gpu::PassTime& pass : times.passes) {
    const std::string_view name(pass.name);
    if (name == "markers" || name == "marker upload") measured.markers_ns += ns_of(pass.milliseconds);
  }
  return measured;
}

double milliseconds_of_deformation(const gpu::FrameTimes& times) {
  double ms = 0;
  for (const gpu::PassTime& pass : times.passes) {
    const std::string_view name = pass.name;
    if (name == "deform" || name == "deformed blas") ms += pass.milliseconds;
  }
  return ms;
}

}  // namespace

FrameLoop::FrameLoop(const FrameLoopContext& context)
    : context_(context),
      motion_(context.poses, context.scene, context.robot, context.animations),
      stream_wait_(context.options, context.receiver),
      facts_(context.options.begun),
      frames_(context.device),
      captures_(context.device),
      image_service_(
          context.device, context.renderer, context.poses, context.requests, context.scene,
          {context.options.peer_limits.slices.image_ns, context.options.lockstep, stop_was_requested}),
      draw_time_(context.scene, context.poses, draw_time_settings(context)),
      frame_extent_{context.options.width, context.options.height},
      taken_(passes::with_sources(context.options.outputs)),
      awaits_stream_(context.options.wait_for_stream),
      last_image_(Clock::now()),
      progress_("fire3dv", "images:") {
  context_.scene.charge_edit_time(
      [this](state::StreamId stream, int64_t ns) { context_.receiver.add_edit_time(stream, ns); });
  frames_.time(gpu::Timed::passes);  // for statistics, metrics and panels
  context_.scene.pace_vertices(!context_.options.lockstep && !wants_pixels());
  const bool is_delivered =
      context_.window || wants_pixels() || context_.options.frames != 0 || !context_.options.stats.empty();
  draws_for_browsers_only_ = context_.live_view && !is_delivered && !context_.options.lockstep;
  if (context_.window) taken_.add(wire::kColorSrgb8);
  if (context_.window) frame_extent_ = context_.window->image_extent();
  if (context_.window || draws_for_browsers_only_) motion_.use_timeline();
  image_service_.use_secondary_devices(context.secondary_devices, context.settings);
  image_service_.use_draw_time(draw_time_);
  log_technique();
}

// Logs how images are drawn.
void FrameLoop::log_technique() const {
  const bool compute = context_.renderer.settings().raster_path() == settings::RasterPath::visibility;
  if (const passes::PathPass* const paths = context_.renderer.path_tracer()) {
    const settings::PathSettings& settings = paths->settings();
    std::fprintf(stderr, "fire3dv: info: path-traced %s, %s per pixel, %s, seed %u\n",
                 passes::describe_path_back_end(paths->back_end()),
                 counted(settings.samples_per_pixel, "sample").c_str(),
                 counted(settings.bounces, "bounce").c_str(), settings.seed);
  } else {
    std::fprintf(stderr, "fire3dv: info: drawn %s, %s per pixel, shadows: %s\n",
                 compute ? "from a visibility buffer" : "forward",
                 counted(static_cast<uint32_t>(context_.renderer.settings().samples()), "sample").c_str(),
                 passes::describe(context_.renderer.settings().shadow_technique()));
    const auto drawn = static_cast<uint32_t>(context_.renderer.settings().samples());
    if (const uint32_t wanted = context_.options.draw.samples; drawn != wanted)
      log_message("--samples " + std::to_string(wanted) + " draws " + counted(drawn, "sample") +
                  " per pixel: " +
                  (compute ? "a visibility buffer has 1 or 4" : "the next lower count of this device"));
    if (context_.renderer.traces_ray_effects())
      std::fprintf(stderr, "fire3dv: info: ray effects: %s, %s\n",
                   settings::describe(context_.options.draw.ray_effects.on).c_str(),
                   passes::describe_path_back_end(context_.renderer.ray_effect_back_end()));
  }
  if (const std::string sun = describe_sun(context_.renderer); !sun.empty()) log_message("info: " + sun);
  if (context_.renderer.traces_shadow_rays() && !context_.renderer.traces_paths()) {
    std::fprintf(stderr, "fire3dv: info: acceleration structures are built %s\n",
                 gpu::describe(context_.device.queues().async));
  }
  log_motion();
}

// Logs how images in motion differ from those at rest.
void FrameLoop::log_motion() const {
  if (!(context_.window || context_.live_view) || !context_.renderer.reduces_motion()) return;
  const std::optional<settings::DrawSettings> reduced = settings::settings_in_motion(context_.settings);
  const bool fewer_samples = reduced->samples != context_.settings.samples;
  const bool maps_alone = reduced->shadows != context_.settings.shadows;
  std::fprintf(stderr,
               "fire3dv: info: on this CPU device, images in motion have %s%s%s; --motion-quality full draws "
               "them as those at rest\n",
               fewer_samples ? "1 sample per pixel" : "", fewer_samples && maps_alone ? " and " : "",
               maps_alone ? "shadows by maps alone" : "");
}

Result<void> FrameLoop::run() {
  const Activity activity("drawing images");
  while (!done()) {
    // Messages of adapters.
    if (context_.timeline) context_.receiver.expect_frames(!stands(*context_.timeline));
    const bool is_held = context_.options.lockstep && (has_undrawn_frame_ || has_due_images_);
    if (!is_held) has_undrawn_frame_ = poll_streams();
    motion_.apply_user_poses();
    log_notes();

    if (context_.metrics)
      context_.metrics->tell(context_.receiver, image_service_.open_requests(), context_.poses,
                             context_.scene.faults(), browser_numbers());

    // User input.
    const bool is_due = has_changed();
    if (context_.window && is_due) steer();
    if (draws_for_browsers_only_ && context_.live_view->has_viewers()) motion_.animate_for_browsers(images_);
    if (context_.live_view) {
      context_.live_view->poll(context_.timeline);
      motion_.apply_user_poses();  // viewers may have moved joints
    }

    // Image requests of simulators.
    const ImageService::Drawn served = image_service_.draw_due(frames_);
    has_due_images_ = served.has_more;
    // Between drawing and delivery: in lockstep whoever has an image finds the names of its scene.
    if (Result<void> written = served.any ? write_instance_file() : Result<void>(); !written) return written;
    if (context_.options.on_request || draws_for_browsers_only_) {
      if (Result<void> delivered = finish_served(served); !delivered) return delivered;
      continue;
    }

    // Rendering.
    if (Result<void> awaited = await_stream(); !awaited) return awaited;
    if (context_.options.lockstep && has_due_images_) {
      if (Result<void> delivered = deliver(); !delivered) return delivered;
      continue;
    }
    if ((awaits_stream_ && !context_.window) || (context_.options.lockstep && !has_undrawn_frame_)) {
      if (Result<void> delivered = deliver(); !delivered) return delivered;
      wait_for_messages();
      continue;
    }
    if (!is_due) {
      if (served.any)
        idle_.note_activity();
      else if (image_service_.in_flight())
        (void)image_service_.wait_for(image_service_.submitted(),
                                      context_.options.peer_limits.slices.image_ns);
      if (Result<void> delivered = deliver(); !delivered) return delivered;
      if (!served.any && !served.has_more) wait_for_messages();
      continue;
    }
    if (Result<void> waited = wait_for_slot(); !waited) return waited;
    if (context_.window && !context_.window->acquire()) {
      if (Result<void> delivered = deliver(); !delivered) return delivered;
      sinks::Window::wait_events(0.05);
      continue;
    }
    // The display wait took time: poll again to show the newest poses.
    if (context_.window && !context_.options.lockstep) poll_streams();
    motion_.apply_user_poses();  // the scene may have been replaced
    if (motion_.has_animations()) motion_.animate(images_);
    if (Result<void> listed = list_instances(); !listed) return listed;
    if (Result<void> drawn = draw(); !drawn) return drawn;
    has_undrawn_frame_ = false;

    // Finished images.
    if (Result<void> delivered = deliver(); !delivered) return delivered;
    if (context_.options.frames != 0) progress_.update(images_, context_.options.frames);
  }
  image_service_.wait(image_service_.submitted());
  if (Result<void> delivered = deliver(); !delivered) return delivered;
  if (context_.window) context_.window->finish();
  log_notes();
  if (Result<void> finished = context_.sink.finish(); !finished) return finished;
  if (checkpoint_ && images_ >= context_.options.frames) checkpoint_->remove();
  if (first_finished_)
    context_.stats.note_start("first image", milliseconds(*first_finished_ - context_.options.begun));
  return context_.stats.finish();
}

// False if another image would equal the last one and nobody receives it: no file or statistics.
bool FrameLoop::has_changed() {
  const bool is_delivered = wants_pixels() || context_.options.frames != 0 || !context_.options.stats.empty();
  // Without a window and viewers nothing resumes a replay or an animation that stands.
  const bool replays =
      context_.timeline && !((context_.window || context_.live_view) && stands(*context_.timeline));
  const AnimationTimeline* const animations = motion_.timeline();
  const bool animates = motion_.has_animations() && !(animations && stands(*animations));
  if (is_delivered || replays || animates || context_.options.lockstep) return true;
  uint64_t conditions = 0;  // of all streams: the overlay of stale streams and the panels show them
  for (const state::Stream& stream : context_.poses.streams()) {
    conditions = 31 * conditions + 2 * static_cast<uint64_t>(stream.condition) + (stream.active ? 1 : 0);
    if (context_.window)
      conditions = 31 * conditions + stream.scalars().revision() +  // plotted, also without frames
                   stream.inputs().revision();
  }
  const std::array<uint64_t, 3> revisions = {context_.poses.revision(), context_.scene.updates(), conditions};
  const bool is_edited = context_.live_view && context_.live_view->take_change();
  const bool is_active =
      context_.window && (context_.window->take_activity() || std::exchange(has_noted_, false) || is_edited);
  idle_.update(revisions, is_active);
  return idle_.take_due_image() || (context_.window && (refines() || idle_.is_lingering() ||
                                                        view_motion_.needs_image_at_rest(Clock::now())));
}

void FrameLoop::wait_for_messages() {
  stream_wait_.report(images_, context_.timeline != nullptr);
  const bool is_live = context_.options.lockstep || awaits_stream_ || idle_.is_busy();
  const bool is_busy = !unacknowledged_.empty() || image_service_.in_flight() ||
                       (context_.receiver.active_streams() != 0 && is_live);
  const bool has_viewers = context_.live_view && context_.live_view->has_viewers();
  const bool is_viewed = has_viewers && context_.live_view->is_busy();
  context_.receiver.wait(is_busy || is_viewed             ? kBusyWait
                         : context_.window || has_viewers ? kWindowWait
                                                          : kIdleWait);
}

void FrameLoop::log_notes() {
  const auto say = [this](const std::vector<std::string>& notes) {
    for (const std::string& note : notes) {
      print_log_line("fire3dv", note);
      if (context_.window) facts_.note(note);
      has_noted_ = true;
    }
  };
  say(context_.receiver.take_log_messages());
  say(context_.scene.take_log_messages());
  say(draw_time_.take_log_messages());
  if (context_.recording) say(context_.recording->take_log_messages());
  if (context_.window) say(context_.window->take_log_messages());
  if (context_.next) say(context_.next->take_log_messages());
  if (context_.reload) say(context_.reload->take_log_messages());
}

// Acknowledgement in on-request mode: a frame counts as displayed when its requested images are rendered. In
// lockstep these are all of its images; otherwise a newer frame may replace it earlier.
Result<void> FrameLoop::finish_served(const ImageService::Drawn& served) {
  const bool is_news = has_undrawn_frame_ && !(context_.options.lockstep && served.has_more);
  if (is_news) unacknowledged_.push_back({image_service_.submitted(), context_.poses.shown()});
  if (is_news) has_undrawn_frame_ = false;
  if (!served.any && image_service_.in_flight())
    (void)image_service_.wait_for(image_service_.submitted(), context_.options.peer_limits.slices.image_ns);
  if (Result<void> delivered = deliver(); !delivered) return delivered;
  if (served.any || is_news) return {};
  if (context_.options.on_request)
    context_.receiver.wait(std::chrono::milliseconds(1));
  else
    wait_for_messages();
  return {};
}

bool FrameLoop::poll_streams() {
  const bool came = context_.receiver.poll();
  if (image_service_.is_tracing()) return came;  // the scene stays
  const uint64_t replaced = context_.scene.replaced();
  if (context_.reload) context_.reload->poll(context_.scene);
  const bool released = context_.scene.follow();
  if (context_.scene.replaced() != replaced) context_.receiver.notify_bindings();
  for (const auto& edit : context_.scene.take_ineffective_edits())
    context_.receiver.report_ineffective_edit(edit.stream, edit.reason);
  if (!context_.renderer.traces_paths()) draw_time_.poll();
  for (const auto& [stream, message] : draw_time_.take_messages_to_streams())
    context_.receiver.report_drawing(stream, message);
  return came || released;
}

bool FrameLoop::done() {
  if (stop_was_requested() || (context_.window && context_.window->should_close())) return true;
  if (context_.options.frames && images_ >= context_.options.frames) return true;
  const bool holds_next = context_.window && context_.window->holds_next();
  if (context_.next && !holds_next && context_.next->is_ready() &&
      (!context_.window || context_.window->may_show_next()))
    return switches_document_ = true;
  if (!context_.options.exit_when_done || context_.receiver.active_streams() != 0) return false;
  // A recording may contain later streams, or none.
  return context_.timeline ? context_.timeline->timeline().at_end && !has_undrawn_frame_
                           : context_.receiver.had_streams();
}

Result<void> FrameLoop::await_stream() {
  if (!awaits_stream_) return {};
  if (!context_.poses.shown().empty()) {
    awaits_stream_ = false;
    last_image_ = Clock::now();
    return {};
  }
  return stream_wait_.check_timeout();
}

void FrameLoop::steer() {
  // Animations follow the simulated time of a stream, so a replay's timeline drives them, too.
  replay::TimelineControl* timeline = context_.timeline;
  if (!timeline && !context_.poses.sim_time_ns()) timeline = motion_.timeline();
  context_.window->steer(
      facts_.begin_assembly(context_.scene.scene(), context_.scene.replaced(), context_.receiver,
                            context_.poses, context_.scene.markers(), context_.renderer, context_.device,
                            context_.camera.node(), context_.window->records_video()),
      timeline);
  if (const std::optional<std::filesystem::path> file = context_.window->take_opened(); file && context_.next)
    context_.next->open(*file);
}

BrowserNumbers FrameLoop::browser_numbers() const {
  if (!context_.live_view) return {};
  return {context_.live_view->count_viewers(serve::Access::control),
          context_.live_view->count_viewers(serve::Access::view),
          context_.live_view->server().encode_totals(serve::Codec::jpeg),
          context_.live_view->server().encode_totals(serve::Codec::h264),
          context_.live_view->server().encode_totals(serve::Codec::vp8)};
}

void FrameLoop::show_markers() {
  context_.scene.show_markers(context_.window ? context_.window->update_overlay()
                                              : std::span<const state::ShownMarker>());
}

Result<void> FrameLoop::draw() {
  if (context_.window) frame_extent_ = context_.window->image_extent();
  const VkExtent2D extent = frame_extent_;
  passes::FrameRequest request{.extent = extent, .outputs = taken_};
  show_markers();
  // The colours of a data set are those of its labels, unless the user chooses otherwise.
  request.markers = !context_.options.outputs.has_planes() || context_.options.markers_in_data_sets;
  request.inspection = context_.window ? context_.window->take_inspection()
                                       : passes::Inspection{context_.options.debug_view, scene::kNone, {}};
  request.refines = request.shows_previous_image = context_.window != nullptr;
  const passes::View view = context_.camera.view(
      context_.poses, static_cast<float>(extent.width) / static_cast<float>(extent.height));
  request.in_motion = is_in_motion(view);
  if (draw_time_.is_active()) {
    const glm::vec2 size_px(extent.width, extent.height);
    const bool is_changed = draw_time_.begin_image({.pixels = uint64_t{extent.width} * extent.height,
                                                    .view = {view.clip_from_world, size_px},
                                                    .markers = request.markers});
    if (is_changed) show_markers();
  }
  // Images in files are whole.
  const bool is_stored = wants_pixels() || (context_.window && context_.window->captures_image());
  frames_.limits().set(is_stored ? std::nullopt : draw_time_.abandon_after_ns());
  Progress progress("fire3dv", "samples per pixel:");
  Result<std::optional<passes::SceneRenderer::BegunFrame>> frame =
      context_.renderer.begin_next(frames_, request, context_.poses, view, path_hooks(view, progress));
  if (!frame) return frame.error();
  if (!*frame) {  // a signal has stopped it
    report_stopped_paths();
    return {};
  }
  gpu::Recorder& recorder = (*frame)->recorder;
  const Clock::time_point begun = Clock::now();
  const std::vector<state::FrameTag> shown = context_.poses.shown();
  warn_of_empty_image(view, shown);
  context_.renderer.record((*frame)->prepared, recorder, frames_.staging(), context_.poses, view, &history_);
  if (taken_.has(wire::kColorSrgb8))
    context_.renderer.draw_stale_overlay(
        recorder, stale_condition(context_.poses.streams(), context_.options.play.mark_held));
  if (wants_pixels() && !awaits_stream_)
    captures_.record(recorder, context_.renderer, context_.options.outputs, context_.scene.scene(),
                     context_.poses,
                     {images_, view.camera, shown, capture::path_provenance(context_.renderer),
                      context_.poses.hidden_streams(), context_.provenance});
  if (context_.window) {
    if (Result<void> drawn =
            context_.window->record(recorder, frames_.staging(),
                                    {images_, view.camera, shown, capture::path_provenance(context_.renderer),
                                     context_.poses.hidden_streams()},
                                    request.in_motion);
        !drawn)
      return drawn;
  }
  const uint64_t done_at = context_.window
                               ? frames_.submit(context_.window->waits(), context_.window->signals())
                               : frames_.submit();
  if (context_.window) context_.window->present(done_at);
  context_.renderer.submitted(done_at);
  draw_time_.submitted(frames_.frame_index());
  captures_.submitted(done_at);
  context_.scene.vertex_pacing().frame_recorded(frames_.frame_index());
  unacknowledged_.push_back({image_service_.submitted(), shown});
  if (images_ + uncounted_images_ == 0) report_slow_start(done_at);
  note_cost(shown, begun);
  ++(awaits_stream_ ? uncounted_images_ : images_);
  return context_.window ? context_.window->draw_others(request.in_motion) : Result<void>();
}

// Files, videos, screenshots and simulators that wait get images of full quality.
bool FrameLoop::is_in_motion(const passes::View& view) {
  if (!context_.window || !context_.renderer.reduces_motion()) return false;
  const bool moves = view_motion_.update(context_.poses, context_.scene.edits().revisions(),
                                         view.clip_from_world, Clock::now());
  const bool is_reduced =
      moves && !wants_pixels() && !context_.options.lockstep && !context_.window->captures_image();
  view_motion_.note_image(is_reduced);
  return is_reduced;
}

// The first images take long where the driver compiles shaders.
void FrameLoop::report_slow_start(uint64_t done_at) {
  constexpr int64_t kPatienceNs = 1'000'000'000;
  if (!context_.device.wait_for(done_at, kPatienceNs))
    print_log_line(
        "fire3dv",
        "info: the driver compiles shaders for the first image, which may take half a minute; later "
        "starts are faster");
}

// Once, for the first image; with adapters, for the first image of one of their frames.
void FrameLoop::warn_of_empty_image(const passes::View& view, const std::vector<state::FrameTag>& shown) {
  const bool awaits_frames = !context_.receiver.links().empty() && shown.empty();
  if (awaits_stream_ || awaits_frames || std::exchange(checked_visibility_, true)) return;
  if (const std::optional<std::string> reason = reason_for_empty_image(
          context_.scene.scene(), &context_.scene.edits(), context_.poses, view, frame_extent_.height))
    print_log_line("fire3dv", warning("nothing is visible: " + *reason));
}

void FrameLoop::note_cost(const std::vector<state::FrameTag>& shown, Clock::time_point begun) {
  FrameCost cost;
  cost.frame_index = images_;
  cost.cpu_ms = milliseconds_since(begun);
  cost.frame_ms = milliseconds_since(last_image_);
  last_image_ = Clock::now();
  const auto now_ns = static_cast<int64_t>(last_image_.time_since_epoch() / std::chrono::nanoseconds(1));
  for (const state::FrameTag& tag : shown) {
    // Minimum over all streams. Publish times of other machines' clocks are not comparable.
    const double age_ms = static_cast<double>(now_ns - static_cast<int64_t>(tag.publish_time_ns)) * 1e-6;
    if (age_ms >= 0 && (!cost.pose_age_ms || age_ms < *cost.pose_age_ms)) cost.pose_age_ms = age_ms;
  }
  if (!awaits_stream_) context_.stats.add(cost);
  if (context_.metrics) context_.metrics->drawn(shown, context_.receiver, cost);
  if (context_.window) facts_.drawn(cost.frame_index + 1, cost.frame_ms, cost.cpu_ms, cost.pose_age_ms);
}

// A submission of a peer's image may take long: meanwhile the peer may withdraw it or leave.
Result<void> FrameLoop::wait_for_slot() {
  if (context_.options.lockstep || context_.timeline) return {};  // begin() waits
  while (!frames_.wait_for_slot(context_.options.peer_limits.slices.image_ns) && !stop_was_requested()) {
    poll_streams();
    image_service_.end_withdrawn(frames_);
    if (Result<void> delivered = deliver(); !delivered) return delivered;
  }
  return {};
}

Result<void> FrameLoop::deliver() {
  // In lockstep the adapter waits for this image, so the GPU is awaited; otherwise delivery is asynchronous.
  if (context_.options.lockstep) image_service_.wait(image_service_.submitted());
  if (Result<void> delivered = captures_.deliver(context_.sink); !delivered) return delivered;
  image_service_.deliver();
  if (const std::optional<int64_t> ran_ns = frames_.limits().take_ended_early())
    draw_time_.abandoned(*ran_ns);
  if (context_.window) context_.window->deliver();
  while (!unacknowledged_.empty() && image_service_.is_done(unacknowledged_.front().drawn)) {
    if (!first_finished_) first_finished_ = Clock::now();
    context_.receiver.acknowledge(unacknowledged_.front().shown);
    unacknowledged_.erase(unacknowledged_.begin());
  }
  for (gpu::FrameTimes& times : frames_.take_finished()) {
    context_.scene.vertex_pacing().frame_finished(times.frame_index, milliseconds_of_deformation(times));
    if (context_.metrics) context_.metrics->add(times);
    if (context_.window) facts_.add(times);
    draw_time_.finished(times.frame_index, measured_times(times));
    if (times.frame_index < uncounted_images_) continue;
    times.frame_index -= uncounted_images_;
    context_.stats.add(times);
  }
  return {};
}

// Writes the instance list: the meaning of the instance numbers in the images.
Result<void> FrameLoop::list_instances() {
  const bool labelled = taken_.has(wire::kInstanceU32) || context_.options.outputs.has(wire::kSemanticU32);
  if (!wants_pixels() || !labelled || instances_listed_ == context_.scene.replaced()) return {};
  instances_listed_ = context_.scene.replaced();
  warn_of_missing_labels(context_.scene.scene(), context_.scene.edits(),
                         context_.renderer.settings().draw().label_alpha);
  const std::string text = capture::list_instances(context_.scene.scene());
  return write_whole_file(context_.options.out / "instances.jsonl",
                          {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

Result<void> FrameLoop::write_instance_file() {
  const std::filesystem::path& path = context_.options.instances;
  if (path.empty() || instance_file_written_ == context_.scene.replaced()) return {};
  instance_file_written_ = context_.scene.replaced();
  const std::string text = capture::list_instances(context_.scene.scene());
  return write_whole_file(path, {reinterpret_cast<const uint8_t*>(text.data()), text.size()},
                          base::Durability::contents);
}

}  // namespace fire3dv::app
