#include "renderer/app/frame_loop.h"

#include <cmath>
#include <cstdio>
#include <span>
#include <sstream>
#include <thread>
#include <utility>

#include "base/files.h"
#include "base/log.h"
#include "base/plural.h"
#include "base/text.h"
#include "renderer/app/stop_signals.h"
#include "renderer/camera/default_look.h"
#include "renderer/capture/capture.h"

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
constexpr auto kBusyTime = std::chrono::seconds(1);  // since the last change
// Images after a change: motion vectors and two-pass culling refer to the previous image.
constexpr int kImagesOfChange = 3;
// A window is drawn for this long after a change: tooltips appear late.
constexpr auto kLingerTime = std::chrono::milliseconds(700);
constexpr auto kWindowWait = std::chrono::milliseconds(15);  // between looks at the input of an idle window
// A wait for streams is reported after this time.
constexpr auto kReportedWait = std::chrono::seconds(3);

}  // namespace

passes::DrawSettings draw_settings(const Options& options,
                                   std::shared_ptr<const scene::EnvironmentImage> environment) {
  passes::DrawSettings settings;
  settings.environment = std::move(environment);
  settings.environment_intensity = options.environment_intensity;
  settings.environment_rotation_rad = glm::radians(options.environment_rotation_deg);
  settings.background = options.background;
  settings.samples = options.samples;
  settings.raster = options.raster;
  settings.cull = options.cull;
  settings.levels_of_detail = options.levels_of_detail;
  settings.anisotropy = options.anisotropy;
  settings.shadows = options.shadows;
  settings.ray_effects.on = options.ray_effects;
  settings.ray_effects.set_rays(options.ray_effect_rays);
  settings.ray_effects.back_end = options.shadows.back_end;
  settings.path = options.path;
  settings.post.exposure = options.exposure.value_or(1);  // set_exposure() replaces it
  settings.post.metered = options.metered_exposure;
  settings.post.tone_map = options.tone_map;
  settings.post.fxaa = options.fxaa;
  settings.post.bloom = options.bloom;
  settings.post.lens = options.lens;
  return settings;
}

std::string lacking_ray_effects(const gpu::Device& device, const Options& options) {
  if (!options.ray_effects.any()) return "";
  const bool has_visibility_buffer =
      options.raster != passes::RasterPath::forward && device.report().int64_atomics;
  const Result<void> can = passes::can_trace_ray_effects(device, has_visibility_buffer);
  return can ? "" : "--ray-effects: " + can.error().message;
}

FrameLoop::FrameLoop(const FrameLoopContext& context)
    : device_(context.device),
      poses_(context.poses),
      receiver_(context.receiver),
      scene_(context.scene),
      animations_(context.animations),
      robot_(context.robot),
      camera_(context.camera),
      sink_(context.sink),
      window_(context.window),
      stats_(context.stats),
      facts_(context.options.begun),
      options_(context.options),
      frames_(device_),
      renderer_(context.renderer),
      captures_(device_),
      image_service_(device_, renderer_, poses_, context.requests, scene_,
                     {options_.peer_limits.slices.image_ns, options_.lockstep, stop_was_requested}),
      taken_(passes::with_sources(options_.outputs)),
      awaits_stream_(options_.wait_for_stream),
      started_(Clock::now()),
      last_image_(started_),
      progress_("fire3dv", "images:") {
  scene_.charge_edit_time(
      [this](state::StreamId stream, int64_t ns) { receiver_.add_edit_time(stream, ns); });
  frames_.time(gpu::Timed::passes);  // for statistics, metrics and panels
  frame_extent_ = {options_.width, options_.height};
  if (window_) taken_.add(wire::kColorSrgb8);
  if (window_) frame_extent_ = window_->image_extent();
  if (window_ && animations_) animation_timeline_.emplace(animations_->duration_s());
  const bool compute = renderer_.raster_path() == passes::RasterPath::visibility;
  if (const passes::PathPass* const paths = renderer_.path_tracer()) {
    const passes::PathSettings& settings = paths->settings();
    std::fprintf(stderr, "fire3dv: info: path-traced %s, %s per pixel, %s, seed %u\n",
                 passes::describe_path_back_end(paths->back_end()),
                 counted(settings.samples_per_pixel, "sample").c_str(),
                 counted(settings.bounces, "bounce").c_str(), settings.seed);
  } else {
    std::fprintf(stderr, "fire3dv: info: drawn %s, %s per pixel, shadows: %s\n",
                 compute ? "from a visibility buffer" : "forward",
                 counted(static_cast<uint32_t>(renderer_.samples()), "sample").c_str(),
                 passes::describe(renderer_.shadow_technique()));
    if (renderer_.traces_ray_effects())
      std::fprintf(stderr, "fire3dv: info: ray effects: %s, %s\n",
                   passes::describe(options_.ray_effects).c_str(),
                   passes::describe_path_back_end(renderer_.ray_effect_back_end()));
  }
  if (renderer_.traces() && !renderer_.traces_paths()) {
    std::fprintf(stderr, "fire3dv: info: acceleration structures are built %s\n",
                 gpu::describe(device_.queues().async));
  }
}

