// Panels beside the image. They read facts, scene and poses, and write the user's requests (ViewState).
// Independent of window and GPU: the output is a draw list for gui_pass.h.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "protocol/replay/replay_clock.h"
#include "renderer/editing/view_state.h"
#include "renderer/gui/input.h"
#include "renderer/gui/layout_file.h"
#include "renderer/gui/panel_data.h"
#include "renderer/passes/view/view.h"
#include "renderer/scene/model/scene_edits.h"
#include "renderer/state/pose_state.h"

struct ImDrawData;
struct ImFontAtlas;

namespace fire3dv::gui {

// Displayed objects, borrowed for one frame.
struct Shown {
  const scene::Scene& scene;
  const state::PoseState& poses;
  const scene::SceneEdits* edits = nullptr;                   // null: none
  uint64_t scene_number = 0;                                  // unique per scene
  replay::TimelineControl* timeline = nullptr;                // null: neither a replay nor animations
  const state::RobotPose* robot = nullptr;                    // null: the file holds none
  std::span<const std::filesystem::path> recent_files = {};   // the shown one first
  const app::EditFacts* editing = nullptr;                    // null: nobody records edits
  std::function<passes::View(float image_aspect)> view = {};  // of the image; null: no gizmo is drawn
  std::span<const state::StreamId> controlled_streams = {};   // whose declared inputs can be used
};

// Rectangle in image pixels.
struct Rect {
  glm::vec2 low{0}, high{0};
};

// Interactive widget of a panel, as laid out in the last frame. For tests.
struct Control {
  enum class Kind : uint8_t { button, check, slider, choice, color, text, row, header, edge, number };
  Kind kind = Kind::button;
  std::string panel, name;
  Rect rect;
  bool enabled = true;
};

class Gui {
 public:
  struct Clipboard {
    std::function<std::string()> get;
    std::function<void(const std::string&)> set;
  };
  explicit Gui(const Layout& layout = {}, Clipboard clipboard = {});
  ~Gui();
  Gui(const Gui&) = delete;
  Gui& operator=(const Gui&) = delete;

  // Processes the input and lays out the panels; call once per frame, before the camera moves. The list is
  // valid until the next call. With ViewState::gui off, draws only the help and captures no input.
  const ImDrawData& frame(const Input& input, const Facts& facts, const Shown& shown,
                          app::ViewState& view_state);

  // Input capture in the last frame: mouse over or held by a panel; keys used as text. A click that began on
  // the image is never captured.
  bool wants_mouse() const;
  bool wants_keyboard() const;
  // Of each key event that the last frame processed, in order: whether a widget used it. Later events follow
  // in the next frames. Nobody else acts on a used key.
  std::vector<bool> key_uses() const;
  // A drag or a text input went on in the last frame: changes meanwhile are one step.
  bool is_interacting() const;
  // Events that wait for one of the next frames: a press and its release, for example, need one each.
  size_t waiting_events() const;
  Cursor cursor() const;
  // Part of the window that no panel covers, in whole pixels: the image belongs there. Empty in a window of a
  // few pixels. Help, popups and tooltips may lie over it.
  Rect image_rect() const;

  const Layout& layout() const { return layout_; }
  const ImFontAtlas& fonts() const;
  uint64_t fonts_number() const { return fonts_number_; }  // changes with the fonts

  void note_controls(bool on);
  const std::vector<Control>& controls() const;
  uint32_t tree_rows() const;  // rows of the scene tree laid out in the last frame

 private:
  struct Panels;
  Layout layout_;
  Clipboard clipboard_;
  std::unique_ptr<Panels> panels_;
  uint64_t fonts_number_ = 0;
};

}  // namespace fire3dv::gui
