// What there is only with a window: the user's input and what follows from it, the image on the display,
// pictures that are taken of it. The frame loop draws; this says from where, and does the rest.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "renderer/app/camera_rig.h"
#include "renderer/app/camera_window.h"
#include "renderer/app/captures.h"
#include "renderer/app/live_scene.h"
#include "renderer/app/options.h"
#include "renderer/app/stream_intake.h"
#include "renderer/app/viewer_input.h"
#include "renderer/app/window_panels.h"
#include "renderer/gui/viewer.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/sinks/window.h"

namespace fire3dv::app {

struct OpenWindow {
  std::unique_ptr<sinks::Window> window;
  std::string camera;  // as the options name it; empty: they do not
};
using Windows = std::vector<OpenWindow>;

class WindowView {
 public:
  // All is borrowed. camera is that of the first window; the others' are as the options say. windows: at
  // least one; those that the user closes are taken out.
  struct Borrowed {
    gpu::Device& device;
    std::optional<passes::SceneRenderer>& renderer;  // there is one
    state::PoseState& poses;
    StreamIntake& intake;
    LiveScene& scene;
    CameraRig& camera;
    Windows& windows;
    gui::Viewer& viewer;
    const Options& options;
    bool insist = true;  // on the cameras that the options name; else others are shown where there are none
  };
  // The error says which camera there is not.
  static Result<std::unique_ptr<WindowView>> create(const Borrowed& borrowed);
  WindowView(const WindowView&) = delete;
  WindowView& operator=(const WindowView&) = delete;

  // What the user has done, on cameras and the scene. facts: for panels. timeline: null where nothing is
  // replayed.
  void steer(const gui::Facts& facts, replay::TimelineControl* timeline);
  bool should_close() const { return closing_ || first().should_close(); }
  std::optional<std::filesystem::path> take_opened() { return std::exchange(opened_, std::nullopt); }
  // Sentences for the user since the last call.
  std::vector<std::string> take_notes();

  bool records_video() const { return captures_.records_video(); }

  VkExtent2D image_extent() const { return image_extent_; }  // of each image in the first window
  bool acquire() { return first().acquire(); }               // false: nothing can be shown now
  static void wait_events(double timeout_s) { sinks::Window::wait_events(timeout_s); }

  // Of the window's next image.
  passes::Inspection take_inspection();
  // Behind the passes of the window's image: to where it is looked at. Draws what else the window shows.
  void record(gpu::Recorder& recorder, gpu::UploadBelt& belt, Captures::Tag shown);
  std::array<gpu::SemaphoreSignal, 1> waits() const { return first().waits(); }
  std::array<gpu::SemaphoreSignal, 1> signals() const { return first().signals(); }
  void present(uint64_t timeline_value);
  void draw_others();  // the other windows, each in a submission of its own
  void deliver();      // pictures to files, and what was clicked
  void finish() { captures_.finish(); }

 private:
  explicit WindowView(const Borrowed& borrowed);
  sinks::Window& first() const { return *borrowed_.windows.front().window; }
  uint32_t columns() const { return right_camera_ ? 2 : 1; }
  void steer_first(float seconds, const gui::Facts& facts, replay::TimelineControl* timeline);
  void measure();
  void do_wishes();
  void draw_as_wished();
  passes::SceneRenderer& renderer() { return *borrowed_.renderer; }

  const Borrowed borrowed_;
  ViewerInput input_;
  std::optional<CameraRig> right_camera_;  // of the second image in the first window
  std::vector<std::unique_ptr<CameraWindow>> others_;
  Captures captures_;
  std::optional<WindowPanels> panels_;
  VkExtent2D image_extent_{};
  std::optional<glm::vec2> clicked_px_, clicked_right_px_;
  passes::DrawSettings drawn_;  // as they could be had last
  bool closing_ = false;
  std::vector<std::string> notes_;
  std::optional<std::filesystem::path> opened_;
  std::chrono::steady_clock::time_point steered_ = std::chrono::steady_clock::now();
};

}  // namespace fire3dv::app
