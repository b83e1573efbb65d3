// Streams panel: state, jitter, losses by cause, and playout settings of each stream.
#include <algorithm>
#include <cmath>

#include "renderer/gui/panels.h"

namespace fire3dv::gui {
namespace {

ImU32 color_of(state::Condition condition) {
  switch (condition) {
    case state::Condition::live:
      return theme::kGood;
    case state::Condition::late:
      return theme::kWarning;
    case state::Condition::lost:
      return theme::kBad;
  }
  return theme::kDim;
}

// Resources of the peer near their limit, or with refusals.
void draw_uses(Ui& ui, const std::vector<UseFact>& uses) {
  if (uses.empty()) return;
  ui.note("Uses, of the limit of one peer:");
  for (const UseFact& use : uses) {
    std::string text = amount_text(use.resource, use.used) + " of " + amount_text(use.resource, use.limit);
    if (use.refused > 0) text += ", " + grouped(use.refused) + " refused";
    ui.value(std::string(info(use.resource).name).c_str(), use.refused > 0 ? theme::kWarning : theme::kText,
             text);
    ui.hint(std::string(info(use.resource).noun).c_str());
  }
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
    ui.value(link.peers == 1 ? "1 peer" : (std::to_string(link.peers) + " peers").c_str(), theme::kDim,
             link.uri + "  " + bytes_text(link.received_bytes));
    if (link.poses_dropped + link.frames_dropped + link.rejected > 0) {
      ui.value("  dropped", theme::kWarning,
               grouped(link.poses_dropped) + " overtaken, " + grouped(link.frames_dropped) + " incomplete, " +
                   grouped(link.rejected) + " refused");
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
  ImGui::TextUnformatted(one_line(stream.name).c_str());
  ImGui::SameLine();
  ImGui::PushStyleColor(ImGuiCol_Text, color_of(stream.condition));
  ImGui::TextUnformatted(state::condition_name(stream.condition));
  ImGui::PopStyleColor();

  ui.value("Rate", "%.1f frames/s", stream.rate_hz);
  if (stream.age_ms) ui.value("Age", "%.1f ms", *stream.age_ms);
  ui.value("Frame", "%s   %.3f s", grouped(stream.sequence).c_str(),
           static_cast<double>(stream.sim_time_ns) * 1e-9);
  std::string nodes = grouped(stream.poses - std::min(stream.poses, stream.unmatched + stream.conflicting));
  nodes += " of " + grouped(stream.poses);
  const bool all_bound = stream.unmatched + stream.conflicting == 0;
  ui.value("Nodes driven", all_bound ? theme::kText : theme::kWarning, nodes);
  if (stream.unmatched > 0) ui.value("  not in scene", theme::kWarning, grouped(stream.unmatched));
  if (stream.conflicting > 0) ui.value("  another's", theme::kWarning, grouped(stream.conflicting));
  const std::pair<const char*, uint64_t> drops[] = {{"  incomplete", stream.incomplete},
                                                    {"  stale", stream.stale},
                                                    {"  refused", stream.refused},
                                                    {"  without base", stream.baseless},
                                                    {"  gave up waiting", stream.overtaken}};
  ui.value("Shown", "%s", grouped(stream.shown).c_str());
  for (const auto& [cause, count] : drops) {
    if (count > 0) ui.value(cause, theme::kWarning, grouped(count));
  }
  if (stream.edits + stream.edits_refused > 0) {
    ui.value("Edits", "%s, %s refused", grouped(stream.edits).c_str(), grouped(stream.edits_refused).c_str());
  }
  draw_uses(ui, stream.uses);
  if (stream.gaps_ms.size() > 1) {
    const Ui::Curve gaps{stream.gaps_ms, theme::kAccent};
    ui.plot({&gaps, 1}, 34, 1, "ms between frames");
  }
  ui.value("Clock", theme::kDim, stream.clock);

  // Settings without a user choice keep their current values.
  StreamPlayout playout{stream.interpolated, {}};
  const auto edited = context.viewer.streams.find(stream.epoch);
  if (edited != context.viewer.streams.end()) playout = edited->second;
  const StreamPlayout before = playout;
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
  if (!(playout == before)) context.viewer.streams[stream.epoch] = playout;
  ImGui::Dummy({0, ui.points(2)});
  ImGui::PopID();
}

}  // namespace fire3dv::gui