Result<void> FrameLoop::run() {
  while (!done()) {
    // Messages of adapters.
    if (timeline_) receiver_.expect_frames(!stands(*timeline_));
    const bool is_held = options_.lockstep && (has_undrawn_frame_ || has_due_images_);
    if (!is_held) has_undrawn_frame_ = poll_streams();
    pose_by_hand();
    log_notes();

    if (metrics_)
      metrics_->tell(receiver_, image_service_.open_requests(), poses_, scene_.faults(), viewer_numbers());

    // User input.
    const bool is_due = has_changed();
    if (window_ && is_due) steer();
    if (draws_for_viewers_only_) animate_for_viewers();
    if (live_view_) {
      live_view_->poll(timeline_);
      pose_by_hand();  // viewers may have moved joints
    }

    // Image requests of simulators.
    const ImageService::Drawn served = image_service_.draw_due(frames_);
    has_due_images_ = served.has_more;
    if (options_.on_request || draws_for_viewers_only_) {
      if (Result<void> delivered = finish_served(served); !delivered) return delivered;
      continue;
    }

    // Rendering.
    if (Result<void> awaited = await_stream(); !awaited) return awaited;
    if (options_.lockstep && has_due_images_) {
      if (Result<void> delivered = deliver(); !delivered) return delivered;
      continue;
    }
    if ((awaits_stream_ && !window_) || (options_.lockstep && !has_undrawn_frame_)) {
      if (Result<void> delivered = deliver(); !delivered) return delivered;
      wait_for_messages();
      continue;
    }
    if (!is_due) {
      if (served.any)
        changed_ = Clock::now();
      else if (image_service_.in_flight())
        (void)image_service_.wait_for(image_service_.submitted(), options_.peer_limits.slices.image_ns);
      if (Result<void> delivered = deliver(); !delivered) return delivered;
      if (!served.any && !served.has_more) wait_for_messages();
      continue;
    }
    if (window_ && !window_->acquire()) {
      if (Result<void> delivered = deliver(); !delivered) return delivered;
      window_->wait_events(0.05);
      continue;
    }
    // The display wait took time: poll again to show the newest poses.
    if (window_ && !options_.lockstep) poll_streams();
    pose_by_hand();  // the scene may have been replaced
    if (animations_) animate();
    if (Result<void> listed = list_instances(); !listed) return listed;
    if (Result<void> drawn = draw(); !drawn) return drawn;
    has_undrawn_frame_ = false;

    // Finished images.
    if (Result<void> delivered = deliver(); !delivered) return delivered;
    progress_.update(images_, options_.frames);
  }
  image_service_.wait(image_service_.submitted());
  if (Result<void> delivered = deliver(); !delivered) return delivered;
  if (window_) window_->finish();
  log_notes();
  if (Result<void> finished = sink_.finish(); !finished) return finished;
  if (checkpoint_ && images_ >= options_.frames) checkpoint_->remove();
  if (first_finished_) stats_.note_start("first image", milliseconds(*first_finished_ - options_.begun));
  return stats_.finish();
}

