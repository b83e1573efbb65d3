// Render test of frames with work on the async compute queue: byte-identical images, no leaked objects, and
// each pass waits only for its dependencies. The test driver has one queue, which executes the submissions in
// order; tests/unit/renderer/gpu/forked_submit_test.cpp enumerates the possible orders of two queues.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <string>
#include <vector>

#include "tests/render/support/bent_bar.h"
#include "tests/render/support/render_bench.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

using settings::RasterPath;
using settings::RayBackEnd;
using settings::ShadowMethod;
using Names = std::vector<std::string>;

constexpr VkExtent2D kExtent{64, 48};

gpu::Device& forking_device() {
  instance();  // must outlive the device, so it is constructed before
  static const std::unique_ptr<gpu::Device> device = open_device(gpu::AsyncCompute::on);
  return *device;
}

settings::DrawSettings settings_of(RasterPath raster, settings::ShadowSettings shadows) {
  settings::DrawSettings settings;
  settings.raster = raster;
  settings.shadows = shadows;
  return settings;
}

// The bar bends, and its neighbour moves.
std::vector<state::RestPose> poses_of(const scene::Scene& scene, uint32_t count) {
  std::vector<state::RestPose> poses;
  for (uint32_t i = 0; i < count; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(count);
    const glm::mat4 bent = glm::rotate(glm::mat4(1), 1.2f * t, {0, 0, 1});
    state::RestPose pose = moved(scene, {at({-0.6f, 0, t}), at({0, 1, 0}) * bent, 1 - t});
    for (size_t n = 0; n < scene.nodes.size(); ++n) {
      if (scene.nodes[n].name == "beside")
        pose.world_from_node[n] = pose.parent_from_node[n] = at({1.6f - t, 0, 0});
    }
    poses.push_back(pose);
  }
  return poses;
}

std::vector<gpu::FrameTimes> finished_times(RenderBench& bench) {
  return bench.frames().take_finished();
}

Names passes_of(const gpu::FrameTimes& times, bool async_compute) {
  Names names;
  for (const gpu::PassTime& pass : times.passes) {
    if (pass.async_compute == async_compute) names.emplace_back(pass.name);
  }
  return names;
}

class Async : public ValidationIsSilent {};

TEST_F(Async, FiftyFramesAreSameToByte) {
  const scene::Scene scene = skinned_bar({});
  const std::vector<state::RestPose> moved = poses_of(scene, 50);
  const settings::DrawSettings settings = settings_of(RasterPath::visibility, {ShadowMethod::ray, false});
  state::PoseState poses(scene), poses_again(scene);
  RenderBench whole(scene, kExtent, settings), forked(scene, kExtent, settings, forking_device());
  const std::vector<sinks::FrameImage> expected = whole.draw_on(poses, moved);
  const std::vector<sinks::FrameImage> images = forked.draw_on(poses_again, moved);
  ASSERT_EQ(images.size(), moved.size());
  for (size_t i = 0; i < images.size(); ++i) {
    ASSERT_EQ(images[i].rgba8, expected[i].rgba8) << "image " << i;
    if (i > 0) {
      ASSERT_NE(images[i].rgba8, images[i - 1].rgba8) << "nothing moves";
    }
  }
  for (const gpu::FrameTimes& times : finished_times(forked)) {
    EXPECT_EQ(passes_of(times, true), (Names{"deformed blas", "tlas"}));
  }
  for (const gpu::FrameTimes& times : finished_times(whole)) EXPECT_EQ(passes_of(times, true), Names{});
}

TEST_F(Async, AllConfigurationsDrawTheSame) {
  const scene::Scene scene = skinned_bar({});
  const std::vector<state::RestPose> moved = poses_of(scene, 4);
  for (const RasterPath raster : {RasterPath::visibility, RasterPath::forward}) {
    for (const RayBackEnd back_end : {RayBackEnd::query, RayBackEnd::pipeline}) {
      for (const bool hybrid : {false, true}) {
        SCOPED_TRACE(testing::Message() << static_cast<int>(raster) << static_cast<int>(back_end) << hybrid);
        const settings::DrawSettings settings = settings_of(raster, {ShadowMethod::ray, hybrid, back_end});
        state::PoseState poses(scene), poses_again(scene);
        RenderBench whole(scene, kExtent, settings), forked(scene, kExtent, settings, forking_device());
        const std::vector<sinks::FrameImage> expected = whole.draw_on(poses, moved);
        const std::vector<sinks::FrameImage> images = forked.draw_on(poses_again, moved);
        for (size_t i = 0; i < moved.size(); ++i) EXPECT_EQ(images[i].rgba8, expected[i].rgba8) << i;
      }
    }
  }
}

