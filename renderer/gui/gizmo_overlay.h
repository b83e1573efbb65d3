// Manipulator of the selected node, over the image: draws the gizmo, and turns drags of its handles into the
// node's transform (ViewState::transforms). A node that a stream drives has no handles: the overlay names the
// stream instead.
#pragma once

#include <string>

#include "renderer/gui/gizmo.h"
#include "renderer/gui/gui.h"

namespace fire3dv::gui {

struct Context;

// Transform relative to its parent as shown now: the user's, else that of the pose.
state::NodeTransform shown_transform(const Shown& shown, const app::ViewState& view_state, uint32_t node);

class GizmoOverlay {
 public:
  // Call once per frame after the panels are laid out, with the rectangle of the image.
  // cursor_px: of the mouse, not rounded as ImGui's.
  void frame(const Context& context, const Rect& image, const glm::vec2& cursor_px);
  // The mouse is over a handle or drags it.
  bool takes_mouse() const { return takes_mouse_; }
  bool is_dragging() const { return gizmo_.is_dragging(); }

 private:
  bool follow_drag(const Context& context, const GizmoView& view, const glm::vec2& cursor_px);
  void draw(const Context& context, const Rect& image, std::optional<size_t> hovered) const;
  void draw_note(const Context& context, const Rect& image, const glm::vec2& at,
                 const std::string& text) const;

  Gizmo gizmo_;
  uint32_t node_ = scene::kNone;  // of the drag
  uint64_t scene_number_ = 0;
  bool takes_mouse_ = false;
};

}  // namespace fire3dv::gui
