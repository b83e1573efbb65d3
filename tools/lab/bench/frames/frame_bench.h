// Frame time measurement of one scene, by stage. Each frame receives new poses from a publisher thread over
// the wire to the GPU.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "base/error.h"
#include "protocol/transport/link.h"
#include "protocol/wire/messages.h"
#include "renderer/gpu/device/device.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/readback_ring.h"
#include "renderer/gui/gui.h"
#include "renderer/gui/gui_pass.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/sinks/frame.h"
#include "renderer/streams/stream_receiver.h"
#include "tools/lab/bench/bench_device.h"

namespace fire3dv::bench {

// Publisher thread that sends poses of one step per request over shared memory.
class PoseFeed {
 public:
  // pose_at: fills the poses of a step, one per name. Called on the feed's thread.
  using PoseAt = std::function<void(uint64_t step, std::vector<wire::Affine3x4>& poses)>;
  static Result<std::unique_ptr<PoseFeed>> open(const std::string& uri, std::vector<std::string> names,
                                                PoseAt pose_at);
  ~PoseFeed();
  PoseFeed(const PoseFeed&) = delete;
  PoseFeed& operator=(const PoseFeed&) = delete;

  // Requests the next step without blocking. Returns its sequence, from 1.
  uint64_t ask_for_next();

 private:
  PoseFeed() = default;
  void work();

  std::unique_ptr<transport::PublisherLink> link_;
  PoseAt pose_at_;
  uint64_t epoch_ = 0;
  uint32_t count_ = 0;
  std::atomic<uint64_t> wanted_ = 0;
  std::thread thread_;  // last, since it uses all members above
};

// Stages of the report. tlas_wait: time that the graphics queue waits for the async compute queue.
enum class Stage : uint8_t {
  poses,
  tlas,
  tlas_wait,
  cull,
  raster,
  shadow,
  rays,
  shading,
  post,
  gui,
  readback
};
constexpr size_t kStages = 11;
const char* stage_name(Stage stage);

// Maps a render pass to its stage. An unknown pass is an error, so that no time is lost.
std::optional<Stage> stage_of(std::string_view pass);

struct StageTimes {
  std::array<double, kStages> ms{};
  double aside_ms = 0;          // stage time on the async compute queue, overlapped with other stages
  double between_ms = 0;        // frame time on the graphics queue outside all passes: barriers
  double frame_ms = 0;          // from the start of the first pass to the end of the last one
  double main_pass_ms() const;  // cull, raster and shading
};
Result<StageTimes> stage_times(const gpu::FrameTimes& times);

// Settings of a row of the report.
struct Condition {
  const char* name;
  settings::Cull cull;
  bool shadows;
  settings::LevelsOfDetail levels_of_detail;
  settings::RayEffects ray_effects = {};
};

// Samples of a run. Whole-frame and per-pass timing alternate, since per-pass timing slows frames slightly;
// both have the same count.
struct FrameSamples {
  std::vector<double> frame_ms;     // GPU time of whole frames
  std::vector<StageTimes> stages;   // per-pass timed frames; all further members belong to whole frames
  std::vector<double> cpu_ms;       // CPU time of poses, recording and submission, without waits
  std::vector<double> pose_age_ms;  // from the publisher's call to the frame's submission
  std::vector<double> interval_ms;  // between submissions
  MemoryUse memory;
};

class FrameBench {
 public:
  // Borrows the scene. bodies: names of moving nodes.
  static Result<std::unique_ptr<FrameBench>> open(gpu::Device& device, const scene::Scene& scene,
                                                  std::vector<std::string> bodies, PoseFeed::PoseAt pose_at,
                                                  const settings::DrawSettings& settings, VkExtent2D extent);

  // Measures after at least warm_up frames and the time that a GPU needs to reach its clock rate.
  Result<FrameSamples> measure(const Condition& condition, uint32_t warm_up, uint32_t frames);
  // Renders one more frame and returns its image.
  Result<sinks::FrameImage> draw(const Condition& condition);
  // Returns times from the request of new poses to the image in host memory, in milliseconds.
  Result<std::vector<double>> measure_images(const Condition& condition, uint32_t warm_up, uint32_t frames);

  // Draws panels of this scale over the images from now on.
  void show_panels(float scale);

  passes::SceneRenderer& renderer() { return *renderer_; }
  double load_s() const { return load_s_; }  // from the scene in memory to the scene on the GPU

 private:
  FrameBench(gpu::Device& device, const scene::Scene& scene, VkExtent2D extent);
  void apply(const Condition& condition);
  // Moves unseen poses into the pose state. Returns the time it took, without waits.
  Result<double> take_new_poses();
  Result<void> time_frame(gpu::Timed timed, FrameSamples& samples);  // all times except the GPU's
  Result<uint64_t> submit_frame(gpu::Recorder& recorder, bool read_back);

  const ImDrawData& lay_out_panels(uint64_t image);
  void draw_panels(gpu::Recorder& recorder);

  gpu::Device& device_;
  const scene::Scene& scene_;
  const VkExtent2D extent_;
  passes::View view_;
  state::PoseState poses_;
  app::StreamReceiver receiver_;
  std::unique_ptr<PoseFeed> feed_;
  gpu::FrameRing frames_;
  std::optional<passes::SceneRenderer> renderer_;
  gpu::ReadbackRing<int> readback_;
  struct Panels {
    explicit Panels(gpu::Device& device) : pass(device) {}
    gui::Gui gui;
    gui::GuiPass pass;
    app::ViewState view_state;
    float scale = 1;
  };
  std::unique_ptr<Panels> panels_;  // null: no panels
  uint64_t drawn_ = 0;              // also the index of the next frame
  int64_t last_submit_ns_ = 0;
  double load_s_ = 0;
};

}  // namespace fire3dv::bench