TEST_F(Async, FrameWaitsBeforeRayTracing) {
  const scene::Scene scene = skinned_bar({});
  RenderBench bench(scene, kExtent, settings_of(RasterPath::visibility, {ShadowMethod::ray}),
                    forking_device());
  bench.draw_at_rest();
  const std::vector<gpu::FrameTimes> times = finished_times(bench);
  ASSERT_EQ(times.size(), 1u);
  const Names passes = passes_of(times[0], false);
  const auto wait = std::find(passes.begin(), passes.end(), "tlas wait");
  ASSERT_GT(passes.end() - wait, 1);
  EXPECT_EQ(*(wait + 1), "trace");
  for (const char* overlapped : {"cull", "raster", "tiles", "shade"}) {
    EXPECT_LT(std::find(passes.begin(), passes.end(), overlapped), wait) << overlapped;
  }
  double longest = 0;
  for (const gpu::PassTime& pass : times[0].passes) longest = std::max(longest, pass.milliseconds);
  EXPECT_GE(times[0].total_ms, longest) << "the frame's span leaves something out";
}

TEST_F(Async, NoTracingBuildsNothing) {
  const scene::Scene scene = skinned_bar({});
  scene::Scene dark = scene;
  for (scene::Node& node : dark.nodes) node.light = scene::kNone;
  struct Case {
    const scene::Scene& scene;
    settings::ShadowSettings shadows;
  };
  for (const Case& untraced : {Case{scene, {ShadowMethod::map}}, Case{scene, {ShadowMethod::off}},
                               Case{dark, {ShadowMethod::ray, false}}}) {
    for (const RasterPath raster : {RasterPath::visibility, RasterPath::forward}) {
      const settings::DrawSettings settings = settings_of(raster, untraced.shadows);
      RenderBench bench(untraced.scene, kExtent, settings, forking_device());
      const sinks::FrameImage image = bench.draw_at_rest();
      EXPECT_FALSE(bench.renderer().traces_shadow_rays());
      const std::vector<gpu::FrameTimes> times = finished_times(bench);
      ASSERT_EQ(times.size(), 1u);
      EXPECT_EQ(passes_of(times[0], true), Names{});
      const Names passes = passes_of(times[0], false);
      for (const char* absent : {"tlas", "deformed blas", "tlas wait"}) {
        EXPECT_EQ(std::count(passes.begin(), passes.end(), absent), 0) << absent;
      }
      EXPECT_EQ(image.rgba8, RenderBench(untraced.scene, kExtent, settings).draw_at_rest().rgba8);
    }
  }
}

TEST_F(Async, NothingIsLeftBehind) {
  gpu::Device& device = forking_device();
  auto settled = [&] {
    device.retire_all_now();
    return device.live_objects();
  };
  const gpu::LiveObjects before = settled();
  const uint64_t bytes_before = device.allocated_bytes();
  {
    const scene::Scene first = skinned_bar({}), second = morphed_bar(1);
    const settings::DrawSettings settings = settings_of(RasterPath::visibility, {ShadowMethod::ray, false});
    RenderBench bench(first, kExtent, settings, device);
    const passes::View view = first_camera_view(first, state::PoseState(first), kExtent);
    // Replaces the scene while frames that use it are in flight.
    for (uint32_t i = 0; i < 10; ++i) {
      const scene::Scene& scene = i % 2 ? second : first;
      bench.renderer().set_scene(scene);
      bench.set_size({kExtent.width + i, kExtent.height});
      const state::PoseState poses(scene);
      bench.renderer().record(bench.prepare(), bench.frames().begin(), bench.frames().staging(), poses, view);
      bench.frames().submit();
    }
  }
  EXPECT_EQ(settled(), before);
  EXPECT_EQ(device.allocated_bytes(), bytes_before);
}

// Recorder with four buffers that commands fill and copy.
class AsidePasses : public ValidationIsSilent {
 protected:
  explicit AsidePasses(gpu::Device& on = forking_device()) : device_(on), frames_(on) {
    frames_.time(gpu::Timed::passes);
    for (gpu::Buffer& buffer : buffers_)
      buffer = gpu::create_buffer(device_, kBytes, 0, gpu::Memory::readback);
  }

