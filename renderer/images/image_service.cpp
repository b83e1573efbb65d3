#include "renderer/images/image_service.h"

#include <algorithm>
#include <exception>
#include <iterator>

#include "base/clock.h"
#include "base/text.h"
#include "renderer/gpu/device/pipeline_count.h"

namespace fire3dv::app {
namespace {

// The pinhole image before lens distortion is larger than the requested one.
constexpr uint64_t kMaxBytesBehindLens = uint64_t{256} << 20;
// Limit of an image with depth of field beside other peers: wide circles of confusion take minutes on a CPU.
constexpr int64_t kMaxBlurredNs = 1'000'000'000;
constexpr size_t kMaxLimited = 16;  // images; far more than are in flight
// Limit of a submission while several streams request images, so that turns can end in time.
constexpr uint64_t kSharedSubmittedBytes = uint64_t{8} << 20;

uint64_t pixels_of(const passes::Intrinsics& drawn) {
  return uint64_t{drawn.image_px.x} * drawn.image_px.y;
}

std::optional<CameraRefused> check_pinhole_size(const wire::ImageRequest& request,
                                                const ImageCamera& camera) {
  if (camera.lens.model == passes::LensModel::none) return {};
  const uint32_t outputs = passes::pinhole_outputs(wire::ImageOutputs(request.outputs)).bits();
  const glm::uvec2 size = camera.pinhole.image_px;
  const uint64_t bytes = wire::pixel_bytes_of(size.x, size.y, outputs, 0);
  if (bytes <= kMaxBytesBehindLens) return {};
  return CameraRefused{wire::ImageRefusal::too_large,
                       "what stands behind the lens has " + std::to_string(size.x) + " x " +
                           std::to_string(size.y) + " pixels and " + std::to_string(bytes) +
                           " bytes; at most " + std::to_string(kMaxBytesBehindLens) +
                           " are made: ask for a smaller image, or for fewer outputs"};
}

PeerDrawTime::View view_of(const ImageBatchRenderer::WorkItem& work) {
  const passes::Intrinsics& drawn = work.camera.pinhole;
  PeerDrawTime::View view;
  view.kind = 1 + 31 * (work.due.requester + 31 * (drawn.image_px.x + uint64_t{31} * drawn.image_px.y));
  view.pixels = pixels_of(drawn);
  view.requester_epoch = work.due.request.epoch;
  view.view = {pinhole_view(work.camera).clip_from_world, glm::vec2(drawn.image_px)};
  view.markers = work.camera.markers;
  return view;
}

}  // namespace

std::span<const std::unique_ptr<SecondaryDevice>> ImageService::secondary() const {
  return secondary_ ? secondary_->all() : std::span<const std::unique_ptr<SecondaryDevice>>();
}

const gpu::Device& ImageService::device_at(size_t index) const {
  return index == 0 ? device_ : secondary()[index - 1]->device();
}

ImageBatchRenderer& ImageService::renderer_at(size_t index) {
  return index == 0 ? first_ : secondary()[index - 1]->batch_renderer();
}

ImageService::Drawn ImageService::draw_due(gpu::FrameRing& frames) {
  record_finished();
  if (first_.is_tracing()) return go_on_tracing(frames);
  const int64_t begin_ns = monotonic_ns(), end_ns = begin_ns + rules_.slice_ns;
  std::vector<state::ImageDemand> demands = requests_.demands(begin_ns);
  scheduler_.note_demands(demands, begin_ns);
  if (const uint64_t closed = requests_.closed(); closed != closed_seen_) {
    closed_seen_ = closed;
    drop_closed_requests();
    end_withdrawn(frames);
    if (const auto* drawn = batches_.drawn(); drawn && !requests_.is_open(*drawn)) batches_.cancel();
  }
  if (const auto owner = batches_.owner(); owner && !requests_.has(*owner)) batches_.release();
  // Poses are constant during this call: all turns render the same poses.
  ImageBatchRenderer::Moment moment{poses_, nullptr};
  for (size_t device = 0; device < device_count(); ++device) renderer_at(device).begin_moment();
  Drawn drawn;
  while (!demands.empty() && !first_.is_tracing() && !rules_.is_stop_requested()) {
    if (drawn.any && monotonic_ns() >= end_ns) break;
    if (!has_room(end_ns)) break;
    const std::optional<state::RequesterId> requester = scheduler_.next(demands, monotonic_ns());
    if (!requester) break;
    drawn.any = true;
    if (!draw_turn(frames, *requester, moment, end_ns)) break;
    std::erase_if(demands, [&](const state::ImageDemand& demand) { return demand.requester == *requester; });
  }
  drawn.has_more = !demands.empty() || first_.is_tracing();
  return drawn;
}

// True if a viewer's image should end early. A simulator's one is traced to its end.
bool ImageService::do_others_wait(const state::ImageRequestRegistry::Due& traced, int64_t now_ns) {
  if (!requests_.appearance(traced.requester).shown_samples) return false;
  const uint64_t own = requests_.cost(traced.request);
  return std::ranges::any_of(requests_.demands(now_ns), [&](const state::ImageDemand& demand) {
    return demand.requester != traced.requester || demand.cost > own;
  });
}

void ImageService::report_samples() {
  if (const auto traced = first_.take_traced_samples())
    requests_.set_samples(traced->requester, traced->request, traced->samples);
}

// Other due images wait: they are counted by the next call.
ImageService::Drawn ImageService::go_on_tracing(gpu::FrameRing& frames) {
  const state::ImageRequestRegistry::Due due = first_.traced();
  if (!requests_.is_open(due)) {
    first_.cancel_tracing();
    return {.any = true, .has_more = true};
  }
  const int64_t begin_ns = monotonic_ns();
  first_.trace(frames, poses_, do_others_wait(due, begin_ns));
  if (!takes_new_pipelines()) scheduler_.spent(due.requester, begin_ns, monotonic_ns());
  report_samples();
  if (!first_.is_tracing()) requests_.mark_rendered(due);
  forward_refusals(first_);
  return {.any = true, .has_more = true};
}

// Returns false if the time slice ended before.
bool ImageService::draw_batches(gpu::FrameRing& frames,
                                const std::vector<state::ImageRequestRegistry::Due>& due, int64_t end_ns) {
  // One batch at a time, also if it is of another requester: that one pays.
  bool is_first = batches_.drawn() == nullptr;
  if (!go_on_with_batch(frames, end_ns)) return false;
  for (const state::ImageRequestRegistry::Due& one : due) {
    if (!requests_.is_open(one)) continue;  // it was the one that went on
    if (!is_first && (monotonic_ns() >= end_ns || rules_.is_stop_requested())) return false;
    is_first = false;
    begin_batch(one);
    if (!go_on_with_batch(frames, end_ns)) return false;
  }
  return true;
}

void ImageService::begin_batch(const state::ImageRequestRegistry::Due& due) {
  const std::optional<wire::StreamDescription> stream = requests_.description(due.requester);
  if (!stream) return;
  const int64_t begun_ns = monotonic_ns();
  const std::optional<CameraRefused> refused =
      batches_.begin(due, {.stream = *stream,
                           .scene = scene_,
                           .displayed = renderer_,
                           .settings = renderer_.settings().draw(),
                           .budget = requests_.budget(due),
                           .hidden_streams = static_cast<uint32_t>(poses_.hidden_streams().size())});
  if (refused) {
    scheduler_.spent(due.requester, begun_ns, monotonic_ns());
    requests_.refuse(due, refused->reason, refused->why);
  } else if (!batches_.drawn()) {
    requests_.mark_rendered(due);  // it has no active world
  }
}

// Submits the rest of a batch, as far as the time slice goes: images of others come between two submissions.
// Returns false if there is more.
bool ImageService::go_on_with_batch(gpu::FrameRing& frames, int64_t end_ns) {
  for (bool is_first = true; batches_.drawn(); is_first = false) {
    if (!is_first && (monotonic_ns() >= end_ns || rules_.is_stop_requested() || !has_room(end_ns)))
      return false;
    const state::ImageRequestRegistry::Due due = *batches_.drawn();
    const bool is_open = requests_.is_open(due);
    if (!is_open || !batches_.shows(scene_)) {
      batches_.cancel();
      if (is_open) begin_batch(due);
      continue;
    }
    deliver();
    const int64_t begun_ns = monotonic_ns();
    const WorldBatches::Submitted done = batches_.go_on(frames);
    if (done.views > 0) {
      const uint64_t cost = requests_.cost(due.request) * done.views / due.request.views();
      scheduler_.submitted(due.requester, cost, done.views, monotonic_ns());
      submissions_.emplace_back(submitted(), begun_ns, takes_new_pipelines());
    }
    if (done.refused)
      requests_.refuse(due, done.refused->reason, done.refused->why);
    else if (!batches_.drawn())
      requests_.mark_rendered(due);
  }
  return true;
}

// Returns false if the time slice ended before all due images of the stream were rendered.
bool ImageService::draw_turn(gpu::FrameRing& frames, state::RequesterId requester,
                             ImageBatchRenderer::Moment& moment, int64_t end_ns) {
  const int64_t now_ns = monotonic_ns();
  std::vector<state::ImageRequestRegistry::Due> due = requests_.due(requester, now_ns), batches;
  const auto is_single = [](const state::ImageRequestRegistry::Due& one) { return !one.request.batch; };
  const auto first_batch = std::stable_partition(due.begin(), due.end(), is_single);
  std::move(first_batch, due.end(), std::back_inserter(batches));
  due.erase(first_batch, due.end());
  std::vector<ImageBatchRenderer::WorkItem> work = resolve(std::move(due));
  const auto needs_boxes = [](const ImageBatchRenderer::WorkItem& a) { return wants_boxes(a.due.request); };
  if (!moment.boxes && std::ranges::any_of(work, needs_boxes))
    moment.boxes = std::make_shared<const std::vector<wire::BoxRecord3d>>(
        passes::boxes_of_instances(scene_.scene(), poses_));
  std::optional<PeerDrawTime::View> view;  // of the first image: the others are alike
  if (draw_time_ && draw_time_->is_active() && !work.empty()) view = view_of(work[0]);
  if (view && draw_time_->begin_image(*view) && view->markers) scene_.show_markers();
  if (view) refuse_incomplete(work);
  distribute(std::move(work));
  const uint64_t max_bytes =
      scheduler_.is_alone(requester, now_ns) ? ImageBatchRenderer::kMaxSubmittedBytes : kSharedSubmittedBytes;
  int64_t begun_ns = now_ns;
  for (bool is_first = true; has_work() && !first_.is_tracing(); is_first = false) {
    if (!is_first && (monotonic_ns() >= end_ns || rules_.is_stop_requested() || !has_room(end_ns))) break;
    const uint64_t next_cost = largest_next_cost();
    const int64_t left_ns = is_first ? rules_.slice_ns : end_ns - begun_ns;
    const uint64_t max_cost = scheduler_.max_cost(requester, next_cost, left_ns, begun_ns);
    // A long image begins a turn of its own, for which others have their quiet time.
    if (!is_first && next_cost > max_cost) break;
    const Mark before = submitted();
    if (view && draw_time_->begin_image(*view) && view->markers) scene_.show_markers();
    limit(frames, view.has_value());
    const size_t processed_before = first_.processed().size();
    draw_round(frames, moment, {max_bytes, max_cost});
    scene_.vertex_pacing().frame_recorded(frames.frame_index());
    report_samples();
    ImageBatchRenderer::Cost cost;  // devices draw side by side
    for (size_t device = 0; device < device_count(); ++device) {
      const ImageBatchRenderer::Cost each = renderer_at(device).take_cost();
      if (each.cost > cost.cost) cost = each;
    }
    if (Mark mark = submitted(); mark != before) {
      if (view && mark[0] != before[0])
        draw_time_->submitted(frames.frame_index(),
                              static_cast<double>(cost.cost) / static_cast<double>(next_cost));
      const int64_t submitted_ns = monotonic_ns();
      scheduler_.submitted(requester, cost.cost, cost.images, submitted_ns);
      Submission& submission = submissions_.emplace_back(std::move(mark), begun_ns, takes_new_pipelines());
      for (const auto& item : first_.processed().subspan(processed_before))
        submission.images.push_back(item.due);
      begun_ns = submitted_ns;
    }
  }
  bool is_whole = !has_work();
  for (size_t device = 0; device < device_count(); ++device) {
    ImageBatchRenderer& batch_renderer = renderer_at(device);
    std::span<const ImageBatchRenderer::WorkItem> processed = batch_renderer.processed();
    // A traced image is the last one. Its request stays open until it is whole, so that it can be withdrawn.
    if (batch_renderer.is_tracing()) processed = processed.first(processed.size() - 1);
    for (const ImageBatchRenderer::WorkItem& one : processed) requests_.mark_rendered(one.due);
    batch_renderer.begin({});
  }
  if (is_whole && !first_.is_tracing() && !batches.empty()) is_whole = draw_batches(frames, batches, end_ns);
  return is_whole;
}

// The limits of the next submission of the first device.
void ImageService::limit(gpu::FrameRing& frames, bool has_view) {
  using Cause = gpu::SubmissionLimits::Cause;
  const bool is_shared = draw_time_ && draw_time_->limits() && !rules_.lockstep;
  // The lens of the settings is the user's own.
  const auto has_own_lens = [](const ImageBatchRenderer::WorkItem& work) {
    return work.camera.thin_lens.of_stream;
  };
  if (is_shared && first_.has_work() && has_own_lens(first_.next()) && first_.is_blurred(first_.next())) {
    if (limited_.size() >= kMaxLimited) limited_.erase(limited_.begin());  // refused for lack of memory
    limited_.emplace_back(first_.next().due.requester, first_.next().due.request.id);
    frames.limits().set(kMaxBlurredNs, Cause::image);
  } else {
    frames.limits().set(has_view ? draw_time_->abandon_after_ns() : std::nullopt, Cause::content);
  }
}

void ImageService::end_withdrawn(gpu::FrameRing& frames) {
  for (const Submission& submission : submissions_) {
    const bool is_wanted = std::ranges::any_of(submission.images, [&](const auto& due) {
      return state::is_of_one_image(due.request) ? requests_.has(due.requester) : requests_.is_open(due);
    });
    if (!submission.images.empty() && !is_wanted) frames.end_early(submission.mark[0]);
  }
}

// An image that was not drawn to its end.
void ImageService::redraw_or_refuse(const state::ImageRequestRegistry::Due& due) {
  if (std::erase(limited_, Key(due.requester, due.request.id)) == 0) return requests_.mark_undrawn(due);
  const wire::Intrinsics& size = due.request.intrinsics;
  requests_.mark_undrawn(due);
  requests_.refuse(
      due, wire::ImageRefusal::too_large,
      "an image of " + std::to_string(size.width) + " x " + std::to_string(size.height) +
          " with depth of field was given up after " + std::to_string(kMaxBlurredNs / 1'000'000) +
          " ms, since other simulators wait; ask for a smaller image, a larger f-number, or none "
          "(the renderer's option --peer-limit draw-time=off draws it)");
}

uint64_t ImageService::largest_next_cost() {
  uint64_t cost = 0;
  for (size_t device = 0; device < device_count(); ++device) {
    if (renderer_at(device).has_work()) cost = std::max(cost, renderer_at(device).next_cost());
  }
  return cost;
}

// Refuses requests of complete images while content of a stream is hidden.
void ImageService::refuse_incomplete(std::vector<ImageBatchRenderer::WorkItem>& work) {
  const std::vector<std::string> hidden = poses_.hidden_streams();
  if (hidden.empty()) return;
  std::erase_if(work, [&](const ImageBatchRenderer::WorkItem& item) {
    if (!item.due.request.complete) return false;
    requests_.refuse(
        item.due, wire::ImageRefusal::hidden,
        "a complete image is requested, but the content of stream " + quote(hidden[0]) +
            " is hidden, since it takes too much drawing time (the renderer's option --peer-limit "
            "draw-time=off shows it)");
    return true;
  });
}

bool ImageService::has_work() {
  for (size_t device = 0; device < device_count(); ++device) {
    if (renderer_at(device).has_work()) return true;
  }
  return false;
}

// Reports the time of finished submissions to the scheduler.
void ImageService::record_finished() {
  while (!submissions_.empty() && is_done(submissions_.front().mark)) {
    const Submission& submission = submissions_.front();
    const int64_t now_ns = monotonic_ns();
    scheduler_.finished(std::max(submission.begun_ns, last_done_ns_), now_ns, submission.compiles);
    last_done_ns_ = now_ns;
    submissions_.pop_front();
  }
}

// True if pipelines were used for the first time since the last call: their compilation takes part of the
// submission's time.
bool ImageService::takes_new_pipelines() {
  const uint64_t pipelines = gpu::pipelines_begun();
  return std::exchange(pipelines_, pipelines) != pipelines;
}

// Short submissions may overlap. A long submission, or one of unknown duration, is awaited, so that another
// stream's request waits for at most one of them.
bool ImageService::has_room(int64_t end_ns) {
  while (true) {
    record_finished();
    const int64_t now_ns = monotonic_ns();
    const std::optional<int64_t> remaining_ns = scheduler_.remaining_ns(now_ns);
    if (remaining_ns && *remaining_ns <= rules_.slice_ns / 2) return true;
    if (now_ns >= end_ns) return false;
    (void)wait_for(submissions_.front().mark, end_ns - now_ns);
  }
}

void ImageService::drop_closed_requests() {
  const std::vector<Key> open = requests_.open();
  for (size_t device = 0; device < device_count(); ++device) renderer_at(device).retain_only(open);
  std::erase_if(assignments_, [&](const auto& entry) {
    const auto& [key, assignment] = entry;
    if (std::ranges::binary_search(open, key)) return false;
    pixels_of_device_[assignment.device] -= assignment.pixels;
    return true;
  });
}

// Resolves cameras; refuses invalid requests.
std::vector<ImageBatchRenderer::WorkItem> ImageService::resolve(
    std::vector<state::ImageRequestRegistry::Due>&& due) {
  std::vector<ImageBatchRenderer::WorkItem> work;
  bool has_markers = false;
  for (state::ImageRequestRegistry::Due& one : due) {
    auto camera = resolve_camera(one.request, requests_.world_from_stream(one.requester), poses_, scene_);
    if (const auto* possible = std::get_if<ImageCamera>(&camera)) {
      if (auto too_large = check_pinhole_size(one.request, *possible)) camera = std::move(*too_large);
    }
    if (const auto* refused = std::get_if<CameraRefused>(&camera)) {
      requests_.refuse(one, refused->reason, refused->why);
    } else {
      auto& possible = std::get<ImageCamera>(camera);
      const ImageReplies::Appearance appearance = requests_.appearance(one.requester);
      possible.ground = appearance.ground;
      possible.markers =
          one.request.markers || (appearance.markers && one.request.outputs == wire::kColorSrgb8);
      has_markers |= possible.markers;
      if (possible.exposure == 0) possible.exposure = appearance.exposure;
      possible.shown_samples = appearance.shown_samples;
      possible.keeps_samples = appearance.keeps_samples;
      possible.in_motion = appearance.in_motion;
      if (possible.thin_lens.is_pinhole()) possible.thin_lens = appearance.lens;
      ImageBatchRenderer::WorkItem item{std::move(one), possible};
      const uint64_t lens_bytes = first_.lens_bytes(item);
      // One peer alone gets what the device has.
      const bool is_shared = draw_time_ && draw_time_->is_active();
      const Result<void> fits =
          lens_bytes > 0 && is_shared ? requests_.check_memory(item.due, lens_bytes) : Result<void>();
      if (fits)
        work.push_back(std::move(item));
      else
        requests_.refuse(
            item.due, wire::ImageRefusal::too_large,
            fits.error().message + "; ask for a smaller image, or for one without depth of field");
    }
  }
  if (has_markers) scene_.show_markers();
  return work;
}

// Assigns a request to the device with the fewest pixels of open requests; round robin among equals.
size_t ImageService::assign_device(const ImageBatchRenderer::WorkItem& work) {
  const size_t count = device_count();
  if (count == 1 || work.camera.markers) return 0;  // the first device has the markers
  pixels_of_device_.resize(count);
  const Key key{work.due.requester, work.due.request.id};
  if (const auto known = assignments_.find(key); known != assignments_.end()) return known->second.device;
  size_t best = (last_device_ + 1) % count;
  for (size_t turn = 2; turn <= count; ++turn) {
    const size_t device = (last_device_ + turn) % count;
    if (pixels_of_device_[device] < pixels_of_device_[best]) best = device;
  }
  const Assignment assignment{best, pixels_of(work.camera.pinhole)};
  pixels_of_device_[best] += assignment.pixels;
  assignments_.emplace(key, assignment);
  last_device_ = best;
  return best;
}

void ImageService::distribute(std::vector<ImageBatchRenderer::WorkItem>&& work) {
  std::vector<std::vector<ImageBatchRenderer::WorkItem>> work_of_device(device_count());
  for (ImageBatchRenderer::WorkItem& one : work) work_of_device[assign_device(one)].push_back(std::move(one));
  for (size_t device = 0; device < work_of_device.size(); ++device)
    renderer_at(device).begin(std::move(work_of_device[device]));
}

// One submission on each device with work. Finished images are sent first, so that the number of images in
// flight stays small.
void ImageService::draw_round(gpu::FrameRing& frames, const ImageBatchRenderer::Moment& moment,
                              const ImageBatchRenderer::Limits& limits) {
  deliver();
  std::vector<SecondaryDevice*> at_work;
  for (const std::unique_ptr<SecondaryDevice>& each : secondary()) {
    if (!each->batch_renderer().has_work()) continue;
    each->begin_drawing(scene_, *settings_, moment, limits);
    at_work.push_back(each.get());
  }
  std::exception_ptr failure;  // first error: all devices must be awaited
  const auto attempt = [&](auto&& action) {
    try {
      action();
    } catch (...) {
      failure = std::current_exception();
    }
  };
  attempt([&] { first_.draw(frames, moment, limits); });
  for (SecondaryDevice* each : at_work) {
    attempt([&] {
      if (Result<void> drawn = each->finish(); !drawn)
        each->batch_renderer().refuse_rest(drawn.error().message);
    });
  }
  if (failure) std::rethrow_exception(failure);
  for (size_t device = 0; device < device_count(); ++device) forward_refusals(renderer_at(device));
}

void ImageService::forward_refusals(ImageBatchRenderer& batch_renderer) {
  for (const ImageBatchRenderer::Refused& refused : batch_renderer.take_refused())
    requests_.refuse(refused.due, refused.reason, refused.why);
}

void ImageService::deliver() {
  const auto send = [&](state::RequesterId requester, const wire::ImageFrame& frame,
                        const RequestedImage& pixels) {
    const int64_t begin_ns = monotonic_ns();
    std::erase(limited_, Key(requester, frame.request));
    requests_.send(requester, frame, [&](std::span<std::byte> to) { pixels.copy_to(to); });
    scheduler_.spent(requester, begin_ns, monotonic_ns());
  };
  for (size_t device = 0; device < device_count(); ++device) {
    renderer_at(device).deliver(send);
    for (const state::ImageRequestRegistry::Due& due : renderer_at(device).take_ended_early())
      redraw_or_refuse(due);
  }
  batches_.deliver(
      [&](state::RequesterId requester, const wire::ImageFrame& frame, const WorldBatches::Fill& fill) {
        const int64_t begin_ns = monotonic_ns();
        if (!requests_.send(requester, frame, fill)) {
          // A batch has no later image, so that its publisher would wait in vain.
          state::ImageRequestRegistry::Due lost{.requester = requester, .sequence = frame.sequence};
          lost.request.epoch = frame.epoch;
          lost.request.id = frame.request;
          requests_.refuse(lost, wire::ImageRefusal::too_large,
                           "the images of the batch were not sent, since the peer reads too slowly for the "
                           "limit of waiting bytes (queued-bytes): request it again, or in parts");
        }
        scheduler_.spent(requester, begin_ns, monotonic_ns());
      });
}

bool ImageService::in_flight() const {
  return first_.in_flight() != 0 || batches_.in_flight() != 0 ||
         std::ranges::any_of(secondary(),
                             [](const auto& each) { return each->batch_renderer().in_flight() != 0; });
}

ImageService::Mark ImageService::submitted() const {
  Mark mark;
  for (size_t device = 0; device < device_count(); ++device)
    mark.push_back(device_at(device).last_submitted());
  return mark;
}

bool ImageService::is_done(const Mark& mark) const {
  for (size_t device = 0; device < mark.size(); ++device) {
    if (device_at(device).completed() < mark[device]) return false;
  }
  return true;
}

bool ImageService::wait_for(const Mark& mark, int64_t timeout_ns) const {
  const int64_t end_ns = monotonic_ns() + timeout_ns;
  for (size_t device = 0; device < mark.size(); ++device) {
    if (!device_at(device).wait_for(mark[device], end_ns - monotonic_ns())) return false;
  }
  return true;
}

void ImageService::wait(const Mark& mark) const {
  for (size_t device = 0; device < mark.size(); ++device) device_at(device).wait(mark[device]);
}

}  // namespace fire3dv::app