// False if another image would equal the last one and nobody receives it: no file or statistics.
bool FrameLoop::has_changed() {
  const bool is_delivered = wants_pixels() || options_.frames != 0 || !options_.stats.empty();
  // Without a window and viewers nothing resumes a replay or an animation that stands.
  const bool replays = timeline_ && !((window_ || live_view_) && stands(*timeline_));
  const bool animates = animations_ && !(animation_timeline_ && stands(*animation_timeline_));
  if (is_delivered || replays || animates || options_.lockstep) return true;
  uint64_t conditions = 0;  // of all streams: the overlay of stale streams and the panels show them
  for (const state::Stream& stream : poses_.streams()) {
    conditions = 31 * conditions + 2 * static_cast<uint64_t>(stream.condition) + (stream.active ? 1 : 0);
    if (window_) conditions = 31 * conditions + stream.scalars().revision();  // plotted, also without frames
  }
  const std::array<uint64_t, 3> revisions = {poses_.revision(), scene_.updates(), conditions};
  const bool is_edited = live_view_ && live_view_->take_change();
  const bool is_active =
      window_ && (window_->take_activity() || std::exchange(has_noted_, false) || is_edited);
  if (revisions != drawn_revisions_ || is_active) {
    drawn_revisions_ = revisions;
    images_of_change_ = kImagesOfChange;
    changed_ = Clock::now();
    lingers_until_ = changed_ + kLingerTime;
  }
  if (images_of_change_ == 0) return window_ && (refines() || Clock::now() < lingers_until_);
  --images_of_change_;
  return true;
}

void FrameLoop::wait_for_messages() {
  report_wait();
  const bool is_live = options_.lockstep || awaits_stream_ || Clock::now() - changed_ < kBusyTime;
  const bool is_busy =
      !unacknowledged_.empty() || image_service_.in_flight() || (receiver_.active_streams() != 0 && is_live);
  const bool has_viewers = live_view_ && live_view_->has_viewers();
  const bool is_viewed = has_viewers && live_view_->is_busy();
  receiver_.wait(is_busy || is_viewed ? kBusyWait : window_ || has_viewers ? kWindowWait : kIdleWait);
}

// Names what --lockstep, --exit-when-done and --frames wait for, once for each kind of wait.
void FrameLoop::report_wait() {
  const bool waits = options_.lockstep || options_.exit_when_done || options_.frames != 0;
  if (receiver_.active_streams() != 0 || !waits || timeline_) {
    streamless_since_.reset();
    return;
  }
  if (!streamless_since_) streamless_since_ = Clock::now();
  bool& reported = receiver_.had_streams() ? reported_ended_ : reported_absent_;
  if (reported || Clock::now() - *streamless_since_ < kReportedWait) return;
  reported = true;
  std::string uris;
  for (const StreamReceiver::LinkReport& link : receiver_.links())
    uris += (uris.empty() ? "" : ", ") + link.uri;
  std::string text = receiver_.had_streams() ? "all streams have ended; waiting for another one at "
                                             : "waiting for a stream at ";
  text += uris;
  if (options_.frames != 0)
    text += ": " + std::to_string(options_.frames - images_) + " of " + counted(options_.frames, "image") +
            " to draw";
  if (options_.lockstep) text += "; --lockstep draws one image for each pose frame";
  if (options_.exit_when_done && !receiver_.had_streams())
    text += "; --exit-when-done exits after the first stream that starts from now on";
  if (!options_.exit_when_done) text += "; add --exit-when-done to exit when the last stream ends";
  print_log_line("fire3dv", text);
}

void FrameLoop::log_notes() {
  const auto say = [this](const std::vector<std::string>& notes) {
    for (const std::string& note : notes) {
      print_log_line("fire3dv", note);
      if (window_) facts_.note(note);
      has_noted_ = true;
    }
  };
  say(receiver_.take_log_messages());
  say(scene_.take_log_messages());
  if (recording_) say(recording_->take_log_messages());
  if (window_) say(window_->take_log_messages());
  if (next_) say(next_->take_log_messages());
  if (reload_) say(reload_->take_log_messages());
}

