#include "renderer/images/world_batches.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <new>
#include <utility>

#include "renderer/live_scene/gpu_bytes.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/passes/resources/sun_light.h"
#include "renderer/passes/texture_capacity.h"
#include "renderer/scene/clusters/clusters.h"

namespace fire3dv::app {
namespace {

using Refusal = wire::ImageRefusal;

// Limit of one submission: visibility flags and cluster lists of its views.
constexpr uint64_t kMaxSubmittedViewBytes = uint64_t{64} << 20;
constexpr size_t kMaxFreeBuffers = 2;
constexpr uint64_t kWorldsEpoch = 1;

// Estimates, from above. Host: bindings, names and poses of a PoseState. Device: transforms, facts and
// instances of nodes; poses and shadow maps of lights; all vertices and the copies of deformed nodes, where
// there are such nodes; poses of named nodes, staged and uploaded.
uint64_t host_bytes_of_world(const scene::Scene& scene, const WorldBatches::Due& due,
                             const wire::StreamDescription& stream) {
  uint64_t bytes = 4096 + uint64_t{512} * scene.nodes.size() + sizeof(float) * scene.morph_weights.size();
  // A name, its index, offset and pose.
  for (const uint32_t index : due.request.batch->node_indices) bytes += 200 + stream.node_names[index].size();
  return bytes;
}
uint64_t device_bytes_of_world(const WorldBatches::Due& due, const WorldBatches::Source& source) {
  const scene::Scene& scene = source.scene.loaded().scene;
  const scene::Derived& derived = source.scene.loaded().derived;
  const wire::Intrinsics& image = due.request.intrinsics;
  const uint64_t side = std::clamp(std::bit_ceil(std::max(image.width, image.height)), 64u, 512u);
  const uint64_t lights =
      passes::drawn_lights(scene, &source.scene.edits(), passes::added_lights(source.displayed.gpu_scene()))
          .size();
  uint64_t bytes = 256 + uint64_t{256} * scene.nodes.size() +
                   2 * sizeof(wire::Affine3x4) * due.request.batch->node_indices.size() +
                   lights * (128 + 4 * side * side * 3 / 2);
  bool has_deformed = false;
  for (uint32_t node = 0; node < scene.nodes.size(); ++node) {
    if (!scene::is_deformed(scene.nodes[node])) continue;
    has_deformed = true;
    bytes += estimate_deformed_bytes(scene, derived, node);
  }
  if (has_deformed) {
    bytes += derived.clusters.source_vertices.size() *
                 (sizeof(glm::vec3) + sizeof(scene::TangentFrame) + sizeof(scene::TangentXy)) +
             derived.clusters.primitives.size() * uint64_t{256} + sizeof(float) * scene.morph_weights.size();
  }
  return bytes;
}

// Charges for `worlds`, at least; the error names the number that fits.
std::optional<CameraRefused> charge_worlds(BudgetCharge& charge, const std::shared_ptr<PeerBudget>& budget,
                                           Resource resource, uint32_t worlds, uint64_t bytes_of_world) {
  const uint64_t before = charge.amount();
  if (before >= worlds * bytes_of_world) return {};
  Result<BudgetCharge> more = BudgetCharge::take(budget, resource, worlds * bytes_of_world - before);
  if (!more) {
    uint32_t fits = 0;
    for (uint32_t step = std::bit_floor(worlds); step > 0; step /= 2) {
      const uint64_t bytes = (fits + step) * bytes_of_world;
      if (fits + step < worlds && (bytes <= before || BudgetCharge::take(budget, resource, bytes - before)))
        fits += step;
    }
    return CameraRefused{Refusal::too_large, std::to_string(worlds) + " worlds do not fit, " +
                                                 std::to_string(fits) + " do: " + more.error().message};
  }
  more->release();
  charge.release();
  Result<BudgetCharge> all = BudgetCharge::take(budget, resource, worlds * bytes_of_world);
  if (!all) return CameraRefused{Refusal::too_large, all.error().message};
  charge = std::move(*all);
  return {};
}

}  // namespace

settings::DrawSettings batch_settings(settings::DrawSettings settings) {
  settings.post.fxaa = false;
  if (settings.shadows.method != settings::ShadowMethod::off) {
    settings.shadows.method = settings::ShadowMethod::map;
    settings.shadows.small_maps = true;
  }
  return settings;
}

WorldBatches::~WorldBatches() {
  if (renderer_ || !pending_.empty()) device_.wait(device_.last_submitted());
}

void WorldBatches::release() {
  cancel();
  owner_.reset();
  free_buffers_.clear();
  if (!renderer_) return;
  device_.wait(device_.last_submitted());
  drop_worlds();
  renderer_.reset();
  device_.retire_all_now();
}

void WorldBatches::drop_worlds() {
  shown_scene_.reset();
  world_count_ = 0;
  streams_.clear();
  world_pointers_.clear();
  worlds_.clear();
}

void WorldBatches::unbind() {
  for (size_t world = 0; world < streams_.size(); ++world) worlds_[world].remove_stream(streams_[world]);
  streams_.clear();
}

// Makes the worlds those of the request: charged, with the displayed scene, bound to the stream's names.
std::optional<CameraRefused> WorldBatches::take_worlds(const Due& due, const Source& source) {
  const wire::ImageBatch& batch = *due.request.batch;
  for (const uint32_t index : batch.node_indices) {
    if (index < source.stream.node_names.size()) continue;
    return CameraRefused{Refusal::bad_request, "ImageRequest.batch.node_indices names node " +
                                                   std::to_string(index) + " of " +
                                                   std::to_string(source.stream.node_names.size())};
  }
  if (auto refused = charge(due, source)) return refused;
  try {
    if (auto refused = show(source, batch.worlds)) return refused;
    return bind(due, source);
  } catch (const std::bad_alloc&) {
    release();
    return CameraRefused{Refusal::too_large,
                         "the renderer has no memory for " + std::to_string(batch.worlds) + " worlds"};
  }
}

// A refused request leaves the worlds to their owner. More worlds than requested stay, if they are charged,
// too: for the same requester, or if they are not many more.
std::optional<CameraRefused> WorldBatches::charge(const Due& due, const Source& source) {
  const uint32_t worlds = due.request.batch->worlds;
  Owner next;
  next.requester = due.requester;
  const bool is_new = !owner_ || owner_->requester != due.requester;
  Owner& owner = is_new ? next : *owner_;
  const uint64_t device_bytes = device_bytes_of_world(due, source);
  const uint64_t host_bytes = host_bytes_of_world(source.scene.loaded().scene, due, source.stream);
  const auto take = [&](uint32_t count) {
    auto refused =
        charge_worlds(owner.device_memory, source.budget, Resource::gpu_bytes, count, device_bytes);
    if (!refused)
      refused = charge_worlds(owner.host_memory, source.budget, Resource::pose_bytes, count, host_bytes);
    return refused;
  };
  const bool has_more = world_count_ > worlds && shown_scene_ == source.scene.replaced();
  const bool keeps = has_more && !(is_new && worlds < world_count_ / 2) && !take(world_count_);
  if (!keeps) {
    if (auto refused = take(worlds)) return refused;
  }
  if (has_more && !keeps) {
    device_.wait(device_.last_submitted());
    drop_worlds();
    (void)owner.device_memory.resize(std::min(owner.device_memory.amount(), worlds * device_bytes));
    (void)owner.host_memory.resize(std::min(owner.host_memory.amount(), worlds * host_bytes));
  }
  if (is_new) owner_ = std::move(next);
  return {};
}

// Shows the displayed scene in at least so many worlds.
std::optional<CameraRefused> WorldBatches::show(const Source& source, uint32_t worlds) {
  const settings::DrawSettings settings = batch_settings(source.settings);
  const bool is_other = renderer_ && renderer_->needs_new_renderer(settings);
  if (is_other || (shown_scene_ && shown_scene_ != source.scene.replaced())) {
    device_.wait(device_.last_submitted());
    drop_worlds();
    if (is_other) renderer_.reset();
    device_.retire_all_now();
  }
  if (world_count_ >= worlds) {
    renderer_->apply(settings);
    return {};
  }
  const scene::LoadedScene& loaded = source.scene.loaded();
  uint32_t fits = worlds;
  const auto has_room = [&](auto&& action) {
    try {
      action();
      return true;
    } catch (const gpu::VulkanFailure& failure) {
      if (!gpu::is_out_of_memory(failure)) throw;
      return false;
    }
  };
  Result<void> textures;
  const bool has_renderer = has_room([&] {
    if (!renderer_) renderer_.emplace(device_, settings);
    textures = passes::ensure_texture_capacity(device_, settings, loaded.scene, renderer_);
  });
  if (!textures) return CameraRefused{Refusal::too_large, textures.error().message};
  if (has_renderer) {
    renderer_->apply(settings);
    renderer_->set_edits(source.scene.edits());
    while (fits > 0 && !has_room([&] { renderer_->set_scene(loaded.scene, loaded.derived, fits); }))
      fits /= 2;
  }
  if (!has_renderer || fits < worlds) {
    release();
    if (!has_renderer || fits == 0)
      return CameraRefused{Refusal::too_large,
                           "the device has no memory for another copy of the scene, which batches need"};
    return CameraRefused{Refusal::too_large, std::to_string(worlds) +
                                                 " worlds do not fit into the device's memory, " +
                                                 std::to_string(fits) + " do"};
  }
  shown_scene_ = source.scene.replaced();
  world_count_ = worlds;
  const uint32_t file_nodes = source.scene.file_nodes();
  while (worlds_.size() < worlds) {
    state::PoseState& world = worlds_.emplace_back(loaded.scene);
    // Nodes that streams have added do not make names of the file ambiguous.
    if (file_nodes < loaded.scene.nodes.size()) world.set_scene(loaded.scene, file_nodes);
    world_pointers_.push_back(&world);
  }
  return {};
}

// Binds the names of the request to the nodes of its worlds, unless they are bound already.
std::optional<CameraRefused> WorldBatches::bind(const Due& due, const Source& source) {
  const wire::ImageBatch& batch = *due.request.batch;
  if (owner_->epoch != due.request.epoch || owner_->node_indices != batch.node_indices) {
    unbind();
    owner_->epoch = due.request.epoch;
    owner_->node_indices = batch.node_indices;
  }
  if (streams_.size() >= batch.worlds) return {};
  wire::StreamDescription description;
  description.epoch = kWorldsEpoch;
  description.world_from_stream = source.stream.world_from_stream;
  const std::vector<wire::Affine3x4>& offsets = source.stream.body_from_node;
  for (const uint32_t index : batch.node_indices) {
    description.node_names.push_back(source.stream.node_names[index]);
    if (offsets.size() > 1) description.body_from_node.push_back(offsets[index]);
  }
  if (offsets.size() == 1) description.body_from_node = offsets;
  while (streams_.size() < batch.worlds) streams_.push_back(worlds_[streams_.size()].add_stream(description));
  return {};
}

void WorldBatches::set_poses(const wire::ImageBatch& batch) {
  wire::PoseFrameView frame;
  frame.header.epoch = kWorldsEpoch;
  frame.header.sequence = ++sequence_;
  frame.node_count = static_cast<uint32_t>(batch.node_indices.size());
  for (uint32_t world = 0; world < batch.worlds; ++world) {
    if (!batch.is_active(world)) continue;
    frame.poses = batch.poses_of(world);
    const bool is_shown = worlds_[world].push(streams_[world], frame);
    FIRE3DV_ASSERT(is_shown);
  }
}

// The answer, without pixels.
WorldBatches::Pending WorldBatches::make_answer(const Due& due, uint32_t hidden_streams) const {
  Pending pending;
  pending.requester = due.requester;
  pending.batch = due.request.batch;
  wire::ImageFrame& frame = pending.frame;
  frame.request = due.request.id;
  frame.number = due.number;
  frame.epoch = due.request.epoch;
  frame.sequence = due.sequence;
  frame.sim_time_ns = due.sim_time_ns;
  frame.hidden_streams = hidden_streams;
  frame.views = pending.batch->views();
  const wire::Intrinsics& size = due.request.intrinsics;
  const passes::ImageOutputs outputs(due.request.outputs);
  for (const wire::ImageOutputInfo& info : wire::kImageOutputTable) {
    if (!outputs.has(info.output)) continue;
    wire::ImagePlane& plane = frame.planes.emplace_back();
    plane.output_bit = static_cast<uint32_t>(std::countr_zero(uint32_t{info.output}));
    plane.format = info.format;
    plane.width = size.width;
    plane.height = size.height * frame.views;
    plane.row_stride = size.width * info.element_bytes;
    plane.offset = frame.pixel_bytes;
    plane.bytes = uint64_t{plane.row_stride} * plane.height;
    frame.pixel_bytes += (plane.bytes + 63) / 64 * 64;
  }
  return pending;
}

std::optional<CameraRefused> WorldBatches::begin(const Due& due, const Source& source) {
  FIRE3DV_ASSERT(!drawing_);
  const wire::ImageBatch& batch = *due.request.batch;
  // The displayed scene by the same settings, but for what batch_settings() leaves out.
  if (const Result<void> can = source.displayed.can_take(passes::ImageOutputs(due.request.outputs), 2); !can)
    return CameraRefused{Refusal::not_supported, "batches: " + can.error().message};
  if (auto refused = take_worlds(due, source)) return refused;
  set_poses(batch);

  Drawing drawing;
  drawing.due = due;
  drawing.pending = make_answer(due, source.hidden_streams);
  wire::ImageFrame& frame = drawing.pending.frame;
  wire::ImageRequest single = due.request;  // of one view
  single.batch = {};
  bool has_camera = false;
  for (uint32_t v = 0; v < frame.views; ++v) {
    const uint32_t world = batch.world_of(v);
    // A batch without an active world has a camera, too.
    if (!batch.is_active(world) && (has_camera || v + 1 < frame.views)) continue;
    if (!batch.view_poses.empty()) single.parent_from_camera = batch.view_poses[v];
    if (!batch.view_projections.empty()) {
      const wire::Projection& own = batch.view_projections[v];
      single.intrinsics.fx = own.fx;
      single.intrinsics.fy = own.fy;
      single.intrinsics.cx = own.cx;
      single.intrinsics.cy = own.cy;
    }
    const auto resolved =
        resolve_camera(single, source.stream.world_from_stream, worlds_[world], source.scene);
    if (const auto* refused = std::get_if<CameraRefused>(&resolved))
      return CameraRefused{refused->reason, "view " + std::to_string(v) + ": " + refused->why};
    const auto& camera = std::get<ImageCamera>(resolved);
    if (!has_camera) {
      const passes::Intrinsics& used = camera.intrinsics;
      frame.intrinsics = {used.image_px.x, used.image_px.y, used.fx_px, used.fy_px, used.cx_px,
                          used.cy_px,      used.near_m,     used.far_m, {}};
      frame.world_from_camera = affine_of(camera.world_from_camera);
      has_camera = true;
    }
    if (!batch.is_active(world)) continue;
    passes::View& view = drawing.views.emplace_back(pinhole_view(camera));
    view.world = world;
    view.camera = single.node;
    view.exposure = camera.exposure;
    view.lens.of_stream = true;  // a pinhole, whatever the settings say
    drawing.numbers.push_back(v);
  }
  if (drawing.views.empty()) {
    pending_.push_back(std::move(drawing.pending));
    return {};
  }
  drawing.at_once = views_of_submission(due.request.intrinsics, drawing.views.size());
  drawing_ = std::move(drawing);
  return {};
}

// Submissions of one size, which keep their targets: the last one draws some views again.
size_t WorldBatches::views_of_submission(const wire::Intrinsics& size, size_t views) const {
  const uint64_t pixel_bytes =
      uint64_t{8} * static_cast<uint32_t>(renderer_->settings().samples()) * size.width * size.height;
  const uint64_t list_bytes = sizeof(uint32_t) * uint64_t{renderer_->gpu_scene().cluster_instance_count};
  const uint64_t most =
      std::max<uint64_t>(1, std::min<uint64_t>({kMaxSubmittedViewBytes / std::max(pixel_bytes, list_bytes),
                                                device_.limits().maxImageDimension2D / size.height,
                                                device_.limits().maxImageArrayLayers}));
  const uint64_t submissions = (views + most - 1) / most;
  return (views + submissions - 1) / submissions;
}

WorldBatches::Submitted WorldBatches::go_on(gpu::FrameRing& frames) {
  Drawing& drawing = *drawing_;
  Result<void> submitted;
  bool is_lost = false;  // recorded uploads were
  try {
    submitted = submit(frames);
  } catch (const gpu::VulkanFailure& failure) {
    if (!gpu::is_out_of_memory(failure)) throw;
    submitted = Error{"out of memory"};
    is_lost = true;
  }
  if (!submitted) {
    const std::string why = "the device has no memory for " + std::to_string(drawing.views.size()) +
                            " views: " + submitted.error().message + "; request fewer or smaller ones";
    cancel();
    if (is_lost) release();
    return {0, CameraRefused{Refusal::too_large, why}};
  }
  drawing.next += drawing.at_once;
  const auto views = static_cast<uint32_t>(drawing.at_once);
  if (drawing.next >= drawing.views.size()) {
    pending_.push_back(std::move(drawing.pending));
    drawing_.reset();
  }
  return {views, {}};
}

Result<void> WorldBatches::submit(gpu::FrameRing& frames) {
  Drawing& drawing = *drawing_;
  Pending& pending = drawing.pending;
  const wire::ImageRequest& request = drawing.due.request;
  if (!pending.pixels) {
    const auto same = std::ranges::find(free_buffers_, pending.frame.pixel_bytes, &gpu::Buffer::size_bytes);
    if (same != free_buffers_.end()) {
      pending.pixels = std::move(*same);
      pending.pixels.use = {};  // its last use is over
      free_buffers_.erase(same);
    } else {
      pending.pixels = gpu::create_buffer(device_, pending.frame.pixel_bytes, 0, gpu::Memory::readback);
    }
  }
  const size_t from = std::min(drawing.next, drawing.views.size() - drawing.at_once);
  const Result<passes::PreparedFrame> prepared = renderer_->prepare(
      {.extent = {request.intrinsics.width, request.intrinsics.height},
       .views = static_cast<uint32_t>(drawing.at_once),
       .outputs = passes::ImageOutputs(request.outputs),
       .scene = drawing.next == 0 ? passes::SceneUpdate::update : passes::SceneUpdate::reuse,
       .has_history = false});
  if (!prepared) return prepared.error();
  frames.limits().set(std::nullopt, gpu::SubmissionLimits::Cause::content);
  gpu::Recorder& recorder = frames.begin();
  renderer_->record(*prepared, recorder, frames.staging(), world_pointers_,
                    std::span(drawing.views).subspan(from, drawing.at_once));
  read_back(recorder, request, std::span(drawing.numbers).subspan(from, drawing.at_once), pending);
  pending.done_at = frames.submit();
  return {};
}

void WorldBatches::cancel() {
  if (!drawing_) return;
  device_.wait(drawing_->pending.done_at);  // which may write to the buffer
  drawing_.reset();
}

// Copies the images to their places in the answer. numbers: of the recorded views, rising.
void WorldBatches::read_back(gpu::Recorder& recorder, const wire::ImageRequest& request,
                             std::span<const uint32_t> numbers, Pending& pending) {
  const wire::Intrinsics& size = request.intrinsics;
  std::vector<VkBufferImageCopy> of_image;
  std::vector<VkBufferCopy> of_planes;
  for (size_t first = 0; first < numbers.size();) {
    size_t end = first + 1;
    while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
    const auto run = static_cast<uint32_t>(end - first);
    for (const wire::ImagePlane& plane : pending.frame.planes) {
      const uint64_t view_bytes = uint64_t{plane.row_stride} * size.height;
      const uint64_t to = plane.offset + numbers[first] * view_bytes;
      const auto output = static_cast<wire::ImageOutput>(1u << plane.output_bit);
      if (output == wire::kColorSrgb8) {
        VkBufferImageCopy& copy = of_image.emplace_back();
        copy.bufferOffset = to;
        copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        copy.imageOffset.y = static_cast<int32_t>(first * size.height);
        copy.imageExtent = {size.width, run * size.height, 1};
        continue;
      }
      const auto range = std::ranges::find(renderer_->plane_ranges(), output, &passes::PlaneRange::output);
      FIRE3DV_ASSERT(range != renderer_->plane_ranges().end());
      of_planes.push_back({range->offset_bytes + first * view_bytes, to, run * view_bytes});
    }
    first = end;
  }
  std::vector<gpu::Use> uses{gpu::Use(pending.pixels, gpu::access::transfer_write)};
  if (!of_image.empty()) uses.emplace_back(renderer_->image(), gpu::access::transfer_read);
  if (!of_planes.empty()) uses.emplace_back(renderer_->planes(), gpu::access::transfer_read);
  recorder.pass("read-back", uses, [&](VkCommandBuffer commands) {
    if (!of_image.empty())
      vkCmdCopyImageToBuffer(commands, renderer_->image().get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                             pending.pixels.get(), static_cast<uint32_t>(of_image.size()), of_image.data());
    if (!of_planes.empty())
      vkCmdCopyBuffer(commands, renderer_->planes().get(), pending.pixels.get(),
                      static_cast<uint32_t>(of_planes.size()), of_planes.data());
  });
  recorder.transition({gpu::Use(pending.pixels, gpu::access::host_read)});
}

void WorldBatches::deliver(const Take& take) {
  while (!pending_.empty() && pending_.front().done_at <= device_.completed()) {
    Pending done = std::move(pending_.front());
    pending_.pop_front();
    const wire::ImageBatch& batch = *done.batch;
    take(done.requester, done.frame, [&](std::span<std::byte> to) {
      FIRE3DV_ASSERT(to.size() == done.frame.pixel_bytes);
      const auto* const from = static_cast<const std::byte*>(done.pixels.mapped);
      for (size_t i = 0; i < done.frame.planes.size(); ++i) {
        const wire::ImagePlane& plane = done.frame.planes[i];
        const uint64_t end =
            i + 1 < done.frame.planes.size() ? done.frame.planes[i + 1].offset : done.frame.pixel_bytes;
        const uint64_t filled = plane.offset + plane.bytes;
        const uint64_t view_bytes = plane.bytes / done.frame.views;
        if (from) std::memcpy(to.data() + plane.offset, from + plane.offset, plane.bytes);
        for (uint32_t v = 0; v < done.frame.views; ++v) {
          if (!batch.is_active(batch.world_of(v)))
            std::memset(to.data() + plane.offset + v * view_bytes, 0, view_bytes);
        }
        std::memset(to.data() + filled, 0, end - filled);
      }
    });
    if (done.pixels) free_buffers_.push_back(std::move(done.pixels));
    if (free_buffers_.size() > kMaxFreeBuffers) free_buffers_.erase(free_buffers_.begin());
  }
}

}  // namespace fire3dv::app
