// Measures frames of one scene: new poses for each, from a simulator's thread over the wire to the GPU.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "renderer/app/stream_intake.h"
#include "renderer/gpu/device.h"
#include "renderer/gui/gui.h"
#include "renderer/gui/gui_pass.h"
#include "renderer/passes/readback_belt.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/sinks/frame.h"
#include "tools/bench/memory_use.h"
#include "tools/bench/pose_feed.h"
#include "tools/bench/stages.h"

namespace fire3dv::bench {

// What a row of the report is measured under.
struct Condition {
  const char* name;
  passes::Cull cull;
  bool shadows;
  passes::LevelsOfDetail levels_of_detail;
};

// Frames are timed as a whole and, by turns, pass by pass, which makes them a little slower. So many of both.
struct FrameSamples {
  std::vector<double> frame_ms;     // of the GPU, of the first
  std::vector<StageTimes> stages;   // of the others; all that follows is of the first
  std::vector<double> cpu_ms;       // taking the poses, recording and submitting; not waiting
  std::vector<double> pose_age_ms;  // from the publisher's call to the frame's submission
  std::vector<double> interval_ms;  // from one submission to the next
  MemoryUse memory;
};

class FrameBench {
 public:
  // The scene is borrowed. bodies: names of the nodes that move.
  static Result<std::unique_ptr<FrameBench>> open(gpu::Device& device, const scene::Scene& scene,
                                                  std::vector<std::string> bodies, PoseFeed::PoseAt pose_at,
                                                  const passes::DrawSettings& settings, VkExtent2D extent);

  // After at least warm_up frames, and a time that a GPU's clock needs.
  Result<FrameSamples> measure(const Condition& condition, uint32_t warm_up, uint32_t frames);
  // One more frame, as the image that it makes.
  Result<sinks::FrameImage> draw(const Condition& condition);
  // The same, over and over: from the request of new poses to the image in this process's memory, in
  // milliseconds.
  Result<std::vector<double>> measure_images(const Condition& condition, uint32_t warm_up, uint32_t frames);

  // From now on with panels over the images, of this scale.
  void show_panels(float scale);

  passes::SceneRenderer& renderer() { return *renderer_; }
  double load_s() const { return load_s_; }  // from the scene in memory to the scene on the GPU

 private:
  FrameBench(gpu::Device& device, const scene::Scene& scene, VkExtent2D extent);
  void apply(const Condition& condition);
  // Poses nobody has seen, in the pose state; the time that taking them has cost, without waiting for them.
  Result<double> take_new_poses();
  Result<void> time_frame(gpu::Timed timed, FrameSamples& samples);  // all but the GPU's times
  uint64_t submit_frame(gpu::Recorder& recorder, bool read_back);

  const ImDrawData& lay_out_panels(uint64_t image);
  void draw_panels(gpu::Recorder& recorder);

  gpu::Device& device_;
  const scene::Scene& scene_;
  passes::View view_;
  state::PoseState poses_;
  app::StreamIntake intake_;
  std::unique_ptr<PoseFeed> feed_;
  gpu::FrameRing frames_;
  std::optional<passes::SceneRenderer> renderer_;
  passes::ReadbackBelt<int> readback_;
  struct Panels {
    explicit Panels(gpu::Device& device) : pass(device) {}
    gui::Gui gui;
    gui::GuiPass pass;
    gui::Viewer viewer;
    float scale = 1;
  };
  std::unique_ptr<Panels> panels_;  // null: none are drawn
  uint64_t drawn_ = 0;              // which is the index of the frame to come
  int64_t last_submit_ns_ = 0;
  double load_s_ = 0;
};

}  // namespace fire3dv::bench
