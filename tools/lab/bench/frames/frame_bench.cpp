#include "tools/lab/bench/frames/frame_bench.h"

#include <unistd.h>

#include <fstream>
#include <random>
#include <utility>

#include "base/clock.h"
#include "protocol/transport/open.h"
#include "protocol/wire/encode.h"
#include "tools/lab/bench/panel_facts.h"

namespace fire3dv::bench {

namespace {

constexpr uint64_t kStop = UINT64_MAX;
constexpr int64_t kStepNs = 1'000'000;

}  // namespace

Result<std::unique_ptr<PoseFeed>> PoseFeed::open(const std::string& uri, std::vector<std::string> names,
                                                 PoseAt pose_at) {
  Result<std::unique_ptr<transport::PublisherLink>> link = transport::open_publisher(uri);
  if (!link) return link.error();
  std::unique_ptr<PoseFeed> feed(new PoseFeed);
  feed->link_ = std::move(*link);
  feed->pose_at_ = std::move(pose_at);
  std::random_device random;
  feed->epoch_ = (uint64_t{random()} << 32 | random()) | 1;
  feed->count_ = static_cast<uint32_t>(names.size());

  wire::StreamDescription description;
  description.adapter_name = "fire3dv-bench";
  description.epoch = feed->epoch_;
  description.node_names = std::move(names);
  description.nominal_rate_hz = 1e9 / kStepNs;
  // A common boot_id disables interpolation: the renderer shows frames on arrival.
  std::ifstream("/proc/sys/kernel/random/boot_id") >> description.clock.boot_id;
  if (Result<void> described = feed->link_->set_description(wire::encode(description)); !described)
    return described.error();
  feed->thread_ = std::thread([raw = feed.get()] { raw->work(); });
  return feed;
}

PoseFeed::~PoseFeed() {
  wanted_ = kStop;
  wanted_.notify_one();
  if (thread_.joinable()) thread_.join();
}

uint64_t PoseFeed::ask_for_next() {
  const uint64_t sequence = ++wanted_;
  wanted_.notify_one();
  return sequence;
}

void PoseFeed::work() {
  wire::PoseFrameEncoder encoder;
  std::vector<wire::Affine3x4> poses;
  for (uint64_t sequence = 1;; ++sequence) {
    // The step is computed before the request, as by a simulator that is ahead.
    pose_at_(sequence, poses);
    uint64_t wanted = wanted_;
    while (wanted < sequence) {
      wanted_.wait(wanted);
      wanted = wanted_;
    }
    if (wanted == kStop) return;
    wire::PoseFrameView frame;
    frame.header.epoch = epoch_;
    frame.header.sequence = sequence;
    frame.header.sim_time_ns = static_cast<int64_t>(sequence) * kStepNs;
    frame.header.publish_time_ns = static_cast<uint64_t>(fire3dv::monotonic_ns());
    frame.node_count = count_;
    frame.poses = poses;
    link_->publish(encoder.encode(frame));
  }
}

namespace {

struct PassStage {
  std::string_view pass;
  Stage stage;
};

// Shadow maps are culled and drawn in the same dispatches as the camera view, so with shadows on "cull" and
// "raster" include them. The main pass is therefore measured with shadows off.
constexpr PassStage kTable[] = {
    {"pose sources", Stage::poses},
    {"poses", Stage::poses},
    {"transforms", Stage::poses},
    {"draws", Stage::poses},
    {"morph weights", Stage::poses},
    {"deform", Stage::poses},
    {"tlas", Stage::tlas},
    {"deformed blas", Stage::tlas},
    {"tlas wait", Stage::tlas_wait},
    {"coverage merge", Stage::shading},
    {"cull", Stage::cull},
    {"draw commands", Stage::cull},
    {"clear", Stage::raster},
    {"raster", Stage::raster},
    {"expand", Stage::raster},
    {"tiles", Stage::raster},
    {"depth", Stage::raster},
    {"depth pyramid", Stage::cull},
    {"late cull", Stage::cull},
    {"late raster", Stage::raster},
    {"late expand", Stage::raster},
    {"late tiles", Stage::raster},
    {"light views", Stage::shadow},
    {"classify", Stage::shadow},
    {"trace", Stage::shadow},
    {"ray effects begin", Stage::rays},
    {"ray effects", Stage::rays},
    {"shade", Stage::shading},
    {"shade again", Stage::shading},
    {"forward", Stage::shading},
    {"post", Stage::post},
    {"fxaa", Stage::post},
    {"gui", Stage::gui},
    {"read-back", Stage::readback},
    {"stale overlay", Stage::gui},
    {"counts", Stage::post},  // readback of counters
};

}  // namespace

const char* stage_name(Stage stage) {
  constexpr const char* kNames[] = {"poses",       "TLAS",    "TLAS wait", "cull", "raster",   "shadow",
                                    "ray effects", "shading", "post",      "GUI",  "read-back"};
  static_assert(std::size(kNames) == kStages);
  return kNames[static_cast<size_t>(stage)];
}

std::optional<Stage> stage_of(std::string_view pass) {
  for (const PassStage& row : kTable) {
    if (row.pass == pass) return row.stage;
  }
  return std::nullopt;
}

double StageTimes::main_pass_ms() const {
  double sum = 0;
  for (const Stage stage : {Stage::cull, Stage::raster, Stage::shading})
    sum += ms[static_cast<size_t>(stage)];
  return sum;
}

Result<StageTimes> stage_times(const gpu::FrameTimes& times) {
  StageTimes result;
  result.frame_ms = result.between_ms = times.total_ms;
  for (const gpu::PassTime& pass : times.passes) {
    const std::optional<Stage> stage = stage_of(pass.name);
    if (!stage) {
      return Error{
          std::string("the pass \"") + pass.name +
          "\" belongs to no stage of the report; give it one in tools/lab/bench/frames/frame_bench.cpp"};
    }
    result.ms[static_cast<size_t>(*stage)] += pass.milliseconds;
    if (pass.async_compute) {
      result.aside_ms += pass.milliseconds;
    } else {
      result.between_ms -= pass.milliseconds;
    }
  }
  return result;
}

namespace {

using fire3dv::monotonic_ns;

constexpr uint64_t kImagesBefore = 160;  // enough images to fill the panels' histories
constexpr int64_t kWarmUpNs = 150'000'000;
constexpr int64_t kPatienceNs = 30'000'000'000;  // hang limit of the wait for poses

double ms_since(int64_t begin_ns) {
  return static_cast<double>(monotonic_ns() - begin_ns) * 1e-6;
}

// Alternates whole-frame and per-pass timing. Of every eight frames, each mode covers two even and two odd
// ones, since targets are cleared every fourth frame.
gpu::Timed timed_in_turn(uint64_t frame) {
  return (frame + frame / 4) % 2 ? gpu::Timed::passes : gpu::Timed::frame;
}

passes::View first_camera_view(const scene::Scene& scene, VkExtent2D extent) {
  const float aspect = static_cast<float>(extent.width) / static_cast<float>(extent.height);
  const std::vector<uint32_t> cameras = scene::camera_nodes(scene);
  if (!cameras.empty()) {
    const scene::Node& node = scene.nodes[cameras[0]];
    return passes::make_view(scene.cameras[node.camera], node.world_from_node, aspect);
  }
  const scene::Camera camera;
  return passes::make_view(
      camera, passes::framing_camera_pose(camera, aspect, scene.bounds_min, scene.bounds_max), aspect);
}

}  // namespace

FrameBench::FrameBench(gpu::Device& device, const scene::Scene& scene, VkExtent2D extent)
    : device_(device),
      scene_(scene),
      extent_(extent),
      view_(first_camera_view(scene, extent)),
      poses_(scene),
      receiver_(poses_, false),
      frames_(device),
      readback_(device) {}

Result<std::unique_ptr<FrameBench>> FrameBench::open(gpu::Device& device, const scene::Scene& scene,
                                                     std::vector<std::string> bodies,
                                                     PoseFeed::PoseAt pose_at,
                                                     const settings::DrawSettings& settings,
                                                     VkExtent2D extent) {
  std::unique_ptr<FrameBench> bench(new FrameBench(device, scene, extent));
  const std::string uri = "shm://fire3dv-bench-" + std::to_string(::getpid());
  Result<std::unique_ptr<transport::ListenerLink>> listener = transport::open_listener(uri);
  if (!listener) return listener.error();
  bench->receiver_.add(std::move(*listener));
  Result<std::unique_ptr<PoseFeed>> feed = PoseFeed::open(uri, std::move(bodies), std::move(pose_at));
  if (!feed) return feed.error();
  bench->feed_ = std::move(*feed);

  const int64_t begin_ns = monotonic_ns();
  bench->renderer_.emplace(device, settings);
  bench->renderer_->set_scene(scene);
  if (Result<passes::PreparedFrame> prepared = bench->renderer_->prepare({.extent = extent}); !prepared)
    return prepared.error();
  bench->load_s_ = ms_since(begin_ns) * 1e-3;
  return bench;
}

void FrameBench::apply(const Condition& condition) {
  settings::DrawSettings settings = renderer_->settings().draw();
  settings.cull = condition.cull;
  settings.levels_of_detail = condition.levels_of_detail;
  if (!condition.shadows) settings.shadows.method = settings::ShadowMethod::off;
  settings.ray_effects.on = condition.ray_effects;
  renderer_->apply(settings);
}

Result<double> FrameBench::take_new_poses() {
  const uint64_t wanted = feed_->ask_for_next();
  const int64_t asked_ns = monotonic_ns();
  while (true) {
    const int64_t begin_ns = monotonic_ns();
    receiver_.poll();
    const double took_ms = ms_since(begin_ns);
    const std::vector<state::FrameTag> shown = poses_.shown();
    if (!shown.empty() && shown[0].sequence == wanted) return took_ms;
    if (begin_ns - asked_ns > kPatienceNs) {
      std::string notes;
      for (const std::string& note : receiver_.take_log_messages()) notes += "; " + note;
      return Error{"no poses came over shared memory in " + std::to_string(kPatienceNs / 1'000'000'000) +
                   " s" + notes + "; is /dev/shm full?"};
    }
    std::this_thread::yield();
  }
}

Result<uint64_t> FrameBench::submit_frame(gpu::Recorder& recorder, bool read_back) {
  const Result<passes::PreparedFrame> prepared = renderer_->prepare({.extent = extent_});
  if (!prepared) return prepared.error();
  renderer_->record(*prepared, recorder, frames_.staging(), poses_, view_);
  if (panels_) draw_panels(recorder);
  if (read_back) readback_.record(recorder, renderer_->image(), 0);
  const uint64_t done_at = frames_.submit();
  ++drawn_;
  readback_.submitted(done_at);
  return done_at;
}

void FrameBench::show_panels(float scale) {
  panels_ = std::make_unique<Panels>(device_);
  panels_->scale = scale;
  panels_->view_state.selected = 0;
  for (uint64_t i = 0; i < kImagesBefore; ++i) lay_out_panels(i);
}

const ImDrawData& FrameBench::lay_out_panels(uint64_t image) {
  const VkExtent2D extent = renderer_->extent();
  gui::Input input;
  input.display_px = {extent.width, extent.height};
  input.scale = panels_->scale;
  input.delta_s = 1.0f / 60;
  const gui::Facts facts = panel_facts(image, {extent.width, extent.height});
  return panels_->gui.frame(input, facts, {scene_, poses_}, panels_->view_state);
}

void FrameBench::draw_panels(gpu::Recorder& recorder) {
  const ImDrawData& laid_out = lay_out_panels(kImagesBefore + drawn_);
  panels_->pass.record(recorder, frames_.staging(), renderer_->image(), laid_out, panels_->gui.fonts(),
                       panels_->gui.fonts_number());
}

Result<void> FrameBench::time_frame(gpu::Timed timed, FrameSamples& samples) {
  frames_.time(timed);
  gpu::Recorder& recorder = frames_.begin();
  const Result<double> taking_ms = take_new_poses();
  if (!taking_ms) return taking_ms.error();
  const int64_t begin_ns = monotonic_ns();
  if (const Result<uint64_t> submitted = submit_frame(recorder, false); !submitted) return submitted.error();
  const int64_t submitted_ns = monotonic_ns();
  const int64_t interval_ns = submitted_ns - std::exchange(last_submit_ns_, submitted_ns);
  if (timed == gpu::Timed::passes) return {};
  samples.cpu_ms.push_back(*taking_ms + static_cast<double>(submitted_ns - begin_ns) * 1e-6);
  const auto published_ns = static_cast<int64_t>(poses_.shown().at(0).publish_time_ns);
  samples.pose_age_ms.push_back(static_cast<double>(submitted_ns - published_ns) * 1e-6);
  samples.interval_ms.push_back(static_cast<double>(interval_ns) * 1e-6);
  return {};
}

Result<FrameSamples> FrameBench::measure(const Condition& condition, uint32_t warm_up, uint32_t frames) {
  apply(condition);
  // An idle GPU needs time to reach its clock rate.
  const int64_t begin_ns = monotonic_ns();
  FrameSamples untimed;
  for (uint32_t i = 0; i < warm_up || monotonic_ns() - begin_ns < kWarmUpNs; ++i) {
    if (Result<void> drawn = time_frame(gpu::Timed::frame, untimed); !drawn) return drawn.error();
    frames_.take_finished();
  }

  FrameSamples samples;
  const uint64_t first_timed = drawn_;
  const auto collect = [&]() -> Result<void> {
    for (const gpu::FrameTimes& times : frames_.take_finished()) {
      if (times.frame_index < first_timed) continue;
      if (timed_in_turn(times.frame_index - first_timed) == gpu::Timed::frame) {
        samples.frame_ms.push_back(times.total_ms);
        continue;
      }
      Result<StageTimes> stages = stage_times(times);
      if (!stages) return stages.error();
      samples.stages.push_back(*stages);
    }
    return {};
  };
  for (uint32_t i = 0; i < 2 * frames; ++i) {
    if (Result<void> drawn = time_frame(timed_in_turn(i), samples); !drawn) return drawn.error();
    if (Result<void> collected = collect(); !collected) return collected.error();
  }
  device_.wait(device_.last_submitted());
  if (Result<void> collected = collect(); !collected) return collected.error();
  FIRE3DV_ASSERT(samples.frame_ms.size() == frames && samples.stages.size() == frames);
  samples.memory = memory_use(device_);
  return samples;
}

Result<sinks::FrameImage> FrameBench::draw(const Condition& condition) {
  apply(condition);
  gpu::Recorder& recorder = frames_.begin();
  if (const Result<double> taken = take_new_poses(); !taken) return taken.error();
  if (const Result<uint64_t> submitted = submit_frame(recorder, true); !submitted) return submitted.error();
  sinks::FrameImage image;
  readback_.drain([&](int, VkExtent2D extent, std::span<const uint8_t> rgba8) {
    image.width = extent.width;
    image.height = extent.height;
    image.rgba8.assign(rgba8.begin(), rgba8.end());
  });
  image.shown = poses_.shown();
  image.camera = view_.camera;
  return image;
}

Result<std::vector<double>> FrameBench::measure_images(const Condition& condition, uint32_t warm_up,
                                                       uint32_t frames) {
  std::vector<double> times_ms;
  for (uint32_t i = 0; i < warm_up + frames; ++i) {
    const int64_t begin_ns = monotonic_ns();
    if (const Result<sinks::FrameImage> image = draw(condition); !image) return image.error();
    if (i >= warm_up) times_ms.push_back(ms_since(begin_ns));
  }
  return times_ms;
}

}  // namespace fire3dv::bench
