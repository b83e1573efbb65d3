// The panels over the image. They read facts, the scene and its poses, and write what the user wants
// (viewer.h); they know neither a window nor a GPU: what is to be drawn is a list that gui_pass.h draws.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "protocol/replay/timeline.h"
#include "renderer/gui/facts.h"
#include "renderer/gui/input.h"
#include "renderer/gui/layout_file.h"
#include "renderer/gui/viewer.h"
#include "renderer/scene/scene_edits.h"
#include "renderer/state/pose_state.h"

struct ImDrawData;
struct ImFontAtlas;

namespace fire3dv::gui {

// What is shown, borrowed for one frame.
struct Shown {
  const scene::Scene& scene;
  const state::PoseState& poses;
  const scene::SceneEdits* edits = nullptr;     // null: none
  uint64_t scene_number = 0;                    // another one for another scene
  replay::TimelineControl* timeline = nullptr;  // null: nothing is replayed
};

// Pixels of the image.
struct Rect {
  glm::vec2 low{0}, high{0};
};

// Something of a panel that the user can act on, as it was laid out in the last frame. For tests.
struct Control {
  enum class Kind : uint8_t { button, check, slider, choice, color, text, row, header, edge };
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

  // Once a frame, before the camera is moved: takes the input and lays out the panels. The list is valid
  // until the next call. Viewer::gui off: nothing but the help is drawn, and no input is wanted.
  const ImDrawData& frame(const Input& input, const Facts& facts, const Shown& shown, Viewer& viewer);

  // Of the last frame: whether the mouse is over a panel or held by one, and whether keys are text. A click
  // that began on the image is not wanted, wherever it ends.
  bool wants_mouse() const;
  bool wants_keyboard() const;
  Cursor cursor() const;
  Rect image_rect() const;  // what panels leave of the image

  const Layout& layout() const { return layout_; }
  const ImFontAtlas& fonts() const;
  uint64_t fonts_number() const { return fonts_number_; }  // another one for other fonts

  void note_controls(bool on);
  const std::vector<Control>& controls() const;
  uint32_t tree_rows() const;  // of the scene tree, that were laid out in the last frame

 private:
  struct Panels;
  Layout layout_;
  Clipboard clipboard_;
  std::unique_ptr<Panels> panels_;
  uint64_t fonts_number_ = 0;
};

}  // namespace fire3dv::gui
