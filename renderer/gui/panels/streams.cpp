// Streams panel (state, jitter, losses by cause, markers and playout settings of each stream), and timeline
// panel.

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "renderer/gui/panels.h"

namespace fire3dv::gui {

namespace {

ImU32 color_of(state::Condition condition) {
  switch (condition) {
    case state::Condition::live:
      return theme::palette->good;
    case state::Condition::late:
      return theme::palette->warning;
    case state::Condition::lost:
      return theme::palette->bad;
  }
  return theme::palette->dim;
}

// Resources of the peer near their limit, or with refusals.
void draw_uses(Ui& ui, const std::vector<UseFact>& uses) {
  if (uses.empty()) return;
  ui.note("Uses, of the limit of one peer:");
  for (const UseFact& use : uses) {
    std::string text = amount_text(use.resource, use.used) + " of " + amount_text(use.resource, use.limit);
    if (use.refused > 0) text += ", " + grouped(use.refused) + " refused";
    ui.value(std::string(info(use.resource).name).c_str(),
             use.refused > 0 ? theme::palette->warning : theme::palette->text, text);
    ui.hint(std::string(info(use.resource).noun).c_str());
  }
}

// Check boxes that show and hide the namespaces of the stream's markers.
void draw_markers(const Context& context, const StreamFact& stream) {
  Ui& ui = context.ui;
  if (stream.marker_namespaces.empty()) return;
  ui.note("Markers:");
  state::MarkerNamespaces& hidden = context.view_state.edits.hidden_markers;
  for (size_t i = 0; i < stream.marker_namespaces.size(); ++i) {
    const MarkerFact& fact = stream.marker_namespaces[i];
    const state::MarkerNamespace key{stream.name, fact.name};
    const std::string label = fact.name.empty() ? "  without namespace" : "  " + one_line(fact.name);
    const std::string hint = grouped(fact.markers) + (fact.markers == 1 ? " marker" : " markers");
    bool is_shown = !hidden.contains(key);
    ImGui::PushID(static_cast<int>(i));  // names that differ may be displayed alike
    if (ui.check(label.c_str(), is_shown, hint.c_str())) {
      if (is_shown) {
        hidden.erase(key);
      } else {
        hidden.insert(key);
      }
    }
    ImGui::PopID();
  }
  if (stream.more_marker_namespaces > 0)
    ui.note("and " + grouped(stream.more_marker_namespaces) + " more namespaces");
}

constexpr float kMaxDelayMs = 500;
constexpr float kUsualDelayMs = 50;

}  // namespace

void StreamsPanel::draw(const Context& context) {
  Ui& ui = context.ui;
  if (!ui.header("Streams", context.layout.is_open(Panel::streams))) return;
  if (context.facts.streams.empty()) ui.note("No simulator has connected.");
  for (const StreamFact& stream : context.facts.streams) draw_stream(context, stream);
  for (const LinkFact& link : context.facts.links) {
    ui.value(link.peers == 1 ? "1 peer" : (std::to_string(link.peers) + " peers").c_str(),
             theme::palette->dim, link.uri + "  " + bytes_text(link.received_bytes));
    if (link.poses_dropped + link.frames_dropped + link.rejected > 0) {
      // Newer poses overtake older ones whenever a simulator is faster than the display: no reason to worry.
      const bool is_lossy = link.frames_dropped + link.rejected > 0;
      ui.value("  dropped", is_lossy ? theme::palette->warning : theme::palette->dim,
               grouped(link.poses_dropped) + " replaced by newer ones, " + grouped(link.frames_dropped) +
                   " incomplete, " + grouped(link.rejected) + " refused");
    }
  }
}

void StreamsPanel::draw_stream(const Context& context, const StreamFact& stream) {
  Ui& ui = context.ui;
  ImGui::PushID(reinterpret_cast<const void*>(static_cast<uintptr_t>(stream.epoch)));
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float radius = ui.points(3.5f);
  ImGui::GetWindowDrawList()->AddCircleFilled({at.x + radius, at.y + ImGui::GetTextLineHeight() / 2}, radius,
                                              color_of(stream.condition));
  ImGui::SetCursorPosX(ImGui::GetCursorPosX() + 2 * radius + ui.points(5));
  const char* const condition = state::condition_name(stream.condition);
  const float room =
      ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(condition).x - ImGui::GetStyle().ItemSpacing.x;
  const std::string name = one_line(stream.name), shown_name = elided(name, room);
  ImGui::TextUnformatted(shown_name.c_str());
  if (shown_name != name) ui.hint(name.c_str());
  ImGui::SameLine();
  ImGui::PushStyleColor(ImGuiCol_Text, color_of(stream.condition));
  ImGui::TextUnformatted(condition);
  ImGui::PopStyleColor();

  ui.value("Rate", "%.1f frames/s", stream.rate_hz);
  if (stream.age_ms) ui.value("Age", "%.1f ms", *stream.age_ms);
  ui.value("Frame", "%s   %.3f s", grouped(stream.sequence).c_str(),
           static_cast<double>(stream.sim_time_ns) * 1e-9);
  std::string nodes = grouped(stream.poses - std::min(stream.poses, stream.unmatched + stream.conflicting));
  nodes += " of " + grouped(stream.poses);
  const bool all_bound = stream.unmatched + stream.conflicting == 0;
  ui.value("Nodes driven", all_bound ? theme::palette->text : theme::palette->warning, nodes);
  if (stream.unmatched > 0) ui.value("  not in scene", theme::palette->warning, grouped(stream.unmatched));
  if (stream.conflicting > 0) ui.value("  another's", theme::palette->warning, grouped(stream.conflicting));
  const std::pair<const char*, uint64_t> drops[] = {{"  incomplete", stream.incomplete},
                                                    {"  stale", stream.stale},
                                                    {"  refused", stream.refused},
                                                    {"  without base", stream.baseless},
                                                    {"  gave up waiting", stream.overtaken}};
  ui.value("Shown", "%s", grouped(stream.shown).c_str());
  for (const auto& [cause, count] : drops) {
    if (count > 0) ui.value(cause, theme::palette->warning, grouped(count));
  }
  if (stream.edits + stream.edits_refused > 0) {
    ui.value("Edits", "%s, %s refused", grouped(stream.edits).c_str(), grouped(stream.edits_refused).c_str());
  }
  if (stream.draw_cost.seconds > 0 || stream.draw_cost.is_hidden) {
    const bool is_hidden = stream.draw_cost.is_hidden;
    ui.value("Drawing time", is_hidden ? theme::palette->warning : theme::palette->text,
             is_hidden ? "content hidden"
                       : std::to_string(std::lround(100 * stream.draw_cost.share)) + " % of all images");
    ui.hint("Time that this stream's markers, nodes and vertices take, while several peers are connected.");
  }
  draw_uses(ui, stream.uses);
  draw_markers(context, stream);
  if (stream.gaps_ms.size() > 1) {
    const Ui::Curve gaps{stream.gaps_ms, theme::palette->accent};
    ui.plot({&gaps, 1}, 34, 1, "ms between frames");
  }
  ui.value("Clock", theme::palette->dim, stream.clock);

  // Settings without a user choice keep their current values.
  app::StreamPlayout playout{stream.interpolated, {}};
  const auto edited = context.view_state.streams.find(stream.epoch);
  if (edited != context.view_state.streams.end()) playout = edited->second;
  const app::StreamPlayout before = playout;
  constexpr const char* kModes[] = {"newest frame", "interpolated"};
  size_t mode = playout.interpolate ? 1 : 0;
  ui.choice("Shown as", mode, kModes,
            "The newest frame as soon as it is there, or motion that is smooth and a little late.");
  playout.interpolate = mode == 1;
  if (playout.interpolate) {
    bool follows = !playout.delay_ns;
    const float now_ms = static_cast<float>(static_cast<double>(stream.delay_ns) * 1e-6);
    if (ui.check("Delay follows jitter", follows)) {
      if (follows) {
        playout.delay_ns.reset();
      } else {
        playout.delay_ns = stream.delay_ns > 0 ? stream.delay_ns : static_cast<int64_t>(kUsualDelayMs * 1e6f);
      }
    }
    if (playout.delay_ns) {
      float delay_ms = static_cast<float>(static_cast<double>(*playout.delay_ns) * 1e-6);
      if (ui.slider("Delay", delay_ms, {0, kMaxDelayMs, "%.0f ms"}))
        playout.delay_ns = std::llround(static_cast<double>(delay_ms) * 1e6);
    } else {
      ui.value("Delay", "%.1f ms", static_cast<double>(now_ms));
    }
  }
  if (!(playout == before)) context.view_state.streams[stream.epoch] = playout;
  ImGui::Dummy({0, ui.points(2)});
  ImGui::PopID();
}

// --- timeline panel: play, pause, step, seek and speed of a replayed recording ---

namespace {

constexpr double kSpeeds[] = {0.1, 0.25, 0.5, 1, 2, 4, 10, 0};
constexpr const char* kSpeedNames[] = {"0.1 x", "0.25 x", "0.5 x", "1 x",
                                       "2 x",   "4 x",    "10 x",  "as fast as can be"};

size_t nearest_speed(double speed) {
  if (speed <= 0) return std::size(kSpeeds) - 1;
  size_t best = 0;
  for (size_t i = 0; i + 1 < std::size(kSpeeds); ++i) {
    if (std::abs(std::log(kSpeeds[i] / speed)) < std::abs(std::log(kSpeeds[best] / speed))) best = i;
  }
  return best;
}

std::string clock_text(double seconds) {
  char text[32];
  const auto minutes = static_cast<long>(seconds / 60);
  std::snprintf(text, sizeof text, "%ld:%06.3f", minutes, seconds - static_cast<double>(minutes) * 60);
  return text;
}

}  // namespace

void draw_timeline_panel(const Context& context) {
  replay::TimelineControl* const timeline = context.shown.timeline;
  if (!timeline) return;
  Ui& ui = context.ui;
  if (!ui.header("Timeline", context.layout.is_open(Panel::timeline))) return;
  const replay::TimelineState now = timeline->timeline();
  if (ui.button(now.playing && !now.at_end ? "Pause##play" : "Play##play", true, "Space")) {
    if (now.playing && !now.at_end) {
      timeline->pause();
    } else {
      timeline->play();
    }
  }
  ui.same_line();
  if (ui.button("Back", true, "Pauses, and shows the frame before  (,)")) timeline->step_back();
  ui.same_line();
  if (ui.button("Step", true, "Pauses, and plays one frame  (.)")) timeline->step();
  ui.same_line();
  if (ui.button("To start")) timeline->seek(now.start_ns);
  ui.same_line();
  if (ui.button("Loop", true, "From the beginning again at the end", now.looping))
    timeline->set_looping(!now.looping);
  ui.same_line();
  const float speed_width = std::min(ui.points(130), ImGui::GetContentRegionAvail().x);
  ui.flow(speed_width);
  ImGui::SetNextItemWidth(speed_width);
  size_t speed = nearest_speed(now.speed);
  ImGui::PushID("speed");
  const bool open = ImGui::BeginCombo("##", kSpeedNames[speed]);
  ui.note_control(Control::Kind::choice, "Speed");
  if (open) {
    for (size_t i = 0; i < std::size(kSpeeds); ++i) {
      if (kSpeeds[i] == 0 && !now.can_be_unpaced) continue;
      if (ImGui::Selectable(kSpeedNames[i], i == speed) && i != speed) timeline->set_speed(kSpeeds[i]);
      ui.note_control(Control::Kind::row, (std::string("Speed/") + kSpeedNames[i]).c_str());
    }
    ImGui::EndCombo();
  }
  ImGui::PopID();
  ui.same_line();
  const double length_s = static_cast<double>(now.end_ns - std::min(now.start_ns, now.end_ns)) * 1e-9;
  double at_s =
      static_cast<double>(std::clamp(now.position_ns, now.start_ns, std::max(now.start_ns, now.end_ns)) -
                          now.start_ns) *
      1e-9;
  std::string text = clock_text(at_s) + " / " + clock_text(length_s);
  if (now.sim_time_ns) {
    char sim[48];
    std::snprintf(sim, sizeof sim, "   sim time %.3f s", static_cast<double>(*now.sim_time_ns) * 1e-9);
    text += sim;
  }
  ui.flow(ImGui::CalcTextSize(text.c_str()).x);
  ImGui::AlignTextToFramePadding();
  ImGui::PushTextWrapPos(0);
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();

  ImGui::SetNextItemWidth(-FLT_MIN);
  const double least = 0;
  ImGui::BeginDisabled(length_s <= 0);
  if (ImGui::SliderScalar("##position", ImGuiDataType_Double, &at_s, &least, &length_s, "",
                          ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoInput))
    timeline->seek(now.start_ns + static_cast<uint64_t>(std::llround(std::max(at_s, 0.0) * 1e9)));
  ui.note_control(Control::Kind::slider, "Position", length_s > 0);
  ImGui::EndDisabled();
  if (now.damaged_chunks + now.refused_messages > 0) {
    ui.note(grouped(now.damaged_chunks) + " damaged pieces were passed over, " +
            grouped(now.refused_messages) + " messages were not understood");
  }
}

}  // namespace fire3dv::gui
