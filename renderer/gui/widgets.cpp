#include "renderer/gui/widgets.h"

#include <imgui_stdlib.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "base/color/srgb.h"

namespace fire3dv::gui {

namespace {

constexpr float kLabelShare = 0.4f;

}  // namespace

bool invisible_button(const char* name, float width, float height) {
  return ImGui::InvisibleButton(name, {std::max(width, 1.0f), std::max(height, 1.0f)});
}

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

std::string wrapped(std::string text, float width_px) {
  size_t begin = 0;  // of the line
  size_t space = text.find(' ');
  while (space != std::string::npos) {
    size_t word = text.find_first_not_of(' ', space);
    if (word == std::string::npos) break;
    const size_t end = std::min(text.find(' ', word), text.size());
    if (ImGui::CalcTextSize(text.data() + begin, text.data() + end).x > width_px) {
      text.replace(space, word - space, "\n");
      begin = word = space + 1;
    }
    space = text.find(' ', word);
  }
  return text;
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
  controls.push_back({kind, panel_, name, {{low.x, low.y}, {high.x, high.y}}, enabled && !is_disabled_});
}

void Ui::begin_disabled(bool disabled) {
  is_disabled_ = disabled;
  ImGui::BeginDisabled(disabled);
}

void Ui::end_disabled() {
  is_disabled_ = false;
  ImGui::EndDisabled();
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
  list->AddLine({at.x, at.y}, {at.x + width, at.y}, theme::palette->line);
  const float center = at.y + height / 2, arm = points(3.5f), x = at.x + points(5);
  const ImU32 arrow = hovered ? theme::palette->accent : theme::palette->faint;
  if (open) {
    list->AddTriangleFilled({x - arm, center - arm / 2}, {x + arm, center - arm / 2}, {x, center + arm},
                            arrow);
  } else {
    list->AddTriangleFilled({x - arm / 2, center - arm}, {x + arm, center}, {x - arm / 2, center + arm},
                            arrow);
  }
  list->AddText({at.x + points(15), at.y + points(4)},
                open || hovered ? theme::palette->text : theme::palette->dim, title);
  return open;
}

void Ui::flow(float width_px) {
  if (!std::exchange(wants_same_line_, false)) return;
  const float right = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
  if (ImGui::GetItemRectMax().x + points(4) + width_px <= right) ImGui::SameLine(0, points(4));
}

void Ui::dim_label(const char* text, float width_px) {
  const std::string shown = elided(text, width_px);
  ImGui::PushStyleColor(ImGuiCol_Text, theme::palette->dim);
  ImGui::TextUnformatted(shown.c_str());
  ImGui::PopStyleColor();
  if (shown != text) hint(text);
}

float Ui::begin_row(const char* text) {
  const float width = ImGui::GetContentRegionAvail().x, left = ImGui::GetCursorPosX();
  ImGui::AlignTextToFramePadding();
  const float used = ImGui::CalcTextSize(text).x + points(6);
  const float label_width =
      std::max(std::round(width * kLabelShare), std::round(std::min(used, width * 0.7f)));
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
  value(label, theme::palette->text, text);
}

void Ui::value(const char* name, ImU32 color, const std::string& text) {
  const float width = ImGui::GetContentRegionAvail().x, left = ImGui::GetCursorPosX();
  const float used = ImGui::CalcTextSize(name).x + points(6);
  const float label_width =
      std::max(std::round(width * kLabelShare), std::round(std::min(used, width * 0.6f)));
  dim_label(name, label_width - points(6));
  ImGui::SameLine(left + label_width);
  ImGui::PushTextWrapPos(left + width);
  ImGui::TextColored(theme::floats(color), "%s", wrapped(text, width - label_width).c_str());
  ImGui::PopTextWrapPos();
}

void Ui::note(const std::string& text) {
  ImGui::PushTextWrapPos(0);
  ImGui::TextColored(theme::floats(theme::palette->dim), "%s", text.c_str());
  ImGui::PopTextWrapPos();
}

bool Ui::button(const char* label, bool enabled, const char* hint_text, bool pressed) {
  flow(ImGui::CalcTextSize(label, nullptr, true).x + 2 * ImGui::GetStyle().FramePadding.x);
  ImGui::BeginDisabled(!enabled);
  if (pressed) ImGui::PushStyleColor(ImGuiCol_Button, theme::palette->accent_dark);
  const bool clicked = ImGui::Button(label);
  note_control(Control::Kind::button, label, enabled);
  if (pressed) ImGui::PopStyleColor();
  ImGui::EndDisabled();
  hint(hint_text);
  return clicked;
}

bool Ui::check(const char* label, bool& value, const char* hint_text) {
  ImGui::PushID(label);
  // In a narrow column many labels reach into the column of the box: all boxes are at its edge then.
  constexpr float kNarrowPt = 180;
  const float width = ImGui::GetContentRegionAvail().x, left = ImGui::GetCursorPosX();
  if (width < points(kNarrowPt)) {
    const float box = std::max(width - ImGui::GetFrameHeight(), 0.0f);
    ImGui::AlignTextToFramePadding();
    dim_label(label, box - points(6));
    ImGui::SameLine(left + box);
  } else {
    begin_row(label);
  }
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

float without_minus_zero(float value, const char* format) {
  char text[64];
  std::snprintf(text, sizeof text, format, static_cast<double>(value));
  return std::signbit(value) && std::strtof(text, nullptr) == 0 ? 0 : value;
}

bool Ui::numbers(const char* label, glm::vec3& value, const Numbers& numbers, const char* hint_text) {
  constexpr const char* kAxes[] = {" x", " y", " z"};
  ImGui::PushID(label);
  const float gap = points(3), least = ImGui::CalcTextSize("-00.000").x,
              row = ImGui::GetContentRegionAvail().x;
  float width = (begin_row(label) - 2 * gap) / 3;
  if (width < least) {  // below the label there is more room
    ImGui::NewLine();
    width = (row - 2 * gap) / 3;
  }
  width = std::max(width, 1.0f);
  bool changed = false;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis > 0) ImGui::SameLine(0, gap);
    ImGui::PushID(axis);
    ImGui::SetNextItemWidth(width);
    float shown = without_minus_zero(value[axis], numbers.format);
    if (ImGui::DragFloat("##", &shown, numbers.step, 0, 0, numbers.format)) {
      value[axis] = shown;
      changed = true;
    }
    note_control(Control::Kind::number, (std::string(label) + kAxes[axis]).c_str());
    hint(hint_text);
    ImGui::PopID();
  }
  ImGui::PopID();
  return changed && std::isfinite(value.x) && std::isfinite(value.y) && std::isfinite(value.z);
}

