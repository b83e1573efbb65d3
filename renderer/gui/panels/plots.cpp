// Plots panel: curves of scalars over simulation time, with zoom, pause, a cursor and CSV export.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "renderer/gui/panels.h"
#include "renderer/gui/scalar_table.h"

namespace fire3dv::gui {
namespace {

ImU32 color_of_curve(size_t chosen) {
  const theme::Palette& p = *theme::palette;
  const ImU32 colors[PlotsPanel::kMaxChosen] = {p.accent, p.warning,   p.good,      p.bad,
                                                p.second, p.curves[0], p.curves[1], p.curves[2]};
  return colors[chosen];
}
constexpr float kHeightPt = 170;
constexpr int kMaxPlotRows = 9;     // a longer list scrolls
constexpr size_t kSearchFrom = 12;  // scalars
constexpr double kLeastSpanNs = 1e3;

struct Range {
  double low = 0, high = 1;
  double span() const { return high - low; }
};

// Step of grid lines of 1, 2 or 5 times a power of ten, at least this wide.
double grid_step(double least) {
  const double decade = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * decade >= least) return factor * decade;
  return 10 * decade;
}

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

// Position in a range as a share of its span, also where the span would overflow.
double share(double value, const Range& range) {
  const double span = range.high / 2 - range.low / 2;
  return span > 0 ? (value / 2 - range.low / 2) / span : 0.5;
}

// Value at this time: that of the newest sample not after it.
double value_at(const ScalarColumn& column, double time_ns) {
  const stream::ScalarGroup& group = *column.group;
  size_t low = 0, high = group.size();
  while (low < high) {
    const size_t middle = (low + high) / 2;
    if (static_cast<double>(group.sim_time_ns(middle)) <= time_ns)
      low = middle + 1;
    else
      high = middle;
  }
  return low == 0 ? stream::ScalarStatistics::kNone : group.value(low - 1, column.scalar);
}

// First sample not before this time.
size_t first_sample(const stream::ScalarGroup& group, double time_ns) {
  size_t low = 0, high = group.size();
  while (low < high) {
    const size_t middle = (low + high) / 2;
    if (static_cast<double>(group.sim_time_ns(middle)) < time_ns)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

// Samples that a range of time shows, with one beyond each end: lines continue to the edge.
std::pair<size_t, size_t> samples_in(const stream::ScalarGroup& group, const Range& time_ns) {
  const size_t first = first_sample(group, time_ns.low), last = first_sample(group, time_ns.high);
  return {first - std::min<size_t>(first, 1), std::min(last + 2, group.size())};
}

Range values_in(std::span<const ScalarColumn> columns, const Range& time_ns) {
  Range values{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const ScalarColumn& column : columns) {
    const auto [begin, end] = samples_in(*column.group, time_ns);
    for (size_t i = begin; i < end; ++i) {
      const double value = column.group->value(i, column.scalar);
      if (!std::isfinite(value)) continue;
      values.low = std::min(values.low, value);
      values.high = std::max(values.high, value);
    }
  }
  if (!(values.low <= values.high)) return {-1, 1};
  const double half = values.high / 2 - values.low / 2;
  const double margin = half > 0 ? half / 10 : std::max(std::abs(values.high) / 10, 1e-9);
  constexpr double kMax = std::numeric_limits<double>::max();
  return {std::max(values.low - margin, -kMax), std::min(values.high + margin, kMax)};
}

bool has_scalars(const state::PoseState& poses) {
  return std::ranges::any_of(poses.streams(), [](const state::Stream& stream) {
    return stream.active && !stream.scalars().groups().empty();
  });
}

class Canvas {
 public:
  Canvas(Ui& ui, const Rect& rect, const Range& time_ns, const Range& values)
      : ui_(ui), list_(*ImGui::GetWindowDrawList()), rect_(rect), time_ns_(time_ns), values_(values) {}

  float x(double time_ns) const {
    return rect_.low.x + limited(share(time_ns, time_ns_)) * (rect_.high.x - rect_.low.x);
  }
  float y(double value) const {
    return rect_.high.y - limited(share(value, values_)) * (rect_.high.y - rect_.low.y);
  }

  void grid() {
    const double second = 1e9;
    const Range time_s{time_ns_.low / second, time_ns_.high / second};
    const double step_s =
        grid_step(std::max(time_s.span(), 1e-9) * static_cast<double>(ui_.points(70)) / width());
    const auto from = std::ceil(time_s.low / step_s);
    for (int i = 0; i < kMaxLines && (from + i) * step_s <= time_s.high; ++i) {
      const double at_s = (from + i) * step_s;
      const float at = x(at_s * second);
      list_.AddLine({at, rect_.low.y}, {at, rect_.high.y}, theme::palette->line);
      label({at + ui_.points(2), rect_.high.y - ImGui::GetTextLineHeight()}, number_text(at_s) + " s");
    }
    const double span = 2 * (values_.high / 2 - values_.low / 2);
    if (!std::isfinite(span)) return;
    const double step = grid_step(span * static_cast<double>(ui_.points(36)) /
                                  static_cast<double>(rect_.high.y - rect_.low.y));
    const auto first = std::ceil(values_.low / step);
    for (int i = 0; i < kMaxLines && (first + i) * step <= values_.high; ++i) {
      const double value = (first + i) * step;
      list_.AddLine({rect_.low.x, y(value)}, {rect_.high.x, y(value)}, theme::palette->line);
      const float line = ImGui::GetTextLineHeight(), below = y(value);
      const float at = below - line < rect_.low.y ? below : below - line;
      if (below < rect_.high.y - line) label({rect_.low.x + ui_.points(2), at}, number_text(value));
    }
  }

  // A pixel column of many samples shows their first, least, largest and last value.
  void curve(const ScalarColumn& column, ImU32 color) {
    const auto [begin, end] = samples_in(*column.group, time_ns_);
    size_t points = 0;
    float column_x = 0, low = 0, high = 0, last = 0;
    bool has_column = false;
    const auto flush = [&] {
      if (!std::exchange(has_column, false)) return;
      if (high - low > 0.5f) {
        list_.PathLineTo({column_x, low});
        list_.PathLineTo({column_x, high});
        ++points;
      }
      list_.PathLineTo({column_x, last});
      ++points;
    };
    const auto stroke = [&] {
      flush();
      if (points == 1 && !list_._Path.empty())
        list_.AddCircleFilled(list_._Path.back(), ui_.points(1.5f), color);
      if (points > 1) list_.PathStroke(color, 0, ui_.points(1.25f));
      list_.PathClear();
      points = 0;
    };
    list_.PathClear();
    for (size_t i = begin; i < end; ++i) {
      const double value = column.group->value(i, column.scalar);
      if (!std::isfinite(value)) {
        stroke();
        continue;
      }
      const float at_x = x(static_cast<double>(column.group->sim_time_ns(i))), at_y = y(value);
      if (has_column && std::abs(at_x - column_x) < 0.5f) {
        low = std::min(low, at_y);
        high = std::max(high, at_y);
        last = at_y;
        continue;
      }
      flush();
      list_.PathLineTo({at_x, at_y});
      ++points;
      column_x = at_x;
      low = high = last = at_y;
      has_column = true;
    }
    stroke();
  }

  void upright(double time_ns, ImU32 color) {
    if (time_ns < time_ns_.low || time_ns > time_ns_.high) return;
    list_.AddLine({x(time_ns), rect_.low.y}, {x(time_ns), rect_.high.y}, color, ui_.points(1));
  }

 private:
  static constexpr int kMaxLines = 64;
  // Beyond the clip rectangle, but not where float coordinates lose precision.
  static float limited(double share) { return static_cast<float>(std::clamp(share, -100.0, 100.0)); }
  double width() const { return static_cast<double>(std::max(rect_.high.x - rect_.low.x, 1.0f)); }
  void label(ImVec2 at, const std::string& text) { list_.AddText(at, theme::palette->dim, text.c_str()); }

  Ui& ui_;
  ImDrawList& list_;
  const Rect rect_;
  const Range time_ns_, values_;
};

}  // namespace

bool PlotsPanel::Entry::has_key(std::string_view key) const {
  const std::string& last = scalar_name();
  if (key.size() != stream->size() + group_name->size() + last.size() + 2) return false;
  return key.starts_with(*stream) && key.ends_with(last) && key == this->key();
}

// Scalars of all streams, in the order of streams and names.
void PlotsPanel::list(const Context& context) {
  entries_.clear();
  for (const state::Stream& stream : context.shown.poses.streams()) {
    if (!stream.active) continue;
    for (const auto& [name, group] : stream.scalars().groups())
      for (size_t i = 0; i < group.declared().names.size(); ++i) {
        Entry& entry = entries_.emplace_back();
        entry.stream = &stream.name;
        entry.group_name = &name;
        entry.group = &group;
        entry.scalar = i;
        if (stream.header.sequence != 0) entry.shown_ns = static_cast<double>(stream.header.sim_time_ns);
      }
  }
  columns_.clear();
  shown_ns_.reset();
  for (Entry& entry : entries_) {
    const auto chosen =
        std::ranges::find_if(chosen_, [&](const std::string& key) { return entry.has_key(key); });
    if (chosen == chosen_.end() || columns_.size() == kMaxChosen) continue;
    entry.color = color_of_curve(static_cast<size_t>(chosen - chosen_.begin()));
    entry.chosen = true;
    columns_.push_back({entry.name(), entry.group, entry.scalar});
    if (!shown_ns_) shown_ns_ = entry.shown_ns;
  }
}

void PlotsPanel::draw(const Context& context) {
  Ui& ui = context.ui;
  takes_wheel_ = false;
  const bool unfolds = !context.layout.has_plotted && has_scalars(context.shown.poses);
  if (unfolds) context.layout.has_plotted = context.layout.is_open(Panel::plots) = true;
  if (!ui.header("Plots", context.layout.is_open(Panel::plots))) return;
  list(context);
  if (entries_.empty()) {
    ui.note("No stream publishes scalars.");
    return;
  }
  draw_plot(context);
  if (ui.button("Pause##plots", true, "Holds the range of time; zooming does, too", fixed_.has_value())) {
    if (fixed_) {
      fixed_.reset();
    } else {
      fixed_ = view_;
    }
  }
  ui.same_line();
  if (ui.button("Export CSV", !columns_.empty(), "The chosen scalars in the shown range of time, to a file"))
    context.view_state.commands.export_csv = csv_text(columns_, clamped_ns(view_[0]), clamped_ns(view_[1]));
  if (entries_.size() > kSearchFrom) ui.text("search", "search scalars", search_);
  draw_list(context);
  if (unfolds) ImGui::SetScrollHereY(1);
}

int64_t PlotsPanel::clamped_ns(double time_ns) {
  constexpr double kMax = 9.2e18;
  return static_cast<int64_t>(std::clamp(std::round(time_ns), -kMax, kMax));
}

void PlotsPanel::draw_plot(const Context& context) {
  Ui& ui = context.ui;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const ImVec2 size{std::max(ImGui::GetContentRegionAvail().x, 1.0f), ui.points(kHeightPt)};
  const bool clicked = invisible_button("plot", size.x, size.y);
  ui.note_control(Control::Kind::row, "plot");
  const bool hovered = ImGui::IsItemHovered(), held = ImGui::IsItemActive();
  move_view(size.x, at.x, hovered, held, clicked);

  const Range time_ns{view_[0], view_[1]};
  Canvas canvas(ui, {{at.x, at.y}, {at.x + size.x, at.y + size.y}}, time_ns, values_in(columns_, time_ns));
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(at, {at.x + size.x, at.y + size.y}, theme::palette->well);
  list.PushClipRect(at, {at.x + size.x, at.y + size.y}, true);
  if (columns_.empty()) {
    list.AddText({at.x + ui.points(6), at.y + ui.points(4)}, theme::palette->dim,
                 elided("Choose scalars below.", size.x - ui.points(8)).c_str());
  } else {
    canvas.grid();
    if (shown_ns_) canvas.upright(*shown_ns_, theme::palette->faint);
    for (const Entry& entry : entries_)
      if (entry.chosen) canvas.curve({{}, entry.group, entry.scalar}, entry.color);
    if (const std::optional<double> cursor = cursor_ns()) canvas.upright(*cursor, theme::palette->text);
  }
  list.PopClipRect();
}

// The range follows the whole history until the user zooms, pans or pauses.
void PlotsPanel::move_view(float width, float left, bool hovered, bool held, bool clicked) {
  if (!fixed_) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const ScalarColumn& column : columns_) {
      if (column.group->size() == 0) continue;
      low = std::min(low, static_cast<double>(column.group->sim_time_ns(0)));
      high = std::max(high, static_cast<double>(column.group->sim_time_ns(column.group->size() - 1)));
    }
    view_ = low <= high ? std::array{low, std::max(high, low + kLeastSpanNs)} : std::array{0.0, 1e9};
  } else {
    view_ = *fixed_;
  }
  hovered_ns_.reset();
  const ImGuiIO& io = ImGui::GetIO();
  const double span = view_[1] - view_[0];
  const double under = view_[0] + span * static_cast<double>((io.MousePos.x - left) / width);
  if (held && io.MouseDelta.x != 0 && ImGui::IsMouseDragging(0)) {
    const double moved = span * static_cast<double>(io.MouseDelta.x / width);
    fixed_ = view_ = {view_[0] - moved, view_[1] - moved};
  }
  if (hovered && io.MouseWheel != 0) {
    constexpr double kPerStep = 0.8, kMaxSpanNs = 1e19;
    const double wanted =
        std::clamp(span * std::pow(kPerStep, static_cast<double>(io.MouseWheel)), kLeastSpanNs, kMaxSpanNs);
    const double factor = wanted / span;
    fixed_ = view_ = {under - (under - view_[0]) * factor, under + (view_[1] - under) * factor};
  }
  takes_wheel_ = hovered;
  if (hovered) hovered_ns_ = under;
  const ImVec2 dragged = io.MouseClickedPos[0];
  const bool is_click = clicked && std::abs(io.MousePos.x - dragged.x) < io.MouseDragThreshold;
  if (is_click) pinned_ns_ = pinned_ns_ ? std::nullopt : std::optional<double>(under);
}

