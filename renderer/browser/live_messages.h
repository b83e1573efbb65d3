// Messages to viewers of the live view, as JSON text. Names from files and peers become valid UTF-8.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocol/replay/replay_clock.h"
#include "renderer/camera/camera_rig.h"
#include "renderer/editing/view_state.h"
#include "renderer/scene/model/scene.h"
#include "renderer/settings/setting_table.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

constexpr size_t kMaxListedNodes = 20'000;
constexpr size_t kMaxListedCameras = 1000;

// "welcome": the first message. can_control: by the viewer's token. view_token: for links that may not
// control.
std::string welcome_message(const std::string& title, bool can_control, const std::string& view_token);
// "scene": names and parents of the first kMaxListedNodes nodes, and the first kMaxListedCameras cameras.
std::string scene_message(const scene::Scene& scene, uint64_t scene_number);
struct ListedViewer {
  uint64_t number = 0;
  bool can_control = false;
};
// "viewers": all viewers, by number; `own` has this number.
std::string viewers_message(const std::vector<ListedViewer>& viewers, uint64_t own);
// "camera": index of the viewer's camera among those of "scene", by its node; kNone: a free camera.
std::string camera_message(const scene::Scene& scene, uint32_t node);
// "visibility": hidden and isolated nodes.
std::string visibility_message(const DocumentState& document, uint64_t scene_number);
// "view": pose and lens of the viewer's free camera; none: it has a camera of the scene.
std::string view_message(const std::optional<CameraRig::FreeView>& view);
// "settings": controls of the rows that browsers may set, with their values in all images. can_draw: whether
// a renderer with other settings can be had.
std::string settings_message(std::span<const settings::DrawSetting> table, const settings::DrawSettings& draw,
                             const std::function<bool(const settings::DrawSettings&)>& can_draw);
// "paths": samples of the viewer's path-traced image; none: raster. waits: other views refine first.
std::string paths_message(const settings::PathProgress& progress, bool waits);
// "status": streams, with rates since the last call, their number of scalars, and the timeline. frames: whole
// frames by epoch at the last call; updated.
std::string status_message(const state::PoseState& poses, double seconds,
                           std::map<uint64_t, uint64_t>& frames, const replay::TimelineControl* timeline);
// "picked", "inspected": a node, its pose and the stream that drives it; nullopt: the background.
std::string picked_message(const char* type, const scene::Scene& scene, const state::PoseState& poses,
                           std::optional<uint32_t> node, uint64_t scene_number);
// "notice": one line for the user.
std::string notice_message(const std::string& text);

}  // namespace fire3dv::app
