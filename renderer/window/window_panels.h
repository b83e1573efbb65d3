// Panels of a window: input routing, layout and its persistence between runs, and the data that they display.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "renderer/gui/gui.h"
#include "renderer/gui/gui_pass.h"
#include "renderer/gui/panel_data.h"
#include "renderer/live_scene/live_scene.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/streams/stream_receiver.h"
#include "renderer/window/view_control.h"
#include "renderer/window/window.h"

namespace fire3dv::app {

// Conversion of window input to panel input. Panels spread events over frames; the view gets each event in
// the frame of the panels, so that a key acts on what the clicks before it have set.
class PanelInput {
 public:
  gui::Input convert(const sinks::WindowInput& input, glm::uvec2 window_px, float seconds);
  // Takes the events that the panels have seen by their last frame, without keys that a widget used.
  std::vector<sinks::InputEvent> take_seen(const gui::Gui& gui);

 private:
  sinks::Modifiers held_;  // modifier keys of the last event, valid until the next one
  std::deque<std::pair<sinks::InputEvent, uint64_t>> waiting_;  // with the converted events up to its own
  uint64_t converted_ = 0;                                      // events, of all calls
};

class WindowPanels {
 public:
  // first: loads the layout file, once per process. Later instances start from the view state.
  // light_panels: theme in place of the file's.
  WindowPanels(gpu::Device& device, ViewState& view_state, bool first, std::optional<bool> light_panels);
  ~WindowPanels();  // saves the layout if it changed
  WindowPanels(const WindowPanels&) = delete;
  WindowPanels& operator=(const WindowPanels&) = delete;

  // Lays out the panels. Replaces the events of the input by those of the view's frame, without keys that a
  // widget used. Returns false if panels use the mouse.
  bool take(sinks::Window& window, sinks::WindowInput& input, glm::uvec2 window_px, float seconds,
            const gui::Facts& facts, const gui::Shown& shown, ViewState& view_state);
  // Part of the window that the last layout left to the image.
  gui::Rect image_rect() const { return gui_.image_rect(); }
  // A drag or a text input goes on.
  bool is_interacting() const { return gui_.is_interacting(); }
  // Events wait for the next frame.
  bool has_waiting_events() const { return gui_.waiting_events() > 0; }
  // Draws the last layout and returns the content of the window: onto the image if it fills the window, else
  // onto a canvas of the window's size with the image at `at`.
  gpu::Image& record(gpu::Recorder& recorder, gpu::StagingRing& staging, gpu::Image& image, glm::uvec2 at,
                     VkExtent2D window);

  std::vector<std::string> take_log_messages() { return std::exchange(notes_, {}); }

 private:
  void copy_to_canvas(gpu::Recorder& recorder, gpu::Image& image, glm::uvec2 at, VkExtent2D window);

  std::vector<std::string> notes_;
  std::optional<std::filesystem::path> file_;
  gui::Layout saved_;
  gui::Gui gui_;
  gui::GuiPass pass_;
  gpu::Device& device_;
  gpu::Image canvas_;  // of the window's size; created when needed
  PanelInput input_;
  const ImDrawData* laid_out_ = nullptr;
};

// Collector of the data that the window's panels display, once per image.
class PanelFacts {
 public:
  explicit PanelFacts(std::chrono::steady_clock::time_point begun) : begun_(begun) {}

  // Call as events occur.
  void note(const std::string& sentence);
  // frame_ms: since the previous image; cpu_ms: of recording and submission.
  void drawn(uint64_t images, double frame_ms, double cpu_ms, std::optional<double> pose_age_ms);
  void add(const gpu::FrameTimes& times);

  // scene: the renderer's scene, with a unique scene_number. camera_node: kNone for a free camera.
  const gui::Facts& begin_assembly(const scene::Scene& scene, uint64_t scene_number,
                                   const StreamReceiver& receiver, const state::PoseState& poses,
                                   const state::MarkerRegistry& markers,
                                   const passes::SceneRenderer& renderer, const gpu::Device& device,
                                   uint32_t camera_node, bool recording_video);

 private:
  struct Rate {
    uint64_t sequence = 0;
    std::chrono::steady_clock::time_point since;
    double hz = 0;
    bool is_known = false;
  };
  void set_scene(const scene::Scene& scene, uint64_t scene_number, const passes::SceneRenderer& renderer);
  gui::StreamFact stream_fact(const StreamReceiver::Report& report, const StreamReceiver& receiver,
                              const state::PoseState& poses, const state::MarkerRegistry& markers);
  double rate_of(uint64_t epoch, uint64_t sequence);

  const std::chrono::steady_clock::time_point begun_;
  gui::Facts facts_;
  std::map<uint64_t, Rate> rates_;  // by epoch
  std::chrono::steady_clock::time_point memory_read_at_{};
  std::vector<uint32_t> cameras_;  // camera nodes of scene cameras_of_
  std::optional<uint64_t> cameras_of_;
  std::optional<std::pair<uint64_t, uint64_t>> counted_;  // scene and draw list of the counted triangles
};

}  // namespace fire3dv::app
