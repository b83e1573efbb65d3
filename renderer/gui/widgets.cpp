#include "renderer/gui/widgets.h"

#include <imgui_stdlib.h>

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <utility>

namespace fire3dv::gui {

namespace {

constexpr float kTextPt = 13;
constexpr float kLabelShare = 0.4f;

ImVec4 floats(ImU32 color) {
  return ImGui::ColorConvertU32ToFloat4(color);
}

}  // namespace

void apply_theme(float scale) {
  ImGuiStyle style;
  style.WindowPadding = {10, 8};
  style.FramePadding = {6, 3};
  style.ItemSpacing = {6, 4};
  style.ItemInnerSpacing = {5, 4};
  style.CellPadding = {4, 2};
  style.IndentSpacing = 12;
  style.ScrollbarSize = 10;
  style.GrabMinSize = 8;
  style.WindowRounding = 0;
  style.ChildRounding = style.FrameRounding = style.PopupRounding = style.GrabRounding = 3;
  style.ScrollbarRounding = 5;
  style.WindowBorderSize = 0;
  style.ChildBorderSize = 0;
  style.PopupBorderSize = 1;
  style.FrameBorderSize = 0;
  style.ScaleAllSizes(scale);
  style.WindowMinSize = {1, 1};  // columns may be arbitrarily narrow
  style.DisabledAlpha = 0.4f;

  ImVec4* const colors = style.Colors;
  for (int i = 0; i < ImGuiCol_COUNT; ++i) colors[i] = floats(theme::kWell);
  colors[ImGuiCol_Text] = floats(theme::kText);
  colors[ImGuiCol_TextDisabled] = floats(theme::kDim);
  colors[ImGuiCol_WindowBg] = floats(theme::kPanel);
  colors[ImGuiCol_ChildBg] = floats(theme::kPanel);
  colors[ImGuiCol_PopupBg] = floats(theme::kPanel);
  colors[ImGuiCol_Border] = floats(theme::rgb(0x3a414a));
  colors[ImGuiCol_BorderShadow] = {0, 0, 0, 0};
  colors[ImGuiCol_FrameBgHovered] = colors[ImGuiCol_FrameBgActive] = floats(theme::kWellHovered);
  colors[ImGuiCol_ScrollbarBg] = {0, 0, 0, 0};
  colors[ImGuiCol_ScrollbarGrab] = floats(theme::rgb(0x333942));
  colors[ImGuiCol_ScrollbarGrabHovered] = colors[ImGuiCol_ScrollbarGrabActive] = floats(theme::rgb(0x454d58));
  colors[ImGuiCol_CheckMark] = colors[ImGuiCol_SliderGrab] = floats(theme::kAccent);
  colors[ImGuiCol_SliderGrabActive] = floats(theme::rgb(0x7cc0ee));
  colors[ImGuiCol_Button] = floats(theme::rgb(0x2a2f37));
  colors[ImGuiCol_ButtonHovered] = floats(theme::rgb(0x39414c));
  colors[ImGuiCol_ButtonActive] = floats(theme::kAccentDark);
  colors[ImGuiCol_Header] = floats(theme::kAccentDark);
  colors[ImGuiCol_HeaderHovered] = floats(theme::kWellHovered);
  colors[ImGuiCol_HeaderActive] = floats(theme::kAccentDark);
  colors[ImGuiCol_Separator] = floats(theme::kLine);
  colors[ImGuiCol_PlotLines] = floats(theme::kAccent);
  colors[ImGuiCol_TextSelectedBg] = floats(theme::kAccentDark);
  colors[ImGuiCol_NavHighlight] = {0, 0, 0, 0};
  ImGui::GetStyle() = style;
}

void make_fonts(ImFontAtlas& fonts, float scale) {
  static constexpr ImWchar kRanges[] = {0x0020, 0x024f,                  // Latin
                                        0x0370, 0x03ff, 0x0400, 0x045f,  // Greek, Cyrillic
                                        0x2010, 0x2026,                  // dashes, quotes, dots
                                        0x2190, 0x2193, 0x2248, 0x2265,  // arrows; almost equal, <=, >=
                                        0x25a0, 0x25cf,                  // shapes: play, stop, visible
                                        0xfffd, 0xfffd, 0};
  fonts.Clear();
  fonts.Flags |= ImFontAtlasFlags_NoMouseCursors;
  ImFontConfig config;
  config.FontDataOwnedByAtlas = false;
  config.OversampleH = 2;
  config.OversampleV = 1;
  config.PixelSnapH = true;
  const auto bytes = font_bytes();
  // ImGui's parameter is not const, but data that it does not own is not modified.
  fonts.AddFontFromMemoryTTF(const_cast<std::byte*>(bytes.data()), static_cast<int>(bytes.size()),
                             std::round(kTextPt * scale), &config, kRanges);
  unsigned char* pixels = nullptr;
  int width = 0, height = 0;
  fonts.GetTexDataAsAlpha8(&pixels, &width, &height);
}

namespace {

float encoded(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}
float decoded(float srgb) {
  return srgb <= 0.04045f ? srgb / 12.92f : std::pow((srgb + 0.055f) / 1.055f, 2.4f);
}

// ImGui rejects buttons without an area, and windows may be as small as a pixel.
bool invisible_button(const char* name, float width, float height) {
  return ImGui::InvisibleButton(name, {std::max(width, 1.0f), std::max(height, 1.0f)});
}

}  // namespace

std::string elided(const std::string& text, float width_px) {
  if (text.empty() || ImGui::CalcTextSize(text.c_str()).x <= width_px) return text;
  constexpr const char* kEllipsis = "\u2026";
  const auto starts_character = [&](size_t at) {
    return at == text.size() || (static_cast<unsigned char>(text[at]) & 0xc0) != 0x80;
  };
  const float room = width_px - ImGui::CalcTextSize(kEllipsis).x;
  size_t fits = 0, fits_not = text.size();
  while (fits + 1 < fits_not) {
    const size_t middle = (fits + fits_not) / 2;
    const bool fit = ImGui::CalcTextSize(text.data(), text.data() + middle).x <= room;
    (fit ? fits : fits_not) = middle;
  }
  while (fits > 0 && !starts_character(fits)) --fits;
  return text.substr(0, fits) + kEllipsis;
}

std::string one_line(std::string_view text) {
  std::string line(text);
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return line;
}

void Ui::begin_frame(float display_scale) {
  scale = display_scale;
  controls.clear();
  panel_ = "";
  wants_same_line_ = false;
}

void Ui::note_control(Control::Kind kind, const char* name, bool enabled) {
  if (!notes_controls) return;
  const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
  controls.push_back({kind, panel_, name, {{low.x, low.y}, {high.x, high.y}}, enabled});
}

void Ui::hint(const char* text) {
  if (!text || !ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) return;
  if (ImGui::GetIO().MouseDown[0]) return;
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(std::min(points(280), ImGui::GetIO().DisplaySize.x * 0.8f));
  ImGui::TextUnformatted(text);
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

bool Ui::header(const char* title, bool& open) {
  panel_ = title;
  ImGui::Dummy({0, points(1)});
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x, height = ImGui::GetTextLineHeight() + points(8);
  ImDrawList* const list = ImGui::GetWindowDrawList();
  // A panel may have buttons in its title.
#if IMGUI_VERSION_NUM >= 18970
  ImGui::SetNextItemAllowOverlap();
  if (invisible_button(title, width, height)) open = !open;
#else
  if (invisible_button(title, width, height)) open = !open;
  ImGui::SetItemAllowOverlap();
#endif
  note_control(Control::Kind::header, title);
  const bool hovered = ImGui::IsItemHovered();
  list->AddLine({at.x, at.y}, {at.x + width, at.y}, theme::kLine);
  const float center = at.y + height / 2, arm = points(3.5f), x = at.x + points(5);
  const ImU32 arrow = hovered ? theme::kAccent : theme::kFaint;
  if (open) {
    list->AddTriangleFilled({x - arm, center - arm / 2}, {x + arm, center - arm / 2}, {x, center + arm},
                            arrow);
  } else {
    list->AddTriangleFilled({x - arm / 2, center - arm}, {x + arm, center}, {x - arm / 2, center + arm},
                            arrow);
  }
  list->AddText({at.x + points(15), at.y + points(4)}, open || hovered ? theme::kText : theme::kDim, title);
  return open;
}

void Ui::flow(float width_px) {
  if (!std::exchange(wants_same_line_, false)) return;
  const float right = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
  if (ImGui::GetItemRectMax().x + points(4) + width_px <= right) ImGui::SameLine(0, points(4));
}

void Ui::dim_label(const char* text, float width_px) {
  const std::string shown = elided(text, width_px);
  ImGui::PushStyleColor(ImGuiCol_Text, theme::kDim);
  ImGui::TextUnformatted(shown.c_str());
  ImGui::PopStyleColor();
  if (shown != text) hint(text);
}

float Ui::begin_row(const char* text) {
  const float width = ImGui::GetContentRegionAvail().x, left = ImGui::GetCursorPosX();
  ImGui::AlignTextToFramePadding();
  const float used = ImGui::CalcTextSize(text).x + points(6);
  const float label_width = std::max(std::round(width * kLabelShare), std::round(std::min(used, width * 0.7f)));
  dim_label(text, label_width - points(6));
  ImGui::SameLine(left + label_width);
  ImGui::SetNextItemWidth(width - label_width);
  return width - label_width;
}

void Ui::value(const char* label, const char* format, ...) {
  char text[256];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  value(label, theme::kText, text);
}

void Ui::value(const char* name, ImU32 color, const std::string& text) {
  const float width = ImGui::GetContentRegionAvail().x, left = ImGui::GetCursorPosX();
  const float used = ImGui::CalcTextSize(name).x + points(6);
  const float label_width = std::max(std::round(width * kLabelShare), std::round(std::min(used, width * 0.6f)));
  dim_label(name, label_width - points(6));
  ImGui::SameLine(left + label_width);
  ImGui::PushTextWrapPos(left + width);
  ImGui::TextColored(floats(color), "%s", text.c_str());
  ImGui::PopTextWrapPos();
}

void Ui::note(const std::string& text) {
  ImGui::PushTextWrapPos(0);
  ImGui::TextColored(floats(theme::kDim), "%s", text.c_str());
  ImGui::PopTextWrapPos();
}

bool Ui::button(const char* label, bool enabled, const char* hint_text, bool pressed) {
  flow(ImGui::CalcTextSize(label, nullptr, true).x + 2 * ImGui::GetStyle().FramePadding.x);
  ImGui::BeginDisabled(!enabled);
  if (pressed) ImGui::PushStyleColor(ImGuiCol_Button, theme::kAccentDark);
  const bool clicked = ImGui::Button(label);
  note_control(Control::Kind::button, label, enabled);
  if (pressed) ImGui::PopStyleColor();
  ImGui::EndDisabled();
  hint(hint_text);
  return clicked;
}

bool Ui::check(const char* label, bool& value, const char* hint_text) {
  ImGui::PushID(label);
  begin_row(label);
  const bool changed = ImGui::Checkbox("##", &value);
  note_control(Control::Kind::check, label);
  hint(hint_text);
  ImGui::PopID();
  return changed;
}

bool Ui::slider(const char* label, float& value, const Range& range, const char* hint_text) {
  ImGui::PushID(label);
  begin_row(label);
  const ImGuiSliderFlags flags =
      ImGuiSliderFlags_AlwaysClamp | (range.logarithmic ? ImGuiSliderFlags_Logarithmic : 0);
  const bool changed = ImGui::SliderFloat("##", &value, range.least, range.most, range.format, flags);
  note_control(Control::Kind::slider, label);
  hint(hint_text);
  ImGui::PopID();
  return changed;
}

bool Ui::choice(const char* label, size_t& chosen, std::span<const char* const> names,
                const char* hint_text) {
  ImGui::PushID(label);
  const float room =
      begin_row(label) - ImGui::GetFrameHeight() - 2 * ImGui::GetStyle().FramePadding.x;
  bool changed = false;
  const std::string now = names[std::min(chosen, names.size() - 1)], shown = elided(now, room);
  const bool open = ImGui::BeginCombo("##", shown.c_str());
  // Registers the closed combo box, before its popup adds other items.
  note_control(Control::Kind::choice, label);
  if (!open) hint(shown == now ? hint_text : now.c_str());
  if (open) {
    for (size_t i = 0; i < names.size(); ++i) {
      ImGui::PushID(static_cast<int>(i));  // names of a file may be equal
      const bool clicked = ImGui::Selectable(names[i], i == chosen);
      ImGui::PopID();
      note_control(Control::Kind::row, (std::string(label) + "/" + names[i]).c_str());
      if (!clicked) continue;
      changed = i != chosen;
      chosen = i;
    }
    ImGui::EndCombo();
  }
  ImGui::PopID();
  return changed;
}

bool Ui::color(const char* label, glm::vec3& linear, const char* hint_text) {
  ImGui::PushID(label);
  const float width = begin_row(label);
  // Edits sRGB-encoded values, as displayed. Values brighter than the display stay in range.
  glm::vec3 shown(encoded(linear.r), encoded(linear.g), encoded(linear.b));
  const ImVec4 swatch{std::min(shown.r, 1.0f), std::min(shown.g, 1.0f), std::min(shown.b, 1.0f), 1};
  constexpr ImGuiColorEditFlags kFlags = ImGuiColorEditFlags_NoAlpha | ImGuiColorEditFlags_NoTooltip;
  if (ImGui::ColorButton("##", swatch, kFlags, {width, ImGui::GetFrameHeight()})) ImGui::OpenPopup("color");
  note_control(Control::Kind::color, label);
  hint(hint_text);
  bool changed = false;
  if (ImGui::BeginPopup("color")) {
    constexpr ImGuiColorEditFlags kPicker = kFlags | ImGuiColorEditFlags_NoSidePreview |
                                            ImGuiColorEditFlags_NoLabel | ImGuiColorEditFlags_Float |
                                            ImGuiColorEditFlags_DisplayRGB | ImGuiColorEditFlags_InputRGB;
    ImGui::SetNextItemWidth(points(200));
    if (ImGui::ColorPicker3("##", &shown.x, kPicker)) {
      linear = {decoded(shown.r), decoded(shown.g), decoded(shown.b)};
      changed = true;
    }
    note_control(Control::Kind::color, (std::string(label) + "/picker").c_str());
    ImGui::EndPopup();
  }
  ImGui::PopID();
  return changed;
}

bool Ui::text(const char* name, const char* hint_text, std::string& value) {
  ImGui::SetNextItemWidth(-FLT_MIN);
  ImGui::PushID(name);
  const float room = ImGui::GetContentRegionAvail().x - 2 * ImGui::GetStyle().FramePadding.x;
  const bool changed = ImGui::InputTextWithHint("##", elided(hint_text, room).c_str(), &value);
  note_control(Control::Kind::text, name);
  ImGui::PopID();
  return changed;
}

bool Ui::row(const char* text, bool chosen, ImU32 text_color, float width) {
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::PushID(text);
  const bool clicked = ImGui::Selectable("##", chosen, ImGuiSelectableFlags_AllowItemOverlap, {width, 0});
  ImGui::PopID();
  note_control(Control::Kind::row, text);
  if (!ImGui::IsItemVisible()) return clicked;
  // Drawn as text instead of the item's label: ImGui hides label text from ## on, and names come from files.
  const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
  const ImVec4 clip{low.x, low.y, width > 0 ? at.x + width : high.x, high.y};
  const std::string whole = one_line(text), shown = elided(whole, clip.z - at.x);
  ImGui::GetWindowDrawList()->AddText(ImGui::GetFont(), ImGui::GetFontSize(), at, text_color, shown.c_str(),
                                      nullptr, 0, &clip);
  if (shown != whole) hint(whole.c_str());
  return clicked;
}

bool Ui::sign(const char* name, const char* glyph, ImU32 color, float width) {
  ImGui::PushID(name);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float height = ImGui::GetTextLineHeight();
  const bool clicked = invisible_button("##", width, height);
  note_control(Control::Kind::button, name);
  const ImVec2 size = ImGui::CalcTextSize(glyph);
  ImGui::GetWindowDrawList()->AddText({std::round(at.x + (width - size.x) / 2), at.y},
                                      ImGui::IsItemHovered() ? theme::kText : color, glyph);
  hint(name);
  ImGui::PopID();
  return clicked;
}

float Ui::edge(const char* name, bool upright, const Rect& rect) {
  ImGui::SetCursorScreenPos({rect.low.x, rect.low.y});
  invisible_button(name, rect.high.x - rect.low.x, rect.high.y - rect.low.y);
  note_control(Control::Kind::edge, name);
  const bool active = ImGui::IsItemActive();
  if (active || ImGui::IsItemHovered()) {
    ImGui::SetMouseCursor(upright ? ImGuiMouseCursor_ResizeEW : ImGuiMouseCursor_ResizeNS);
    ImGui::GetWindowDrawList()->AddRectFilled(ImGui::GetItemRectMin(), ImGui::GetItemRectMax(),
                                              active ? theme::kAccent : theme::kAccentDark);
  }
  if (!active) return 0;
  return upright ? ImGui::GetIO().MouseDelta.x : ImGui::GetIO().MouseDelta.y;
}

bool Ui::handle(const Splitter& at_edge, const Rect& rect, bool folded) {
  const char* const name = folded ? at_edge.unfold : at_edge.fold;
  ImGui::SetCursorScreenPos({rect.low.x, rect.low.y});
  const bool clicked = invisible_button(name, rect.high.x - rect.low.x, rect.high.y - rect.low.y);
  note_control(Control::Kind::button, name);
  const bool hovered = ImGui::IsItemHovered();
  ImDrawList* const list = ImGui::GetWindowDrawList();
  const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
  list->AddRectFilled(low, high, hovered ? theme::kWellHovered : theme::kWell);
  const ImVec2 at{(low.x + high.x) / 2, (low.y + high.y) / 2};
  const float arm = points(3.5f), half = points(2);
  const ImU32 color = hovered ? theme::kAccent : theme::kDim;
  // The arrow points to where the splitter will be.
  const float way = folded ? -1.0f : 1.0f;
  if (at_edge.arrow == ImGuiDir_Down) {
    list->AddTriangleFilled({at.x - arm, at.y - way * half}, {at.x + arm, at.y - way * half},
                            {at.x, at.y + way * half}, color);
  } else {
    const float side = at_edge.arrow == ImGuiDir_Left ? -way : way;
    list->AddTriangleFilled({at.x - side * half, at.y - arm}, {at.x - side * half, at.y + arm},
                            {at.x + side * half, at.y}, color);
  }
  if (hovered) ImGui::SetMouseCursor(ImGuiMouseCursor_Hand);
  hint(name);
  return clicked;
}

Ui::SplitterUse Ui::splitter(const Splitter& at_edge, const Rect& rect, bool folded) {
  if (folded) return {0, handle(at_edge, rect, true)};
  const bool upright = at_edge.arrow != ImGuiDir_Down;
  const int along = upright ? 1 : 0;
  const float length = rect.high[along] - rect.low[along];
  const float grip = std::min(points(44), std::floor(length / 2));
  Rect first = rect, middle = rect, last = rect;
  first.high[along] = middle.low[along] = rect.low[along] + std::floor((length - grip) / 2);
  middle.high[along] = last.low[along] = middle.low[along] + grip;
  SplitterUse use;
  use.moved_px = edge(at_edge.name, upright, first);
  use.toggled = handle(at_edge, middle, false);
  ImGui::PushID("last");
  use.moved_px += edge(at_edge.name, upright, last);
  ImGui::PopID();
  return use;
}

void Ui::bar(float share, ImU32 color) {
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x * std::clamp(share, 0.0f, 1.0f);
  ImGui::GetWindowDrawList()->AddRectFilled({at.x, at.y}, {at.x + width, at.y + ImGui::GetTextLineHeight()},
                                            color);
}

void Ui::plot(std::span<const Curve> curves, float height_pt, float least_top, const char* unit) {
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const ImVec2 size{ImGui::GetContentRegionAvail().x, points(height_pt)};
  ImGui::Dummy(size);
  if (!ImGui::IsItemVisible()) return;  // there may be many streams
  ImDrawList* const list = ImGui::GetWindowDrawList();
  list->AddRectFilled(at, {at.x + size.x, at.y + size.y}, theme::kWell);
  float top = least_top;
  size_t most = 2;
  for (const Curve& curve : curves) {
    for (const float value : curve.values) top = std::max(top, value);
    most = std::max(most, curve.values.size());
  }
  // Rounds the scale up to 1, 2, 5 or 10 times a power of ten, so that it rarely changes.
  const float decade = std::pow(10.0f, std::floor(std::log10(top)));
  for (const float step : {1.0f, 2.0f, 5.0f, 10.0f}) {
    if (step * decade < top * 0.999f) continue;
    top = step * decade;
    break;
  }
  const float step_x = size.x / static_cast<float>(most - 1);
  for (const Curve& curve : curves) {
    const size_t count = curve.values.size();
    const float first_x = at.x + size.x - step_x * static_cast<float>(count - std::min<size_t>(count, 1));
    const auto place = [&](size_t i) {
      const float y = at.y + size.y * (1 - std::min(curve.values[i] / top, 1.0f));
      return ImVec2{first_x + step_x * static_cast<float>(i), y};
    };
    const ImU32 fill = (curve.color & ~IM_COL32_A_MASK) | 0x30u << IM_COL32_A_SHIFT;
    // ImGui builds each quad as a separate path, so the line is drawn after all of them.
    for (size_t i = 0; i + 1 < count; ++i) {
      const ImVec2 a = place(i), b = place(i + 1);
      list->AddQuadFilled({a.x, at.y + size.y}, a, b, {b.x, at.y + size.y}, fill);
    }
    list->PathClear();
    for (size_t i = 0; i < count; ++i) list->PathLineTo(place(i));
    list->PathStroke(curve.color, 0, points(1));
  }
  char label[48];
  std::snprintf(label, sizeof label, "%g %s", static_cast<double>(top), unit);
  list->AddText({at.x + points(4), at.y + points(1)}, theme::kFaint,
                elided(label, size.x - points(8)).c_str());
}

}  // namespace fire3dv::gui
