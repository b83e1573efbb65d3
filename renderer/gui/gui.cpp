#include "renderer/gui/gui.h"

#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "renderer/gui/docks.h"
#include "renderer/gui/gizmo_overlay.h"
#include "renderer/gui/input.h"
#include "renderer/gui/panels.h"

namespace fire3dv::gui {
namespace {

constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                    ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                                    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus;
constexpr float kLeastTreePt = 140;

Cursor cursor_of(ImGuiMouseCursor cursor) {
  switch (cursor) {
    case ImGuiMouseCursor_TextInput:
      return Cursor::text;
    case ImGuiMouseCursor_ResizeEW:
      return Cursor::resize_horizontal;
    case ImGuiMouseCursor_ResizeNS:
      return Cursor::resize_vertical;
    case ImGuiMouseCursor_Hand:
      return Cursor::hand;
    default:
      return Cursor::arrow;
  }
}

}  // namespace

struct Gui::Panels {
  ImGuiContext* context = nullptr;
  Ui ui;
  float scale = 0;  // scale of the built fonts
  bool is_light = false;
  std::deque<Event> waiting;
  glm::vec2 cursor_px{-1};  // ImGui rounds its own
  std::string clipboard;    // last text returned to ImGui, which keeps the pointer
  Cursor cursor = Cursor::arrow;
  bool wants_mouse = false, is_interacting = false;
  bool wants_text = false, is_widget_active = false;  // after the last frame
  bool closes_popup = false;
  std::array<bool, static_cast<size_t>(Key::count)> key_changed{};
  std::vector<bool> key_uses;  // of the keys that this frame processes
  Rect image_rect;
  float left_rest_px = 0;    // height of the left column without the tree
  float bottom_rest_px = 0;  // height of the bottom row without the lines of the log; 0: unknown

  ControlsPanel controls;
  FramePanel frame;
  StreamsPanel streams;
  PlotsPanel plots;
  TreePanel tree;
  CamerasPanel cameras;
  MaterialsPanel materials;
  LightsPanel lights;
  LogPanel log;
  GizmoOverlay gizmo;