// Acknowledgement in on-request mode: a frame counts as displayed when its requested images are rendered. In
// lockstep these are all of its images; otherwise a newer frame may replace it earlier.
Result<void> FrameLoop::finish_served(const ImageService::Drawn& served) {
  const bool is_news = has_undrawn_frame_ && !(options_.lockstep && served.has_more);
  if (is_news) unacknowledged_.push_back({image_service_.submitted(), poses_.shown()});
  if (is_news) has_undrawn_frame_ = false;
  if (!served.any && image_service_.in_flight())
    (void)image_service_.wait_for(image_service_.submitted(), options_.peer_limits.slices.image_ns);
  if (Result<void> delivered = deliver(); !delivered) return delivered;
  if (served.any || is_news) return {};
  if (options_.on_request)
    receiver_.wait(std::chrono::milliseconds(1));
  else
    wait_for_messages();
  return {};
}

bool FrameLoop::poll_streams() {
  const bool came = receiver_.poll();
  if (image_service_.is_tracing()) return came;  // the scene stays
  const uint64_t replaced = scene_.replaced();
  if (reload_) reload_->poll(scene_);
  const bool released = scene_.follow();
  if (scene_.replaced() != replaced) receiver_.notify_bindings();
  return came || released;
}

bool FrameLoop::done() {
  if (stop_was_requested() || (window_ && window_->should_close())) return true;
  if (options_.frames && images_ >= options_.frames) return true;
  const bool holds_next = window_ && window_->holds_next();
  if (next_ && !holds_next && next_->is_ready() && (!window_ || window_->may_show_next()))
    return goes_on_ = true;
  if (!options_.exit_when_done || receiver_.active_streams() != 0) return false;
  // A recording may contain later streams, or none.
  return timeline_ ? timeline_->timeline().at_end && !has_undrawn_frame_ : receiver_.had_streams();
}

Result<void> FrameLoop::await_stream() {
  if (!awaits_stream_) return {};
  if (!poses_.shown().empty()) {
    awaits_stream_ = false;
    last_image_ = Clock::now();
    return {};
  }
  const std::chrono::duration<double> limit = options_.stream_timeout;
  if (limit.count() == 0 || Clock::now() - started_ < limit) return {};
  std::string uris;
  for (const StreamReceiver::LinkReport& link : receiver_.links())
    uris += (uris.empty() ? "" : ", ") + link.uri;
  std::ostringstream seconds;
  seconds << limit.count();
  return Error{"no pose frame arrived at " + uris + " within " + seconds.str() +
               " s; start a simulator that publishes there, or raise --wait-for-stream"};
}

void FrameLoop::steer() {
  // Animations follow the simulated time of a stream, so a replay's timeline drives them, too.
  replay::TimelineControl* timeline = timeline_;
  if (!timeline && animation_timeline_ && !poses_.sim_time_ns()) timeline = &*animation_timeline_;
  window_->steer(facts_.begin_assembly(scene_.scene(), scene_.replaced(), receiver_, poses_, scene_.markers(),
                                       renderer_, device_, camera_.node(), window_->records_video()),
                 timeline);
  if (const std::optional<std::filesystem::path> file = window_->take_opened(); file && next_)
    next_->open(*file);
}

ViewerNumbers FrameLoop::viewer_numbers() const {
  if (!live_view_) return {};
  return {live_view_->count_viewers(serve::Access::control), live_view_->count_viewers(serve::Access::view),
          live_view_->server().encode_totals(serve::Codec::jpeg),
          live_view_->server().encode_totals(serve::Codec::h264),
          live_view_->server().encode_totals(serve::Codec::vp8)};
}

void FrameLoop::show_in_browsers(LiveView* live_view) {
  live_view_ = live_view;
  const bool is_delivered = window_ || wants_pixels() || options_.frames != 0 || !options_.stats.empty();
  draws_for_viewers_only_ = live_view_ && !is_delivered && !options_.lockstep;
  if (draws_for_viewers_only_ && animations_) animation_timeline_.emplace(animations_->duration_s());
}

