#include "renderer/browser/live_messages.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "renderer/browser/json_text.h"
#include "renderer/browser/live_plots.h"

namespace fire3dv::app {
namespace {

using Json = nlohmann::json;

constexpr size_t kMaxListNameBytes = 200;
constexpr size_t kMaxStreams = 64;

std::string shown_name(const std::string& name, const char* kind, uint32_t number) {
  return name.empty() ? kind + (" " + std::to_string(number)) : printable_text(name, kMaxListNameBytes);
}

Json json_of(const replay::TimelineState& timeline) {
  const double start = static_cast<double>(timeline.start_ns);
  const double length = std::max(static_cast<double>(timeline.end_ns) - start, 0.0);
  return {{"playing", timeline.playing && !timeline.at_end},
          {"position_s",
           std::clamp((static_cast<double>(timeline.position_ns) - start) * 1e-9, 0.0, length * 1e-9)},
          {"duration_s", length * 1e-9}};
}

// Stream that drives the node; null: none.
const state::Stream* driver_of(const state::PoseState& poses, uint32_t node) {
  const auto& drives = poses.node_drives();
  if (node >= drives.size() || drives[node].stream == state::kNone) return nullptr;
  const auto& streams = poses.streams();
  return drives[node].stream < streams.size() ? &streams[drives[node].stream] : nullptr;
}

}  // namespace

std::string welcome_message(const std::string& title, bool can_control, const std::string& view_token) {
  return text_of({{"type", "welcome"},
                  {"title", printable_text(title, kMaxListNameBytes)},
                  {"control", can_control},
                  {"view_token", view_token}});
}

std::string scene_message(const scene::Scene& scene, uint64_t scene_number) {
  const auto count = static_cast<uint32_t>(std::min(scene.nodes.size(), kMaxListedNodes));
  Json nodes = Json::array();
  for (uint32_t n = 0; n < count; ++n) {
    const scene::Node& node = scene.nodes[n];
    const int64_t parent = node.parent == scene::kNone ? -1 : int64_t{node.parent};
    nodes.push_back({shown_name(node.name, "node", n), parent, node.mesh != scene::kNone ? 1 : 0});
  }
  Json cameras = Json::array();
  const std::vector<uint32_t> camera_nodes = scene::camera_nodes(scene);
  for (const uint32_t n : camera_nodes) {
    if (cameras.size() == kMaxListedCameras) break;
    cameras.push_back(shown_name(scene.nodes[n].name, "camera", scene.nodes[n].camera));
  }
  const size_t cameras_omitted = camera_nodes.size() - cameras.size();
  return text_of({{"type", "scene"},
                  {"scene", scene_number},
                  {"nodes", std::move(nodes)},
                  {"omitted", scene.nodes.size() - count},
                  {"cameras", std::move(cameras)},
                  {"cameras_omitted", cameras_omitted}});
}

std::string viewers_message(const std::vector<ListedViewer>& viewers, uint64_t own) {
  Json listed = Json::array();
  for (const ListedViewer& viewer : viewers)
    listed.push_back(
        {{"number", viewer.number}, {"control", viewer.can_control}, {"own", viewer.number == own}});
  return text_of({{"type", "viewers"}, {"viewers", std::move(listed)}});
}

std::string camera_message(const scene::Scene& scene, uint32_t node) {
  const std::vector<uint32_t> nodes = scene::camera_nodes(scene);
  const auto known = std::ranges::find(nodes, node);
  return text_of(
      {{"type", "camera"}, {"index", known == nodes.end() ? Json() : Json(known - nodes.begin())}});
}

std::string visibility_message(const DocumentState& document, uint64_t scene_number) {
  return text_of(
      {{"type", "visibility"},
       {"scene", scene_number},
       {"hidden", document.edits.hidden},
       {"isolated", document.edits.isolated == scene::kNone ? Json() : Json(document.edits.isolated)}});
}

std::string view_message(const std::optional<CameraRig::FreeView>& view) {
  if (!view) return text_of({{"type", "view"}, {"position", nullptr}});
  const glm::quat& q = view->world_from_camera;
  return text_of({{"type", "view"},
                  {"position", {view->position_m.x, view->position_m.y, view->position_m.z}},
                  {"rotation", {q.x, q.y, q.z, q.w}},
                  {"distance", view->focus_distance_m},
                  {"fov", view->vertical_fov_rad}});
}

std::string settings_message(std::span<const settings::DrawSetting> table, const settings::DrawSettings& draw,
                             const std::function<bool(const settings::DrawSettings&)>& can_draw) {
  constexpr const char* kKinds[] = {"check", "choice", "slider", "color"};
  Json controls = Json::array();
  for (const settings::DrawSetting& row : table) {
    for (size_t i = 0; i < row.controls.size() && (row.users & settings::kByBrowser); ++i) {
      const settings::SettingControl& control = row.controls[i];
      if (!is_shown(row, control, draw)) continue;
      Json missing = Json::array();  // values that no renderer can have
      for (const std::string& value : control.values) {
        settings::DrawSettings wanted = draw;
        (void)control.set(value, wanted);
        if (row.invalidates == settings::Invalidates::renderer && !can_draw(wanted)) missing.push_back(value);
      }
      controls.push_back({{"setting", row.name},
                          {"control", i},
                          {"kind", kKinds[static_cast<size_t>(control.kind)]},
                          {"label", control.label},
                          {"hint", control.hint ? control.hint : ""},
                          {"value", control.text(draw)},
                          {"enabled", is_enabled(row, draw)},
                          {"names", control.names},
                          {"values", control.values},
                          {"missing", std::move(missing)},
                          {"range", {control.least, control.most}},
                          {"whole", row.kind == settings::SettingKind::count},
                          {"logarithmic", control.is_logarithmic}});
    }
  }
  return text_of({{"type", "settings"}, {"controls", std::move(controls)}});
}

std::string paths_message(const settings::PathProgress& progress, bool waits) {
  return text_of({{"type", "paths"},
                  {"samples", progress.samples},
                  {"samples_per_pixel", progress.samples_per_pixel},
                  {"waits", waits}});
}

std::string status_message(const state::PoseState& poses, double seconds,
                           std::map<uint64_t, uint64_t>& frames, const replay::TimelineControl* timeline) {
  std::map<uint64_t, uint64_t> now;
  Json streams = Json::array();
  for (const state::Stream& stream : poses.streams()) {
    if (!stream.active || streams.size() == kMaxStreams) continue;
    now[stream.epoch] = stream.frames_received;
    const PeerBudget::DrawCost cost = stream.budget() ? stream.budget()->draw_cost() : PeerBudget::DrawCost();
    const auto before = frames.find(stream.epoch);
    const uint64_t came = before == frames.end() || stream.frames_received < before->second
                              ? 0
                              : stream.frames_received - before->second;
    streams.push_back({{"name", printable_text(stream.name, kMaxListNameBytes)},
                       {"condition", state::condition_name(stream.condition)},
                       {"rate_hz", seconds > 0 ? static_cast<double>(came) / seconds : 0.0},
                       {"frames", stream.frames_received},
                       {"lost", stream.frames_incomplete},
                       {"nodes", stream.scene_node_of_pose.size()},
                       {"unmatched", stream.unmatched_names.size()},
                       {"sim_time_s", static_cast<double>(stream.header.sim_time_ns) * 1e-9}});
    if (cost.share > 0) streams.back()["drawing_share"] = cost.share;
    if (cost.is_hidden) streams.back()["content_hidden"] = true;
  }
  frames = std::move(now);
  Json message = {{"type", "status"}, {"streams", std::move(streams)}, {"scalars", ScalarList::count(poses)}};
  if (timeline) message["timeline"] = json_of(timeline->timeline());
  return text_of(message);
}

std::string picked_message(const char* type, const scene::Scene& scene, const state::PoseState& poses,
                           std::optional<uint32_t> node, uint64_t scene_number) {
  Json message = {{"type", type}, {"scene", scene_number}, {"node", nullptr}};
  if (!node || *node >= scene.nodes.size()) return text_of(message);
  const glm::mat4 pose = poses.world_from_node(*node);
  const state::Stream* const stream = driver_of(poses, *node);
  message["node"] = *node;
  message["name"] = shown_name(scene.nodes[*node].name, "node", *node);
  message["path"] = printable_text(scene.nodes[*node].path, 4 * kMaxListNameBytes);
  message["position_m"] = {pose[3].x, pose[3].y, pose[3].z};
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row) rows.push_back({pose[0][row], pose[1][row], pose[2][row], pose[3][row]});
  message["world_from_node"] = std::move(rows);
  message["stream"] = stream ? Json(printable_text(stream->name, kMaxListNameBytes)) : Json();
  return text_of(message);
}

std::string notice_message(const std::string& text) {
  return text_of({{"type", "notice"}, {"text", printable_text(text, 500)}});
}

}  // namespace fire3dv::app
