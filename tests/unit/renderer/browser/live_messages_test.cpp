// Tests of the messages to viewers of the live view: limits of lists, and the list of viewers.
#include "renderer/browser/live_messages.h"

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace fire3dv::app {
namespace {

using Json = nlohmann::json;

TEST(LiveMessages, NodesAndCamerasAreBounded) {
  scene::Scene scene;
  scene.nodes.resize(kMaxListedNodes + 5);
  scene.cameras.resize(kMaxListedCameras + 7);
  for (uint32_t i = 0; i < scene.cameras.size(); ++i) scene.nodes[i].camera = i;
  scene.nodes[1].name = "front\xff\n";
  const Json message = Json::parse(scene_message(scene, 1));
  EXPECT_EQ(message["nodes"].size(), kMaxListedNodes);
  EXPECT_EQ(message["omitted"], 5);
  ASSERT_EQ(message["cameras"].size(), kMaxListedCameras);
  EXPECT_EQ(message["cameras_omitted"], 7);
  EXPECT_EQ(message["cameras"][0], "camera 0");
  EXPECT_EQ(message["cameras"][1], "front??");

  scene.nodes.resize(3);
  scene.cameras.resize(3);
  const Json small = Json::parse(scene_message(scene, 1));
  EXPECT_EQ(small["cameras"].size(), 3u);
  EXPECT_EQ(small["cameras_omitted"], 0);
}

TEST(LiveMessages, OwnViewerIsMarked) {
  const Json message = Json::parse(viewers_message({{3, true}, {8, false}}, 8));
  EXPECT_EQ(message, Json::parse(R"({"type": "viewers", "viewers": [
      {"number": 3, "control": true, "own": false}, {"number": 8, "control": false, "own": true}]})"));
}

TEST(LiveMessages, FreeViewComesBackUnchanged) {
  scene::Scene scene;
  scene.bounds_min = glm::vec3(-1);
  scene.bounds_max = glm::vec3(1);
  CameraRig camera = *CameraRig::create(scene);
  EXPECT_FALSE(camera.free_view()) << "no image has placed it yet";
  EXPECT_EQ(Json::parse(view_message({}))["position"], nullptr);
  const glm::quat turned = glm::angleAxis(1.0f, glm::normalize(glm::vec3(1, 2, 3)));
  camera.set_free_view({{1, 2, 3}, turned, 4, 0.5f});
  const state::PoseState poses(scene);
  const CameraRig::Placed placed = camera.placed(poses, 1);
  EXPECT_FLOAT_EQ(placed.camera.vertical_fov_rad, 0.5f);
  EXPECT_EQ(glm::vec3(placed.world_from_camera[3]), glm::vec3(1, 2, 3));
  const glm::vec3 right = turned * glm::vec3(1, 0, 0);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(placed.world_from_camera[0][i], right[i], 1e-6f);
  const Json message = Json::parse(view_message(camera.free_view()));
  EXPECT_EQ(message["position"], Json({1, 2, 3}));
  EXPECT_EQ(message["distance"], 4);
  EXPECT_EQ(message["fov"], 0.5);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(message["rotation"][static_cast<size_t>(i)], turned[i], 1e-6f);
}

// Controls of a message by the names of their settings; all of these settings have one.
std::map<std::string, Json> controls_of(const std::string& text) {
  const Json message = Json::parse(text);
  std::map<std::string, Json> controls;
  for (const Json& control : message["controls"]) controls[control["setting"]] = control;
  return controls;
}

TEST(LiveMessages, SettingsOfBrowsersAreSent) {
  settings::DrawSettings settings;
  settings.post.tone_map = settings::ToneMap::neutral;
  const auto can_all = [](const settings::DrawSettings&) { return true; };
  auto controls = controls_of(settings_message(settings::draw_setting_table(), settings, can_all));
  for (const settings::DrawSetting& row : settings::draw_setting_table())
    EXPECT_EQ(controls.count(row.name), row.users & settings::kByBrowser ? 1u : 0u) << row.name;
  EXPECT_EQ(controls["tone-map"],
            Json::parse(R"({"setting": "tone-map", "control": 0, "kind": "choice", "label": "Tone mapping",
                            "hint": "", "value": "neutral", "enabled": true, "missing": [],
                            "names": ["Reinhard", "ACES", "neutral", "none"],
                            "values": ["reinhard", "aces", "neutral", "none"], "range": [0, 1],
                            "whole": false, "logarithmic": false})"));
  settings.shadows.method = settings::ShadowMethod::off;
  const auto can_raster = [](const settings::DrawSettings& wanted) { return !wanted.path; };
  controls = controls_of(settings_message(settings::draw_setting_table(), settings, can_raster));
  EXPECT_EQ(controls["shadows"]["value"], "off");
  EXPECT_EQ(controls["shadows"]["missing"], Json::array());
  EXPECT_EQ(controls["render"]["missing"], Json({"path"}));
  settings.path.emplace();
  controls = controls_of(settings_message(settings::draw_setting_table(), settings, can_all));
  EXPECT_EQ(controls["render"]["value"], "path");
  EXPECT_EQ(controls["shadows"]["enabled"], false);
  EXPECT_EQ(controls["tone-map"]["enabled"], true);
}

TEST(LiveMessages, RowsForBrowsersNeedNoCode) {
  std::vector<settings::DrawSetting> table{settings::draw_setting("saturation"),
                                           settings::draw_setting("background")};
  for (settings::DrawSetting& row : table) row.users |= settings::kByBrowser;
  settings::DrawSettings settings;
  settings.background.color = glm::vec3(1);
  const Json message = Json::parse(settings_message(table, settings, nullptr));
  ASSERT_EQ(message["controls"].size(), 4u) << "no zenith";
  EXPECT_EQ(message["controls"][0]["kind"], "slider");
  EXPECT_EQ(message["controls"][0]["value"], "1");
  EXPECT_EQ(message["controls"][0]["range"], Json({0, 2}));
  EXPECT_EQ(message["controls"][1]["kind"], "check");
  EXPECT_EQ(message["controls"][3]["kind"], "color");
  EXPECT_EQ(message["controls"][3]["value"], "ffffff");
  EXPECT_EQ(message["controls"][3]["control"], 2);
}

TEST(LiveMessages, PathsReportTheirSamples) {
  EXPECT_EQ(Json::parse(paths_message({12, 256}, true)),
            Json::parse(R"({"type": "paths", "samples": 12, "samples_per_pixel": 256, "waits": true})"));
}

}  // namespace
}  // namespace fire3dv::app