Result<void> FrameLoop::draw() {
  if (window_) frame_extent_ = window_->image_extent();
  const VkExtent2D extent = frame_extent_;
  passes::FrameRequest request{.extent = extent, .outputs = taken_};
  scene_.show_markers(window_ ? window_->update_overlay() : std::span<const state::ShownMarker>());
  // The colours of a data set are those of its labels, unless the user chooses otherwise.
  request.markers = !options_.outputs.has_planes() || options_.markers_in_data_sets;
  request.inspection =
      window_ ? window_->take_inspection() : passes::Inspection{options_.debug_view, scene::kNone, {}};
  request.refines = request.keeps_last = window_ != nullptr;
  const passes::View view =
      camera_.view(poses_, static_cast<float>(extent.width) / static_cast<float>(extent.height));
  Progress progress("fire3dv", "samples per pixel:");
  Result<std::optional<passes::SceneRenderer::BegunFrame>> frame =
      renderer_.begin_next(frames_, request, poses_, view, path_hooks(view, progress));
  if (!frame) return frame.error();
  if (!*frame) {  // a signal has stopped it
    report_stopped_paths();
    return {};
  }
  gpu::Recorder& recorder = (*frame)->recorder;
  const Clock::time_point begun = Clock::now();
  const std::vector<state::FrameTag> shown = poses_.shown();
  warn_of_empty_image(view, shown);
  renderer_.record((*frame)->prepared, recorder, frames_.staging(), poses_, view, &history_);
  if (taken_.has(wire::kColorSrgb8))
    renderer_.draw_stale_overlay(recorder, stale_condition(poses_.streams(), options_.play.mark_held));
  if (wants_pixels() && !awaits_stream_)
    captures_.record(recorder, renderer_, options_.outputs, scene_.scene(), poses_,
                     {images_, view.camera, shown, capture::path_provenance(renderer_)});
  if (window_) {
    if (Result<void> drawn = window_->record(
            recorder, frames_.staging(), {images_, view.camera, shown, capture::path_provenance(renderer_)});
        !drawn)
      return drawn;
  }
  const uint64_t done_at = window_ ? frames_.submit(window_->waits(), window_->signals()) : frames_.submit();
  if (window_) window_->present(done_at);
  renderer_.submitted(done_at);
  captures_.submitted(done_at);
  unacknowledged_.push_back({image_service_.submitted(), shown});
  note_cost(shown, begun);
  ++(awaits_stream_ ? uncounted_images_ : images_);
  return window_ ? window_->draw_others() : Result<void>();
}

// Once, for the first image; with adapters, for the first image of one of their frames.
void FrameLoop::warn_of_empty_image(const passes::View& view, const std::vector<state::FrameTag>& shown) {
  const bool awaits_frames = !receiver_.links().empty() && shown.empty();
  if (awaits_stream_ || awaits_frames || std::exchange(checked_visibility_, true)) return;
  if (const std::optional<std::string> reason =
          reason_for_empty_image(scene_.scene(), &scene_.edits(), poses_, view, frame_extent_.height))
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
  if (!awaits_stream_) stats_.add(cost);
  if (metrics_) metrics_->drawn(shown, receiver_, cost);
  if (window_) facts_.drawn(cost.frame_index + 1, cost.frame_ms, cost.cpu_ms, cost.pose_age_ms);
}

Result<void> FrameLoop::deliver() {
  // In lockstep the adapter waits for this image, so the GPU is awaited; otherwise delivery is asynchronous.
  if (options_.lockstep) image_service_.wait(image_service_.submitted());
  if (Result<void> delivered = captures_.deliver(sink_); !delivered) return delivered;
  image_service_.deliver();
  if (window_) window_->deliver();
  while (!unacknowledged_.empty() && image_service_.is_done(unacknowledged_.front().drawn)) {
    if (!first_finished_) first_finished_ = Clock::now();
    receiver_.acknowledge(unacknowledged_.front().shown);
    unacknowledged_.erase(unacknowledged_.begin());
  }
  for (gpu::FrameTimes& times : frames_.take_finished()) {
    if (metrics_) metrics_->add(times);
    if (window_) facts_.add(times);
    if (times.frame_index < uncounted_images_) continue;
    times.frame_index -= uncounted_images_;
    stats_.add(times);
  }
  return {};
}

// Writes the instance list: the meaning of the instance numbers in the images.
Result<void> FrameLoop::list_instances() {
  const bool labelled = taken_.has(wire::kInstanceU32) || options_.outputs.has(wire::kSemanticU32);
  if (!wants_pixels() || !labelled || instances_listed_ == scene_.replaced()) return {};
  instances_listed_ = scene_.replaced();
  const std::string text = capture::list_instances(scene_.scene());
  return write_whole_file(options_.out / "instances.jsonl",
                          {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

}  // namespace fire3dv::app