  ~Panels() { ImGui::DestroyContext(context); }
  void take_events(ImGuiIO& io);
  bool take_key(ImGuiIO& io, const KeyChanged& key, std::optional<HeldKeys>& held);
  bool owns_keys() const;
  void lay_out(const Context& context);
  static bool begin_dock(const char* name, const DockAreas::Area& area, int flags);
  float bottom_px(const Context& context) const;
  void splitters(const Context& context, const DockAreas& areas);
};

Gui::Gui(const Layout& layout, Clipboard clipboard)
    : layout_(layout), clipboard_(std::move(clipboard)), panels_(std::make_unique<Panels>()) {
  IMGUI_CHECKVERSION();
  panels_->context = ImGui::CreateContext();
  ImGui::SetCurrentContext(panels_->context);
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = io.LogFilename = nullptr;  // settings are persisted by layout_file.h
  // Draw lists may exceed 16-bit vertex indices: GuiTiles supports vertex offsets.
  io.BackendFlags |= ImGuiBackendFlags_HasMouseCursors | ImGuiBackendFlags_RendererHasVtxOffset;
  set_up_keys(io);
  io.ClipboardUserData = this;
  io.GetClipboardTextFn = [](void* user) -> const char* {
    Gui& self = *static_cast<Gui*>(user);
    self.panels_->clipboard = self.clipboard_.get ? self.clipboard_.get() : std::string();
    return self.panels_->clipboard.c_str();
  };
  io.SetClipboardTextFn = [](void* user, const char* text) {
    const Gui& self = *static_cast<Gui*>(user);
    if (self.clipboard_.set) self.clipboard_.set(text);
  };
}

Gui::~Gui() = default;

// Spreads events over frames, since ImGui sees only the state per frame. A press and its release, or a press
// and a later move, need separate frames. A press also waits for the frame after the move to its position:
// ImGui 1.90 ignores it on rows that were not hovered in the previous frame. A release waits likewise: it
// would end a drag before the last move. Keys and text wait for the frame after a press, which may activate a
// text field, and for the frame after a key with other modifiers.
void Gui::Panels::take_events(ImGuiIO& io) {
  bool mouse_moved = false, button_changed = false;
  std::optional<HeldKeys> held;
  key_uses.clear();
  key_changed = {};
  closes_popup = false;
  while (!waiting.empty()) {
    const Event& event = waiting.front();
    if (const auto* moved = std::get_if<MouseMoved>(&event)) {
      if (button_changed) return;
      const ImVec2 to{moved->at_px.x, moved->at_px.y};
      cursor_px = moved->at_px;
      mouse_moved |= to.x != io.MousePos.x || to.y != io.MousePos.y;
      io.MousePos = to;
    } else if (const auto* button = std::get_if<MouseButton>(&event)) {
      if (button_changed || mouse_moved || (held && *held != button->held)) return;
      held = button->held;
      set_modifiers(io, *held);
      io.MouseDown[static_cast<size_t>(button->button)] = button->down;
      button_changed = true;
    } else if (const auto* wheel = std::get_if<MouseWheel>(&event)) {
      io.MouseWheelH += wheel->steps.x;
      io.MouseWheel += wheel->steps.y;
    } else if (const auto* key = std::get_if<KeyChanged>(&event)) {
      if (button_changed || closes_popup || !take_key(io, *key, held)) return;
    } else if (const auto* text = std::get_if<Text>(&event)) {
      if (button_changed || closes_popup) return;
      io.AddInputCharacter(text->character);
    } else {
      io.MousePos = {-FLT_MAX, -FLT_MAX};
    }
    waiting.pop_front();
  }
}

// Text fields, open lists and pickers, and widgets that the mouse holds.
bool Gui::Panels::owns_keys() const {
  return wants_text || context->OpenPopupStack.Size > 0 || is_widget_active;
}

// False: the key waits for the next frame. ImGui repeats held keys itself.
bool Gui::Panels::take_key(ImGuiIO& io, const KeyChanged& key, std::optional<HeldKeys>& held) {
  const bool is_used = key.down && owns_keys();
  const bool is_seen = key.key < Key::count && !key.repeated && (is_used || !key.down);
  if (is_seen) {
    bool& is_changed = key_changed[static_cast<size_t>(key.key)];
    if (is_changed || (is_used && held && *held != key.held)) return false;
    is_changed = true;
    if (is_used) {
      held = key.held;
      set_modifiers(io, *held);
    }
    set_key(io, key.key, key.down);
    closes_popup = is_used && key.key == Key::escape && !wants_text && context->OpenPopupStack.Size > 0;
  }
  key_uses.push_back(is_used);
  return true;
}

const ImDrawData& Gui::frame(const Input& input, const Facts& facts, const Shown& shown,
                             app::ViewState& view_state) {
  Panels& panels = *panels_;
  ImGui::SetCurrentContext(panels.context);
  ImGuiIO& io = ImGui::GetIO();
  const float wanted = std::isfinite(input.scale) ? input.scale : 1.0f;
  const float scale = std::clamp(std::round(wanted * 4) / 4, 0.5f, 4.0f);
  if (panels.scale != scale || panels.is_light != layout_.is_light) {
    panels.is_light = layout_.is_light;
    apply_theme(scale, panels.is_light);
  }
  if (panels.scale != scale) {
    panels.scale = scale;
    make_fonts(*io.Fonts, scale);
    ++fonts_number_;
  }
  io.DisplaySize = {std::max(input.display_px.x, 1.0f), std::max(input.display_px.y, 1.0f)};
  constexpr float kLeastDeltaS = 1e-4f;  // ImGui rejects a time step of 0
  io.DeltaTime = std::max(input.delta_s, kLeastDeltaS);
  set_modifiers(io, input.held);
  panels.waiting.insert(panels.waiting.end(), input.events.begin(), input.events.end());
  panels.take_events(io);
  ImGui::NewFrame();
  if (panels.closes_popup) ImGui::ClosePopupToLevel(panels.context->OpenPopupStack.Size - 1, true);
  panels.ui.begin_frame(scale);

  const Context context{panels.ui, facts, shown, view_state, layout_};
  panels.frame.note(facts.frame);
  panels.image_rect = {{0, 0}, input.display_px};
  if (view_state.gui) panels.lay_out(context);
  panels.gizmo.frame(context, panels.image_rect, panels.cursor_px);
  draw_help(context);
  draw_notice(context, panels.image_rect);
  draw_recovery(context, panels.image_rect);

  ImGui::Render();
  panels.wants_mouse = io.WantCaptureMouse || panels.gizmo.takes_mouse();
  panels.wants_text = panels.context->WantTextInputNextFrame == 1;
  panels.is_widget_active = ImGui::IsAnyItemActive();
  panels.is_interacting = panels.is_widget_active || panels.gizmo.is_dragging();
  panels.cursor = cursor_of(ImGui::GetMouseCursor());
  layout_.camera_speed = view_state.camera_speed;  // keys change it as well
  return *ImGui::GetDrawData();
}

void Gui::Panels::lay_out(const Context& c) {
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const DockAreas areas = dock_areas({display.x, display.y}, ui.scale, c.layout, bottom_px(c));
  if (begin_dock("left", areas.left, kFixed)) {
    const float top = ImGui::GetCursorPosY();
    const float room = ImGui::GetContentRegionAvail().y - left_rest_px;
    const float tree_height = std::max(std::floor(room), ui.points(kLeastTreePt));
    tree.draw(c, tree_height);
    draw_node_panel(c);
    draw_edit_panel(c);
    controls.draw(c);
    draw_joints_panel(c);
    draw_measure_panel(c);
    cameras.draw(c);
    const bool tree_is_open = c.layout.is_open(Panel::tree);
    if (tree_is_open) left_rest_px = ImGui::GetCursorPosY() - top - tree_height;
    ImGui::End();
  }
  const int held_scroll = plots.takes_wheel() ? ImGuiWindowFlags_NoScrollWithMouse : 0;
  if (begin_dock("right", areas.right, kFixed | held_scroll)) {
    frame.draw(c);
    streams.draw(c);
    draw_render_panel(c);
    lights.draw(c);
    materials.draw(c);
    plots.draw(c);
    ImGui::End();
  }
  if (begin_dock("bottom", areas.bottom, kFixed)) {
    const float top = ImGui::GetCursorPosY();
    draw_timeline_panel(c);
    log.draw(c);
    bottom_rest_px = ImGui::GetCursorPosY() - top - log.lines_px() + 2 * ImGui::GetStyle().WindowPadding.y;
    ImGui::End();
  }
  splitters(c, areas);
  image_rect = areas.image;
}

// A folded dock has no window. The caller ends the window if this returns true.
bool Gui::Panels::begin_dock(const char* name, const DockAreas::Area& area, int flags) {
  const glm::vec2 size = area.panels.high - area.panels.low;
  if (size.x < 1 || size.y < 1) return false;  // ImGui would replace a size of 0 by its own choice
  ImGui::SetNextWindowPos({area.panels.low.x, area.panels.low.y});
  ImGui::SetNextWindowSize({size.x, size.y});
  ImGui::Begin(name, nullptr, flags);
  return true;
}

// Height that the bottom row needs: of the last frame, except the log, which the user sizes.
float Gui::Panels::bottom_px(const Context& c) const {
  const float header = ImGui::GetTextLineHeight() + ui.points(9) + 2 * ImGui::GetStyle().ItemSpacing.y;
  const float first_guess = 2 * ImGui::GetStyle().WindowPadding.y + header;
  const float rest = bottom_rest_px > 0 ? bottom_rest_px : first_guess;
  return rest + (c.layout.is_open(Panel::log) ? ui.points(c.layout.log_pt) : 0);
}

void Gui::Panels::splitters(const Context& c, const DockAreas& areas) {
  constexpr ImGuiWindowFlags kFlags = kFixed | ImGuiWindowFlags_NoScrollbar |
                                      ImGuiWindowFlags_NoScrollWithMouse |
                                      ImGuiWindowFlags_NoFocusOnAppearing;
  const auto use = [&](Dock dock, const Ui::Splitter& splitter, const Rect& rect) {
    const glm::vec2 size = rect.high - rect.low;
    if (size.x < 1 || size.y < 1) return 0.0f;
    ImGui::SetNextWindowPos({rect.low.x, rect.low.y});
    ImGui::SetNextWindowSize({size.x, size.y});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
    Ui::SplitterUse used;
    if (ImGui::Begin(splitter.name, nullptr, kFlags)) {
      ui.enter("Window");
      used = ui.splitter(splitter, rect, c.layout.is_folded(dock));
    }
    ImGui::End();
    ImGui::PopStyleVar();
    if (used.toggled) c.layout.is_folded(dock) = !c.layout.is_folded(dock);
    return used.moved_px / ui.scale;
  };
  // In a small window docks are smaller than their setting: a drag starts from what is seen.
  Layout& l = c.layout;
  const auto points_of = [&](float low_px, float high_px) { return (high_px - low_px) / ui.scale; };
  const float of_left =
      use(Dock::left,
          {"edge of the left column", "Fold the left column", "Unfold the left column", ImGuiDir_Left},
          areas.left.splitter);
  if (of_left != 0)
    l.left_pt = std::clamp(points_of(0, areas.image.low.x) + of_left, kLeastColumnPt, kMaxColumnPt);
  const float of_right =
      use(Dock::right,
          {"edge of the right column", "Fold the right column", "Unfold the right column", ImGuiDir_Right},
          areas.right.splitter);
  if (of_right != 0) {
    l.right_pt = std::clamp(points_of(areas.image.high.x, ImGui::GetIO().DisplaySize.x) - of_right,
                            kLeastColumnPt, kMaxColumnPt);
  }
  const float of_log = use(Dock::bottom, {"edge of the log", "Fold the log", "Unfold the log", ImGuiDir_Down},
                           areas.bottom.splitter);
  if (of_log != 0 && l.is_open(Panel::log))
    l.log_pt = std::clamp(std::min(l.log_pt, log.lines_px() / ui.scale) - of_log, kLeastLogPt, kMaxLogPt);
}

bool Gui::wants_mouse() const {
  return panels_->wants_mouse;
}
bool Gui::wants_keyboard() const {
  return panels_->owns_keys();
}
std::vector<bool> Gui::key_uses() const {
  return panels_->key_uses;
}
bool Gui::is_interacting() const {
  return panels_->is_interacting;
}
size_t Gui::waiting_events() const {
  return panels_->waiting.size();
}
Cursor Gui::cursor() const {
  return panels_->cursor;
}
Rect Gui::image_rect() const {
  return panels_->image_rect;
}
const ImFontAtlas& Gui::fonts() const {
  ImGui::SetCurrentContext(panels_->context);
  return *ImGui::GetIO().Fonts;
}
void Gui::note_controls(bool on) {
  panels_->ui.notes_controls = on;
}
const std::vector<Control>& Gui::controls() const {
  return panels_->ui.controls;
}
uint32_t Gui::tree_rows() const {
  return panels_->tree.rows_drawn();
}

}  // namespace fire3dv::gui
