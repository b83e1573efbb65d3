#include "renderer/gui/gui.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <variant>

#include "renderer/gui/input.h"
#include "renderer/gui/panels.h"

namespace fire3dv::gui {
namespace {

constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                    ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                                    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus;
constexpr float kLeastTreePt = 140, kEdgePt = 6;

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
  std::deque<Event> waiting;
  std::string clipboard;  // last text returned to ImGui, which keeps the pointer
  Cursor cursor = Cursor::arrow;
  bool wants_mouse = false, wants_keyboard = false;
  Rect image_rect;
  float left_rest_px = 0;  // height of the left column without the tree

  FramePanel frame;
  StreamsPanel streams;
  TreePanel tree;
  CamerasPanel cameras;
  MaterialsPanel materials;
  LightsPanel lights;
  LogPanel log;

  ~Panels() { ImGui::DestroyContext(context); }
  void take_events(ImGuiIO& io);
  void lay_out(const Context& context);
  float bottom(const Context& context, float left, float right, float height);
  void edges(const Context& context, float left, float right, float bottom);
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
// ImGui 1.90 ignores it on rows that were not hovered in the previous frame.
void Gui::Panels::take_events(ImGuiIO& io) {
  bool mouse_moved = false, button_changed = false;
  std::array<bool, static_cast<size_t>(Key::count)> key_changed{};
  while (!waiting.empty()) {
    const Event& event = waiting.front();
    if (const auto* moved = std::get_if<MouseMoved>(&event)) {
      if (button_changed) return;
      const ImVec2 to{moved->at_px.x, moved->at_px.y};
      mouse_moved |= to.x != io.MousePos.x || to.y != io.MousePos.y;
      io.MousePos = to;
    } else if (const auto* button = std::get_if<MouseButton>(&event)) {
      if (button_changed || (mouse_moved && button->down)) return;
      io.MouseDown[static_cast<size_t>(button->button)] = button->down;
      button_changed = true;
    } else if (const auto* wheel = std::get_if<MouseWheel>(&event)) {
      io.MouseWheelH += wheel->steps.x;
      io.MouseWheel += wheel->steps.y;
    } else if (const auto* key = std::get_if<KeyChanged>(&event)) {
      if (key->key < Key::count) {
        const auto number = static_cast<size_t>(key->key);
        if (key_changed[number]) return;
        key_changed[number] = true;
        set_key(io, key->key, key->down);
      }
    } else if (const auto* text = std::get_if<Text>(&event)) {
      io.AddInputCharacter(text->character);
    } else {
      io.MousePos = {-FLT_MAX, -FLT_MAX};
    }
    waiting.pop_front();
  }
}

const ImDrawData& Gui::frame(const Input& input, const Facts& facts, const Shown& shown, Viewer& viewer) {
  Panels& panels = *panels_;
  ImGui::SetCurrentContext(panels.context);
  ImGuiIO& io = ImGui::GetIO();
  const float wanted = std::isfinite(input.scale) ? input.scale : 1.0f;
  const float scale = std::clamp(std::round(wanted * 4) / 4, 0.5f, 4.0f);
  if (panels.scale != scale) {
    panels.scale = scale;
    apply_theme(scale);
    make_fonts(*io.Fonts, scale);
    ++fonts_number_;
  }
  io.DisplaySize = {std::max(input.display_px.x, 1.0f), std::max(input.display_px.y, 1.0f)};
  constexpr float kLeastDeltaS = 1e-4f;  // ImGui rejects a time step of 0
  io.DeltaTime = std::max(input.delta_s, kLeastDeltaS);
  set_modifiers(io, input.ctrl, input.shift, input.alt);
  panels.waiting.insert(panels.waiting.end(), input.events.begin(), input.events.end());
  panels.take_events(io);
  ImGui::NewFrame();
  panels.ui.begin_frame(scale);

  const Context context{panels.ui, facts, shown, viewer, layout_};
  panels.frame.note(facts.frame);
  panels.image_rect = {{0, 0}, input.display_px};
  if (viewer.gui) panels.lay_out(context);
  draw_help(context);

  ImGui::Render();
  panels.wants_mouse = io.WantCaptureMouse;
  panels.wants_keyboard = io.WantTextInput;
  panels.cursor = cursor_of(ImGui::GetMouseCursor());
  layout_.camera_speed = viewer.camera_speed;  // keys change it as well
  return *ImGui::GetDrawData();
}

void Gui::Panels::lay_out(const Context& c) {
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  // In a small window the image keeps a third. ImGui would replace a size of 0 by its own choice.
  const float third = std::max(std::floor(display.x / 3), 1.0f);
  const float left = std::min(ui.points(c.layout.left_pt), third);
  const float right = std::min(ui.points(c.layout.right_pt), third);

  ImGui::SetNextWindowPos({0, 0});
  ImGui::SetNextWindowSize({left, display.y});
  if (ImGui::Begin("left", nullptr, kFixed)) {
    const float top = ImGui::GetCursorPosY();
    const float room = ImGui::GetContentRegionAvail().y - left_rest_px;
    const float tree_height = std::max(std::floor(room), ui.points(kLeastTreePt));
    tree.draw(c, tree_height);
    draw_node_panel(c);
    cameras.draw(c);
    const bool tree_is_open = c.layout.is_open(Panel::tree);
    if (tree_is_open) left_rest_px = ImGui::GetCursorPosY() - top - tree_height;
  }
  ImGui::End();

  ImGui::SetNextWindowPos({display.x - right, 0});
  ImGui::SetNextWindowSize({right, display.y});
  if (ImGui::Begin("right", nullptr, kFixed)) {
    frame.draw(c);
    streams.draw(c);
    draw_render_panel(c);
    lights.draw(c);
    materials.draw(c);
  }
  ImGui::End();

  const float low = bottom(c, left, display.x - right, display.y);
  edges(c, left, display.x - right, low);
  image_rect = {{left, 0}, {display.x - right, low}};
}

// Returns the upper edge of the panel.
float Gui::Panels::bottom(const Context& c, float left, float right, float height) {
  const ImGuiStyle& style = ImGui::GetStyle();
  const float header = ImGui::GetTextLineHeight() + ui.points(9) + 2 * style.ItemSpacing.y;
  float wanted = 2 * style.WindowPadding.y + header;
  if (c.layout.is_open(Panel::log)) wanted += ui.points(c.layout.log_pt);
  if (c.shown.timeline) {
    wanted += header;
    if (c.layout.is_open(Panel::timeline)) wanted += 2 * ImGui::GetFrameHeightWithSpacing();
  }
  wanted = std::min(std::round(wanted), std::max(std::floor(height / 2), 1.0f));
  ImGui::SetNextWindowPos({left, height - wanted});
  ImGui::SetNextWindowSize({std::max(right - left, 1.0f), wanted});
  if (ImGui::Begin("bottom", nullptr, kFixed | ImGuiWindowFlags_NoScrollbar)) {
    draw_timeline_panel(c);
    log.draw(c);
  }
  ImGui::End();
  return height - wanted;
}

void Gui::Panels::edges(const Context& c, float left, float right, float bottom_y) {
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const float thick = ui.points(kEdgePt), half = std::floor(thick / 2);
  // Drawn in front of the columns: these have NoBringToFrontOnFocus, which ImGui puts behind all other
  // windows.
  constexpr ImGuiWindowFlags kEdge = (kFixed & ~ImGuiWindowFlags_NoBringToFrontOnFocus) |
                                     ImGuiWindowFlags_NoBackground | ImGuiWindowFlags_NoScrollbar |
                                     ImGuiWindowFlags_NoFocusOnAppearing;
  const auto edge = [&](const char* name, bool upright, const Rect& rect) {
    ImGui::SetNextWindowPos({rect.low.x, rect.low.y});
    ImGui::SetNextWindowSize(
        {std::max(rect.high.x - rect.low.x, 1.0f), std::max(rect.high.y - rect.low.y, 1.0f)});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
    float moved = 0;
    if (ImGui::Begin(name, nullptr, kEdge)) {
      ui.enter("Window");
      moved = ui.edge(name, upright, rect);
    }
    ImGui::End();
    ImGui::PopStyleVar();
    return moved / ui.scale;
  };
  Layout& l = c.layout;
  const float of_left = edge("edge of the left column", true, {{left - half, 0}, {left + half, display.y}});
  l.left_pt = std::clamp(l.left_pt + of_left, kLeastColumnPt, kMaxColumnPt);
  const float of_right =
      edge("edge of the right column", true, {{right - half, 0}, {right + half, display.y}});
  l.right_pt = std::clamp(l.right_pt - of_right, kLeastColumnPt, kMaxColumnPt);
  if (!l.is_open(Panel::log)) return;
  const float of_log =
      edge("edge of the log", false, {{left + half, bottom_y - half}, {right - half, bottom_y + half}});
  l.log_pt = std::clamp(l.log_pt - of_log, kLeastLogPt, kMaxLogPt);
}

bool Gui::wants_mouse() const {
  return panels_->wants_mouse;
}
bool Gui::wants_keyboard() const {
  return panels_->wants_keyboard;
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
