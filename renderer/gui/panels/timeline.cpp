// Timeline panel: play, pause, step, seek and speed of a replayed recording.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "renderer/gui/panels.h"

namespace fire3dv::gui {
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
  if (ui.button(now.playing && !now.at_end ? "Pause##play" : "Play##play")) {
    if (now.playing && !now.at_end) {
      timeline->pause();
    } else {
      timeline->play();
    }
  }
  ui.same_line();
  if (ui.button("Step", true, "Pauses, and plays one frame")) timeline->step();
  ui.same_line();
  if (ui.button("To start")) timeline->seek(now.start_ns);
  ui.same_line();
  if (ui.button("Loop", true, "From the beginning again at the end", now.looping))
    timeline->set_looping(!now.looping);
  ui.same_line();
  ImGui::SetNextItemWidth(ui.points(130));
  size_t speed = nearest_speed(now.speed);
  ImGui::PushID("speed");
  const bool open = ImGui::BeginCombo("##", kSpeedNames[speed]);
  ui.note_control(Control::Kind::choice, "Speed");
  if (open) {
    for (size_t i = 0; i < std::size(kSpeeds); ++i) {
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
  ImGui::AlignTextToFramePadding();
  std::string text = clock_text(at_s) + " / " + clock_text(length_s);
  if (now.sim_time_ns) {
    char sim[48];
    std::snprintf(sim, sizeof sim, "   sim time %.3f s", static_cast<double>(*now.sim_time_ns) * 1e-9);
    text += sim;
  }
  ImGui::TextUnformatted(text.c_str());

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
