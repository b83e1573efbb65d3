// Test device with validation layers, and image capture.
#include "tests/render/support/render_bench.h"
#include "renderer/gpu/selection/device_choice.h"
#include "renderer/passes/outputs/planes_and_boxes.h"

#include <cstdio>
#include <cstdlib>

namespace fire3dv::test {
namespace {

template <typename T>
T take_or_die(Result<T> result) {
  if (!result) {
    std::fprintf(stderr, "render tests cannot run: %s\n", result.error().message.c_str());
    std::exit(1);
  }
  return std::move(*result);
}

struct Bench {
  std::unique_ptr<gpu::Instance> instance;
  std::unique_ptr<gpu::Device> device;
  uint32_t index = 0;

  Bench() {
    gpu::InstanceOptions options;
    options.validation = true;
    instance = take_or_die(gpu::Instance::create(options));
    const std::vector<gpu::DeviceReport> reports = gpu::report_devices(instance->handle());
    const gpu::DeviceChoice choice = take_or_die(gpu::choose_device(reports, ""));
    if (!reports[choice.index].ray_query) {
      std::fprintf(stderr, "render tests cannot run: %s has no ray queries; install a newer Mesa\n",
                   reports[choice.index].name.c_str());
      std::exit(1);
    }
    index = choice.index;
    device = take_or_die(gpu::Device::create(*instance, index, false));
    device->pipeline_keeper().start();
  }
};

Bench& bench() {
  static Bench the_bench;
  return the_bench;
}

}  // namespace

gpu::Instance& instance() {
  return *bench().instance;
}
gpu::Device& device() {
  return *bench().device;
}

std::unique_ptr<gpu::Device> open_device(gpu::AsyncCompute async_compute) {
  std::unique_ptr<gpu::Device> device =
      take_or_die(gpu::Device::create(instance(), bench().index, false, async_compute));
  device->pipeline_keeper().start();
  return device;
}

RenderBench::RenderBench(const scene::Scene& scene, VkExtent2D extent, const settings::DrawSettings& settings,
                         gpu::Device& on)
    : scene_(scene), frames_(on), renderer_(on, settings), readback_(on) {
  frames_.time(gpu::Timed::passes);
  renderer_.set_scene(scene);
  set_size(extent);
}

void RenderBench::set_size(VkExtent2D extent) {
  extent_ = extent;
  prepare();
}

passes::PreparedFrame RenderBench::prepare(passes::FrameRequest request) {
  request.extent = extent_;
  request.in_motion = in_motion_;
  return take_or_die(renderer_.prepare(request));
}

void RenderBench::record_and_submit(const state::PoseState& poses, const passes::View& view, bool refines) {
  passes::PathHooks hooks;
  if (refines) hooks.budget.emplace(0);
  auto begun = take_or_die(renderer_.begin_next(frames_,
                                                {.extent = extent_,
                                                 .markers = shows_markers_,
                                                 .in_motion = in_motion_,
                                                 .refines = refines,
                                                 .shows_previous_image = refines},
                                                poses, view, hooks));
  gpu::Recorder& recorder = begun->recorder;
  renderer_.record(begun->prepared, recorder, frames_.staging(), poses, view);
  renderer_.draw_stale_overlay(recorder, condition_);
  readback_.record(recorder, renderer_.image(), 0);
  readback_.submitted(frames_.submit());
}

void RenderBench::collect(std::vector<sinks::FrameImage>& images, bool all) {
  auto add = [&](int, VkExtent2D extent, std::span<const uint8_t> rgba8) {
    sinks::FrameImage& image = images.emplace_back();
    image.width = extent.width;
    image.height = extent.height;
    image.rgba8.assign(rgba8.begin(), rgba8.end());
  };
  if (all) {
    readback_.drain(add);
  } else {
    readback_.poll(add);
  }
}

sinks::FrameImage RenderBench::refine(const state::PoseState& poses, const passes::View& view) {
  record_and_submit(poses, view, true);
  std::vector<sinks::FrameImage> images;
  collect(images, true);
  return std::move(images.back());
}

sinks::FrameImage RenderBench::draw(const state::PoseState& poses, const passes::View& view) {
  record_and_submit(poses, view);
  std::vector<sinks::FrameImage> images;
  collect(images, true);
  images.back().shown = poses.shown();
  return std::move(images.back());
}

Taken RenderBench::take(const state::PoseState& poses, const passes::View& view,
                        const passes::ImageOutputs& outputs, passes::CameraHistory* history) {
  return take(poses, std::span(&view, 1), outputs, std::span(history, history ? 1 : 0));
}

Taken RenderBench::take(const state::PoseState& poses, std::span<const passes::View> views,
                        const passes::ImageOutputs& outputs, std::span<passes::CameraHistory> histories) {
  const state::PoseState* const world = &poses;
  return take(std::span(&world, 1), views, outputs, histories);
}

Taken RenderBench::take(std::span<const state::PoseState* const> poses, std::span<const passes::View> views,
                        const passes::ImageOutputs& outputs, std::span<passes::CameraHistory> histories) {
  const passes::PreparedFrame prepared =
      prepare({.views = static_cast<uint32_t>(views.size()), .outputs = outputs, .markers = shows_markers_});
  if (renderer_.traces_paths()) renderer_.trace_paths(prepared, *poses[views[0].world], views[0]);
  gpu::Recorder& recorder = frames_.begin();
  renderer_.record(prepared, recorder, frames_.staging(), poses, views, histories);
  Taken taken;
  gpu::ReadbackRing<int>::Planes planes;
  if (outputs.has_planes()) {
    taken.places = renderer_.plane_ranges();
    planes = {&renderer_.planes(), passes::bytes_of(taken.places)};
  }
  readback_.record(recorder, outputs.has(wire::kColorSrgb8) ? &renderer_.image() : nullptr,
                   renderer_.image().extent, planes, 0);
  readback_.submitted(frames_.submit());
  readback_.drain([&](int, VkExtent2D extent, std::span<const uint8_t> bytes) {
    const auto colors =
        static_cast<std::ptrdiff_t>(outputs.has(wire::kColorSrgb8) ? 4 * extent.width * extent.height : 0);
    taken.image.width = extent.width;
    taken.image.height = extent.height;
    taken.image.rgba8.assign(bytes.begin(), bytes.begin() + colors);
    taken.planes.assign(bytes.begin() + colors, bytes.end());
  });
  return taken;
}

std::vector<sinks::FrameImage> RenderBench::draw_on(state::PoseState& poses,
                                                    const std::vector<state::RestPose>& moved) {
  std::vector<sinks::FrameImage> images;
  for (const state::RestPose& rest : moved) {
    poses.set_rest(rest);
    record_and_submit(poses, first_camera_view(scene_, poses, renderer_.extent()));
    collect(images, false);
  }
  collect(images, true);
  return images;
}

sinks::FrameImage RenderBench::draw_at_rest() {
  const state::PoseState poses(scene_);
  return draw(poses, first_camera_view(scene_, poses, renderer_.extent()));
}

passes::View first_camera_view(const scene::Scene& scene, const state::PoseState& poses, VkExtent2D extent) {
  const uint32_t node = scene::camera_nodes(scene).at(0);
  return passes::make_view(scene.cameras[scene.nodes[node].camera], poses.world_from_node(node),
                           static_cast<float>(extent.width) / static_cast<float>(extent.height));
}

void ValidationIsSilent::TearDown() {
  EXPECT_EQ(instance().validation_messages(), 0u) << "Vulkan validation has found something; see above";
}

glm::ivec3 pixel(const sinks::FrameImage& image, uint32_t x, uint32_t y) {
  const uint8_t* p = image.rgba8.data() + size_t{4} * (size_t{y} * image.width + x);
  return {p[0], p[1], p[2]};
}

}  // namespace fire3dv::test
