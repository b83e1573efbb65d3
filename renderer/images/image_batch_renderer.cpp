#include "renderer/images/image_batch_renderer.h"
#include "renderer/passes/outputs/planes_and_boxes.h"
#include "renderer/passes/path/path_pass.h"
#include "renderer/passes/resources/gpu_scene.h"

#include <algorithm>

namespace fire3dv::app {
namespace {

// Memory limit of cameras in one submission: visibility flags and cluster lists.
constexpr uint64_t kMaxBatchViewBytes = uint64_t{64} << 20;
constexpr auto kTraceTime = std::chrono::milliseconds(10);  // of paths between two looks at the links
// A viewer's image is sent after this time at the earliest, and with its next sample after the later times.
constexpr auto kMinViewTime = std::chrono::milliseconds(20);
constexpr auto kMaxViewTime = std::chrono::milliseconds(1000),
               kSharedViewTime = std::chrono::milliseconds(100);

passes::ImageOutputs drawn_outputs(const wire::ImageRequest& request) {
  return passes::with_sources(wire::ImageOutputs(request.outputs));
}

bool has_lens(const ImageCamera& camera) {
  return camera.lens.model != passes::LensModel::none;
}

// True if the next image of the request is compared with this one.
bool has_history(const wire::ImageRequest& request) {
  return wire::ImageOutputs(request.outputs).needs_last_image() && !state::is_of_one_image(request);
}

// Exact read-back size of `views` views of the request.
uint64_t read_back_bytes(const wire::ImageRequest& request, uint32_t views) {
  const passes::ImageOutputs outputs = drawn_outputs(request);
  const uint32_t width = request.intrinsics.width, height = request.intrinsics.height * views;
  return (outputs.has(wire::kColorSrgb8) ? uint64_t{4} * width * height : 0) +
         passes::bytes_of(passes::lay_out_planes(outputs, width, height));
}

// Outputs that the renderer draws for the request, before lens distortion.
passes::ImageOutputs outputs_behind(const ImageBatchRenderer::WorkItem& work) {
  const passes::ImageOutputs outputs = drawn_outputs(work.due.request);
  return has_lens(work.camera) ? passes::pinhole_outputs(outputs) : outputs;
}

// Runs an allocation; returns false if the device is out of memory. Rethrows other errors.
template <typename Take>
bool has_room_for(Take&& take) {
  try {
    take();
    return true;
  } catch (const gpu::VulkanFailure& failure) {
    if (!gpu::is_out_of_memory(failure)) throw;
    return false;
  }
}

// Tangent of half the vertical field of view.
float half_height(const passes::Intrinsics& camera) {
  return static_cast<float>(camera.image_px.y) / (2 * camera.fy_px);
}

passes::ReplacedMemory replaced_memory(
    const std::map<ImageBatchRenderer::Key, passes::CameraHistory>& histories,
    std::span<const ImageBatchRenderer::WorkItem> batch) {
  std::vector<const passes::CameraHistory*> known;
  for (const ImageBatchRenderer::WorkItem& work : batch) {
    const auto history = histories.find({work.due.requester, work.due.request.id});
    if (history != histories.end()) known.push_back(&history->second);
  }
  return passes::replaced_by(known, batch[0].camera.pinhole.image_px);
}

VkExtent2D extent_of(glm::uvec2 size) {
  return {size.x, size.y};
}

}  // namespace

// Render targets take about 20 times the bytes of the image at 4 samples.
state::ImageAbilities image_abilities(const passes::SceneRenderer& renderer, bool traces_requests) {
  state::ImageAbilities abilities{.max_pixel_bytes = uint64_t{64} << 20};
  abilities.lenses = true;
  abilities.thin_lenses = renderer.traces_paths() || renderer.can_blur().ok();
  if (renderer.traces_paths()) abilities.path_samples = renderer.path_tracer()->settings().samples_per_pixel;
  abilities.outputs = 0;
  for (uint32_t bit = 0; bit < wire::kImageOutputCount; ++bit) {
    if ((wire::kRequestableOutputs >> bit & 1) == 0) continue;
    if (renderer.traces_paths() && !traces_requests && wire::ImageOutputs(1u << bit).shaded()) continue;
    if (renderer.can_take(passes::with_sources(wire::ImageOutputs(1u << bit))))
      abilities.outputs |= 1u << bit;
  }
  return abilities;
}

void ImageBatchRenderer::begin(std::vector<WorkItem>&& work) {
  work_ = std::move(work);
  next_ = 0;
}

uint64_t ImageBatchRenderer::cost_of(const WorkItem& work) const {
  const bool is_traced = renderer_.traces_paths() && outputs_behind(work).shaded();
  const uint32_t samples = is_traced ? renderer_.path_tracer()->settings().samples_per_pixel : 0;
  state::ImageEffort effort = state::effort_of(work.due.request, samples);
  effort.is_blurred = is_blurred(work);
  effort.has_markers = work.camera.markers;
  const glm::uvec2 size = work.camera.pinhole.image_px;
  return state::image_cost(size.x, size.y, effort);
}

bool ImageBatchRenderer::is_blurred(const WorkItem& work) const {
  return !renderer_.traces_paths() && !used_lens(work).is_pinhole();
}

uint64_t ImageBatchRenderer::lens_bytes(const WorkItem& work) const {
  if (!is_blurred(work)) return 0;
  constexpr uint64_t kBytesOfSample = 8 + 4 + 8;  // colour, depth, visibility; see Targets
  const glm::uvec2 size = work.camera.pinhole.image_px;
  return uint64_t{size.x} * size.y * static_cast<uint32_t>(renderer_.settings().samples()) * kBytesOfSample;
}

bool ImageBatchRenderer::draw(gpu::FrameRing& frames, const Moment& moment, const Limits& limits) {
  limits_ = &frames.limits();
  gpu::Recorder* recorder = nullptr;
  uint64_t bytes = 0, cost = 0;
  while (has_work() && bytes < limits.bytes) {
    if (cost > 0 && cost + next_cost() > limits.cost) break;
    const std::span<const WorkItem> rest = std::span(work_).subspan(next_);
    const std::span<const WorkItem> batch =
        rest.first(batch_size(rest, {limits.bytes - bytes, limits.cost - std::min(cost, limits.cost)}));
    if (renderer_.traces_paths() && outputs_behind(batch[0]).shaded()) {
      if (recorder) break;  // in a submission of its own
      ++next_;
      tracing_.emplace(Tracing{batch[0], moment.boxes, std::chrono::steady_clock::now()});
      cost_ = {cost_.cost + cost_of(batch[0]), cost_.images + 1};
      trace(frames, moment.poses);
      return true;
    }
    // Beside other requesters in a submission of its own, which may reach a time limit.
    const bool is_alone = is_blurred(batch[0]) && limits.cost != std::numeric_limits<uint64_t>::max();
    if (recorder && is_alone) break;
    next_ += batch.size();
    const std::optional<passes::PreparedFrame> prepared = prepare(batch, scene_update_);
    if (!prepared) continue;
    if (!recorder) recorder = &frames.begin();
    record(*prepared, *recorder, frames.staging(), batch, moment);
    scene_update_ = passes::SceneUpdate::reuse;
    bytes += read_back_bytes(batch[0].due.request, static_cast<uint32_t>(batch.size()));
    const uint64_t batch_cost = batch.size() * cost_of(batch[0]);
    cost += batch_cost;
    cost_ = {cost_.cost + batch_cost, cost_.images + batch.size()};
    if (is_alone) break;
  }
  if (recorder) readback_.submitted(frames.submit());
  return recorder != nullptr;
}

// Twice the samples halve the variance, so that a refining image is sent some 10 times, and then now and
// then.
bool ImageBatchRenderer::is_traced(bool others_wait) const {
  const settings::PathProgress progress = renderer_.path_tracer()->progress();
  if (progress.is_whole()) return true;
  const std::optional<uint32_t>& shown = tracing_->work.camera.shown_samples;
  if (!shown || progress.samples <= *shown) return false;
  const auto elapsed = std::chrono::steady_clock::now() - tracing_->begun;
  if (progress.samples >= 2 * *shown) return elapsed >= kMinViewTime;
  return elapsed >= (others_wait ? kSharedViewTime : kMaxViewTime);
}

void ImageBatchRenderer::trace(gpu::FrameRing& frames, const state::PoseState& poses, bool others_wait) {
  const std::span<const WorkItem> image(&tracing_->work, 1);
  // A view that refines keeps its samples while others take their turns; those of a moving one are of no use.
  std::optional<uint32_t>& shown = tracing_->work.camera.shown_samples;
  renderer_.path_tracer()->select(tracing_->work.camera.keeps_samples ? image[0].due.requester : 0);
  const std::optional<passes::PreparedFrame> prepared = prepare(image, tracing_->scene, true);
  if (!prepared) return cancel_tracing();
  (void)renderer_.trace_paths(*prepared, poses, view_of(image[0]), {.budget = kTraceTime});
  tracing_->scene = passes::SceneUpdate::reuse;
  const uint32_t samples = renderer_.path_tracer()->progress().samples;
  traced_samples_ = {image[0].due.requester, image[0].due.request.id, samples};
  if (shown && samples < *shown) shown = 0;  // it has started again
  if (!is_traced(others_wait)) return;
  gpu::Recorder& recorder = frames.begin();
  record(*prepared, recorder, frames.staging(), image, {poses, tracing_->boxes});
  readback_.submitted(frames.submit());
  tracing_.reset();
}

void ImageBatchRenderer::cancel_tracing() {
  tracing_.reset();
  // A first sample that is not whole would be made whole with the scene of a later image.
  if (passes::PathPass* const paths = renderer_.path_tracer(); paths && paths->progress().samples == 0)
    paths->drop_selected();
}

scene::ThinLens ImageBatchRenderer::used_lens(const WorkItem& work) const {
  if (!drawn_outputs(work.due.request).shaded()) return {};
  if (!renderer_.traces_paths() && !renderer_.can_blur()) return {};
  const scene::ThinLens& settings = renderer_.settings().lens();
  const scene::ThinLens& own = work.camera.thin_lens;
  return own.of_stream || settings.is_pinhole() ? own : settings;
}

passes::View ImageBatchRenderer::view_of(const WorkItem& work) const {
  const ImageCamera& camera = work.camera;
  passes::View view = pinhole_view(camera);
  view.camera = work.due.request.node;
  view.exposure = camera.exposure;
  view.ground = camera.ground;
  view.lens = used_lens(work);
  view.lens.of_stream = true;  // the settings' lens has been considered
  // The image behind a distortion is wider, and its focal length shorter; the aperture stays.
  if (has_lens(camera)) view.lens.f_number *= half_height(camera.intrinsics) / half_height(camera.pinhole);
  return view;
}

// Number of consecutive compatible images that fit one submission.
size_t ImageBatchRenderer::batch_size(std::span<const WorkItem> rest, const Limits& limits) const {
  const wire::ImageRequest& first = rest[0].due.request;
  const passes::ImageOutputs outputs = drawn_outputs(first);
  if (has_lens(rest[0].camera) || rest[0].camera.markers || !used_lens(rest[0]).is_pinhole() ||
      !renderer_.can_take(outputs, 2))
    return 1;
  const uint64_t pixel_bytes = uint64_t{8} * static_cast<uint32_t>(renderer_.settings().samples()) *
                               first.intrinsics.width * first.intrinsics.height;
  const uint64_t list_bytes = sizeof(uint32_t) * uint64_t{renderer_.gpu_scene().cluster_instance_count};
  const uint64_t most = std::min<uint64_t>({kMaxBatchViewBytes / std::max(pixel_bytes, list_bytes),
                                            limits.bytes / std::max<uint64_t>(read_back_bytes(first, 1), 1),
                                            limits.cost / cost_of(rest[0]),
                                            device_.limits().maxImageDimension2D / first.intrinsics.height,
                                            device_.limits().maxImageArrayLayers, rest.size()});
  size_t count = 1;
  while (count < most) {
    const wire::ImageRequest& next = rest[count].due.request;
    if (next.intrinsics.width != first.intrinsics.width ||
        next.intrinsics.height != first.intrinsics.height || next.outputs != first.outputs ||
        has_history(next) != has_history(first) || has_lens(rest[count].camera) ||
        rest[count].camera.markers || !used_lens(rest[count]).is_pinhole())
      break;
    ++count;
  }
  return count;
}

void ImageBatchRenderer::refuse(std::span<const WorkItem> batch, wire::ImageRefusal reason,
                                const std::string& why) {
  for (const WorkItem& work : batch) refused_.push_back({work.due, reason, why});
}

void ImageBatchRenderer::refuse_rest(const std::string& why) {
  refuse(std::span(work_).subspan(next_), wire::ImageRefusal::too_large, why);
  next_ = work_.size();
}

// Allocates the images' resources. A shortage refuses the images and is no error.
std::optional<passes::PreparedFrame> ImageBatchRenderer::prepare(std::span<const WorkItem> batch,
                                                                 passes::SceneUpdate scene, bool refines) {
  const WorkItem& first = batch[0];
  const wire::ImageRequest& request = first.due.request;
  const VkExtent2D extent = extent_of(first.camera.pinhole.image_px);
  const auto views = static_cast<uint32_t>(batch.size());
  passes::Shortage shortage{};
  const Result<passes::PreparedFrame> prepared =
      renderer_.prepare({.extent = extent,
                         .views = views,
                         .outputs = outputs_behind(first),
                         .scene = scene,
                         .markers = first.camera.markers,
                         .has_history = has_history(request),
                         .replaced = replaced_memory(histories_, batch),
                         .lens = !used_lens(first).is_pinhole(),
                         .distorts = has_lens(first.camera),
                         .in_motion = first.camera.in_motion,
                         .refines = refines},
                        &shortage);
  if (!prepared) {
    refuse(batch,
           shortage == passes::Shortage::motion_snapshots ? wire::ImageRefusal::too_many
                                                          : wire::ImageRefusal::too_large,
           prepared.error().message);
    return std::nullopt;
  }
  const bool has_room = has_room_for([&] {
    if (has_lens(first.camera))
      lens_.make_room(first.camera.pinhole, distortion_of(first.camera, drawn_outputs(request)));
    readback_.make_room(read_back_bytes(request, views));
  });
  if (has_room) return *prepared;
  refuse(batch, wire::ImageRefusal::too_large,
         "the device has no memory for an image of " + std::to_string(extent.width) + " x " +
             std::to_string(extent.height) + "; ask for a smaller one");
  return std::nullopt;
}

void ImageBatchRenderer::record(const passes::PreparedFrame& prepared, gpu::Recorder& recorder,
                                gpu::StagingRing& staging, std::span<const WorkItem> batch,
                                const Moment& moment) {
  const wire::ImageRequest& first = batch[0].due.request;
  const passes::ImageOutputs outputs = drawn_outputs(first);
  Tag tag;
  std::vector<passes::View> views;
  const auto hidden_streams = static_cast<uint32_t>(moment.poses.hidden_streams().size());
  for (const WorkItem& work : batch) {
    const state::ImageRequestRegistry::Due& due = work.due;
    const passes::Intrinsics& used = work.camera.intrinsics;
    const scene::ThinLens lens = used_lens(work);
    views.push_back(view_of(work));
    wire::ImageFrame frame;
    frame.request = due.request.id;
    frame.number = due.number;
    frame.epoch = due.request.epoch;
    frame.sequence = due.sequence;
    frame.sim_time_ns = due.sim_time_ns;
    frame.world_from_camera = affine_of(work.camera.world_from_camera);
    frame.intrinsics = {used.image_px.x, used.image_px.y,      used.fx_px,
                        used.fy_px,      used.cx_px,           used.cy_px,
                        used.near_m,     used.far_m,           due.request.intrinsics.lens,
                        lens.f_number,   lens.focus_distance_m};
    frame.hidden_streams = hidden_streams;
    tag.images.push_back({due, std::move(frame)});
  }
  std::vector<passes::CameraHistory> histories = take_histories(batch);
  renderer_.record(prepared, recorder, staging, moment.poses, views, histories);
  store_histories(batch, std::move(histories));

  tag.taken.width = first.intrinsics.width;
  tag.taken.height = first.intrinsics.height;
  tag.taken.views = static_cast<uint32_t>(batch.size());
  tag.taken.color_srgb8 = outputs.has(wire::kColorSrgb8);
  if (wants_boxes(first)) tag.taken.boxes = moment.boxes;
  if (has_lens(batch[0].camera)) {
    read_back_through_lens(recorder, staging, batch[0].camera, {outputs, views[0], moment.poses},
                           std::move(tag));
  } else {
    read_back(recorder, outputs, std::move(tag));
  }
}

void ImageBatchRenderer::read_back(gpu::Recorder& recorder, const passes::ImageOutputs& outputs, Tag&& tag) {
  gpu::ReadbackRing<Tag>::Planes planes;
  if (outputs.has_planes()) {
    tag.taken.ranges = renderer_.plane_ranges();
    planes = {&renderer_.planes(), passes::bytes_of(tag.taken.ranges)};
  }
  gpu::Image* const image = outputs.has(wire::kColorSrgb8) ? &renderer_.image() : nullptr;
  readback_.record(recorder, image, renderer_.image().extent, planes, std::move(tag));
}

passes::LensPass::Wanted ImageBatchRenderer::distortion_of(const ImageCamera& camera,
                                                           const passes::ImageOutputs& outputs) const {
  const settings::OpticsSettings& optics = renderer_.settings().draw().post.optics;
  return {camera.intrinsics, camera.lens, outputs, optics.mask_radius, optics.mask_cut, optics.any()};
}

void ImageBatchRenderer::read_back_through_lens(gpu::Recorder& recorder, gpu::StagingRing& staging,
                                                const ImageCamera& camera, const Distorted& image,
                                                Tag&& tag) {
  const passes::ImageOutputs& outputs = image.outputs;
  passes::LensPass::Source source{camera.pinhole, nullptr, nullptr, {}};
  const bool has_color = outputs.has(wire::kColorSrgb8);
  if (has_color) source.light = renderer_.undeveloped_light();
  if (has_color && !source.light) source.color = &renderer_.image();
  if (outputs.has_planes()) {
    source.planes = &renderer_.planes();
    source.places = renderer_.plane_ranges();
  }
  lens_.record(recorder, staging, source, distortion_of(camera, outputs));
  tag.taken.ranges = lens_.places();
  const VkExtent2D extent = extent_of(camera.intrinsics.image_px);
  gpu::Image* const developed =
      source.light ? &renderer_.develop(recorder, staging, lens_.light(), extent, image.view, image.poses)
                   : nullptr;
  gpu::ReadbackRing<Tag>::Planes planes;
  if (lens_.result_bytes() > 0) planes = {&lens_.result(), lens_.result_bytes()};
  readback_.record(recorder, developed, extent, planes, std::move(tag));
}

std::vector<passes::CameraHistory> ImageBatchRenderer::take_histories(std::span<const WorkItem> batch) {
  std::vector<passes::CameraHistory> histories;
  if (!has_history(batch[0].due.request)) return histories;
  for (const WorkItem& work : batch)
    histories.push_back(std::move(histories_[{work.due.requester, work.due.request.id}]));
  return histories;
}

void ImageBatchRenderer::store_histories(std::span<const WorkItem> batch,
                                         std::vector<passes::CameraHistory>&& histories) {
  for (size_t i = 0; i < histories.size(); ++i)
    histories_[{batch[i].due.requester, batch[i].due.request.id}] = std::move(histories[i]);
}

void ImageBatchRenderer::deliver(const Take& take) {
  readback_.poll([&](Tag tag, VkExtent2D, std::span<const uint8_t> bytes) {
    const bool ended_early = limits_ && limits_->has_ended_early(readback_.polled_submission());
    for (uint32_t view = 0; view < tag.images.size(); ++view) {
      Image& image = tag.images[view];
      const state::ImageRequestRegistry::Due& due = image.due;
      if (ended_early) {
        histories_.erase({due.requester, due.request.id});
        ended_early_.push_back(due);
        continue;
      }
      const RequestedImage pixels(tag.taken, view, wire::ImageOutputs(due.request.outputs), bytes);
      pixels.describe_to(image.frame);
      take(due.requester, image.frame, pixels);
    }
  });
}

void ImageBatchRenderer::retain_only(std::span<const Key> open) {
  std::erase_if(histories_,
                [&](const auto& entry) { return !std::ranges::binary_search(open, entry.first); });
}

}  // namespace fire3dv::app