void PlotsPanel::draw_list(const Context& context) {
  Ui& ui = context.ui;
  listed_.clear();
  for (size_t i = 0; i < entries_.size(); ++i)
    if (search_.empty() || contains_no_case(entries_[i].name(), search_)) listed_.push_back(i);
  const std::optional<double> cursor = cursor_ns();
  if (cursor) {
    ui.value("Values at", "%.6f s", *cursor * 1e-9);
  } else {
    ui.value("Values at", theme::palette->dim, "newest");
  }
  const float row = ImGui::GetTextLineHeightWithSpacing();
  const int rows = static_cast<int>(listed_.size());
  ImGui::BeginChild("scalars", {0, row * static_cast<float>(std::clamp(rows, 1, kMaxPlotRows))});
  ImGuiListClipper clipper;
  clipper.Begin(rows, row);
  while (clipper.Step())
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i)
      draw_row(context, entries_[listed_[static_cast<size_t>(i)]], cursor);
  ImGui::EndChild();
}

void PlotsPanel::draw_row(const Context& context, const Entry& entry, std::optional<double> cursor) {
  Ui& ui = context.ui;
  const stream::ScalarStatistics& statistics = entry.group->statistics()[entry.scalar];
  const double value =
      cursor && entry.chosen ? value_at({{}, entry.group, entry.scalar}, *cursor) : statistics.last;
  const std::string& unit = entry.group->declared().units[entry.scalar];
  std::string text = std::isfinite(value) ? number_text(value) : "-";
  if (!unit.empty()) text += " " + one_line(unit);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float room = ImGui::GetContentRegionAvail().x;
  text = elided(text, room / 2);
  const float used = ImGui::CalcTextSize(text.c_str()).x;
  const std::string key = entry.key();
  ImGui::PushID(key.c_str());
  const bool clicked = ui.row(entry.name().c_str(), false, entry.chosen ? entry.color : theme::palette->dim,
                              room - used - ui.points(6));
  ImGui::PopID();
  ImGui::GetWindowDrawList()->AddText(
      {at.x + room - used, at.y}, entry.chosen ? theme::palette->text : theme::palette->dim, text.c_str());
  if (!clicked) return;
  // A free slot keeps the colours of the others.
  if (const auto chosen = std::ranges::find(chosen_, key); chosen != chosen_.end())
    chosen->clear();
  else if (const auto free = std::ranges::find(chosen_, std::string()); free != chosen_.end())
    *free = key;
}

}  // namespace fire3dv::gui