  static void fill(gpu::Recorder& recorder, const char* name, gpu::Buffer& buffer, uint32_t value) {
    recorder.pass(name, {gpu::Use(buffer, gpu::access::transfer_write)}, [&](VkCommandBuffer commands) {
      vkCmdFillBuffer(commands, buffer.get(), 0, kBytes, value);
    });
  }
  static void copy(gpu::Recorder& recorder, const char* name, gpu::Buffer& from, gpu::Buffer& to) {
    recorder.pass(name,
                  {gpu::Use(from, gpu::access::transfer_read), gpu::Use(to, gpu::access::transfer_write)},
                  [&](VkCommandBuffer commands) {
                    const VkBufferCopy all{0, 0, kBytes};
                    vkCmdCopyBuffer(commands, from.get(), to.get(), 1, &all);
                  });
  }
  // Submits the frame and returns the passes of the graphics queue.
  Names finish() {
    for (gpu::Buffer& buffer : buffers_) recorder_->transition({gpu::Use(buffer, gpu::access::host_read)});
    device_.wait(frames_.submit());
    return passes_of(frames_.take_finished().at(0), false);
  }
  uint32_t value(const gpu::Buffer& buffer) const {
    uint32_t value = 0;
    std::memcpy(&value, buffer.mapped, sizeof(value));
    return value;
  }
  gpu::Recorder& begin() {
    recorder_ = &frames_.begin();
    return *recorder_;
  }

  static constexpr VkDeviceSize kBytes = 256;
  gpu::Device& device_;
  gpu::FrameRing frames_;
  gpu::Recorder* recorder_ = nullptr;
  std::array<gpu::Buffer, 4> buffers_;
  gpu::Buffer &a_ = buffers_[0], &b_ = buffers_[1], &c_ = buffers_[2], &d_ = buffers_[3];
};

TEST_F(AsidePasses, ReaderWaitsForAsyncWrite) {
  gpu::Recorder& recorder = begin();
  recorder.async_compute("wait", [&] { fill(recorder, "fill a", a_, 1); });
  fill(recorder, "fill b", b_, 2);
  copy(recorder, "copy b", b_, c_);
  copy(recorder, "copy a", a_, c_);
  EXPECT_EQ(finish(), (Names{"fill b", "copy b", "wait", "copy a"}));
  EXPECT_EQ(value(c_), 1u);
}

TEST_F(AsidePasses, WriterWaitsForAsyncRead) {
  gpu::Recorder& recorder = begin();
  fill(recorder, "fill a", a_, 1);
  recorder.async_compute("wait", [&] { copy(recorder, "async copy", a_, b_); });
  copy(recorder, "overlapped copy", a_, c_);
  fill(recorder, "fill again", a_, 3);
  EXPECT_EQ(finish(), (Names{"fill a", "overlapped copy", "wait", "fill again"}));
  EXPECT_EQ(value(a_), 3u);
  EXPECT_EQ(value(b_), 1u);
  EXPECT_EQ(value(c_), 1u);
}

TEST_F(AsidePasses, TimingPerFrameOrPass) {
  const auto draw = [&](bool forks) {
    gpu::Recorder& recorder = begin();
    if (forks) recorder.async_compute("wait", [&] { fill(recorder, "fill a", a_, 1); });
    fill(recorder, "fill b", b_, 2);
    copy(recorder, "copy a", a_, c_);
    device_.wait(frames_.submit());
    return frames_.take_finished().at(0);
  };
  for (const bool forks : {true, false}) {
    frames_.time(gpu::Timed::frame);
    const gpu::FrameTimes whole = draw(forks);
    EXPECT_TRUE(whole.passes.empty());
    EXPECT_GT(whole.total_ms, 0);
    frames_.time(gpu::Timed::passes);
    const gpu::FrameTimes by_pass = draw(forks);
    EXPECT_EQ(passes_of(by_pass, false),
              forks ? (Names{"fill b", "wait", "copy a"}) : (Names{"fill b", "copy a"}));
    EXPECT_GT(by_pass.total_ms, 0);
  }
}