bool Ui::choice(const char* label, size_t& chosen, std::span<const char* const> names,
                const char* hint_text) {
  ImGui::PushID(label);
  const float room = begin_row(label) - ImGui::GetFrameHeight() - 2 * ImGui::GetStyle().FramePadding.x;
  bool changed = false;
  const std::string now = names[std::min(chosen, names.size() - 1)], shown = elided(now, room);
  const bool open = ImGui::BeginCombo("##", shown.c_str());
  // Registers the closed combo box, before its popup adds other items.
  note_control(Control::Kind::choice, label);
  if (!open) hint(shown == now ? hint_text : now.c_str());
  has_opened_list_ = open && ImGui::IsWindowAppearing();
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
  glm::vec3 shown(srgb_from_linear(linear.r), srgb_from_linear(linear.g), srgb_from_linear(linear.b));
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
      linear = {linear_from_srgb(shown.r), linear_from_srgb(shown.g), linear_from_srgb(shown.b)};
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
  if (chosen) text_color = theme::palette->text;  // others are hard to read on the colour of a chosen row
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
                                      ImGui::IsItemHovered() ? theme::palette->text : color, glyph);
  hint(name);
  ImGui::PopID();
  return clicked;
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
  list->AddRectFilled(at, {at.x + size.x, at.y + size.y}, theme::palette->well);
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
    const auto point_at = [&](size_t i) {
      const float y = at.y + size.y * (1 - std::min(curve.values[i] / top, 1.0f));
      return ImVec2{first_x + step_x * static_cast<float>(i), y};
    };
    const ImU32 fill = (curve.color & ~IM_COL32_A_MASK) | 0x30u << IM_COL32_A_SHIFT;
    // ImGui builds each quad as a separate path, so the line is drawn after all of them.
    for (size_t i = 0; i + 1 < count; ++i) {
      const ImVec2 a = point_at(i), b = point_at(i + 1);
      list->AddQuadFilled({a.x, at.y + size.y}, a, b, {b.x, at.y + size.y}, fill);
    }
    list->PathClear();
    for (size_t i = 0; i < count; ++i) list->PathLineTo(point_at(i));
    list->PathStroke(curve.color, 0, points(1));
  }
  char label[48];
  std::snprintf(label, sizeof label, "%g %s", static_cast<double>(top), unit);
  list->AddText({at.x + points(4), at.y + points(1)}, theme::palette->faint,
                elided(label, size.x - points(8)).c_str());
}

}  // namespace fire3dv::gui