// A copy for the host at the end of the frame reads the buffer as it was at the call.
TEST_F(AsidePasses, CopyPrecedesOverwrite) {
  gpu::Recorder& recorder = begin();
  fill(recorder, "fill a", a_, 1);
  recorder.copy_at_end(a_, b_, {{0, 0, kBytes}});
  fill(recorder, "fill c", c_, 3);
  fill(recorder, "fill again", a_, 2);
  EXPECT_EQ(finish(), (Names{"fill a", "fill c", "counts", "fill again"}));
  EXPECT_EQ(value(a_), 2u);
  EXPECT_EQ(value(b_), 1u);
}

// The copy may overlap the next pass if that does not write its source; a later writer waits.
TEST_F(AsidePasses, CopiesGoBesideNextPass) {
  uint32_t number = 0;
  for (const gpu::Timed timed : {gpu::Timed::frame, gpu::Timed::passes}) {
    frames_.time(timed);
    gpu::Recorder& recorder = begin();
    fill(recorder, "fill a", a_, ++number);
    recorder.copy_at_end(a_, b_, {{0, 0, kBytes}});
    recorder.overlap_copies_with_next();
    fill(recorder, "fill c", c_, 100);
    fill(recorder, "fill again", a_, ++number);
    recorder.copy_at_end(a_, d_, {{0, 0, kBytes}});
    const Names passes = finish();
    if (timed == gpu::Timed::passes) {
      EXPECT_EQ(passes, (Names{"fill a", "counts", "fill c", "fill again", "counts"}));
    }
    EXPECT_EQ(value(a_), number);
    EXPECT_EQ(value(b_), number - 1);
    EXPECT_EQ(value(c_), 100u);
    EXPECT_EQ(value(d_), number);
  }
}

TEST_F(AsidePasses, CopiesAreMergedAtEnd) {
  gpu::Recorder& recorder = begin();
  fill(recorder, "fill a", a_, 1);
  fill(recorder, "fill b", b_, 2);
  recorder.copy_at_end(a_, c_, {{0, 0, kBytes / 2}});
  recorder.copy_at_end(b_, d_, {{0, 0, kBytes}});
  EXPECT_EQ(finish(), (Names{"fill a", "fill b", "counts"}));
  EXPECT_EQ(value(c_), 1u);
  EXPECT_EQ(value(d_), 2u);

  gpu::Recorder& next = begin();
  next.copy_at_end(a_, c_, {{0, 0, kBytes}});
  next.copy_at_end(b_, c_, {{0, 0, kBytes}});
  EXPECT_EQ(finish(), (Names{"counts", "counts"}));
  EXPECT_EQ(value(c_), 2u);
}

TEST_F(AsidePasses, FrameWaitsForAsyncPasses) {
  gpu::Recorder& recorder = begin();
  recorder.async_compute("wait", [&] {
    fill(recorder, "fill a", a_, 1);
    copy(recorder, "copy", a_, b_);
    fill(recorder, "fill again", a_, 2);
  });
  fill(recorder, "fill c", c_, 3);
  device_.wait(frames_.submit());
  EXPECT_EQ(passes_of(frames_.take_finished().at(0), false), (Names{"fill c", "wait"}));
  EXPECT_EQ(value(a_), 2u);
  EXPECT_EQ(value(b_), 1u);
}

TEST_F(AsidePasses, OneFrameAfterTheOther) {
  for (uint32_t i = 0; i < 6; ++i) {
    gpu::Recorder& recorder = begin();
    fill(recorder, "fill a", a_, i);
    recorder.async_compute("wait", [&] { copy(recorder, "async copy", a_, b_); });
    copy(recorder, "overlapped copy", a_, c_);
    if (i % 2 == 0) copy(recorder, "copy back", b_, c_);
    finish();
    EXPECT_EQ(value(b_), i);
    EXPECT_EQ(value(c_), i);
  }
}

class WithoutASideQueue : public AsidePasses {
 protected:
  WithoutASideQueue() : AsidePasses(device()) {}
};

TEST_F(WithoutASideQueue, AsyncPassesKeepRecordedOrder) {
  ASSERT_EQ(device().queues().async, gpu::AsyncQueue::none);
  gpu::Recorder& recorder = begin();
  recorder.async_compute("wait", [&] { fill(recorder, "fill a", a_, 1); });
  copy(recorder, "copy a", a_, c_);
  EXPECT_EQ(finish(), (Names{"fill a", "copy a"}));
  EXPECT_EQ(value(c_), 1u);
}

}  // namespace
}  // namespace fire3dv::test
