// Tests of the messages to viewers of the live view: limits of lists, and the list of viewers.
#include "renderer/app/live/live_messages.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace fire3dv::app {
namespace {

using Json = nlohmann::json;

TEST(LiveMessages, ListsABoundedNumberOfNodesAndCameras) {
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

TEST(LiveMessages, ListsViewersAndMarksTheOwnOne) {
  const Json message = Json::parse(viewers_message({{3, true}, {8, false}}, 8));
  EXPECT_EQ(message, Json::parse(R"({"type": "viewers", "viewers": [
      {"number": 3, "control": true, "own": false}, {"number": 8, "control": false, "own": true}]})"));
}

}  // namespace
}  // namespace fire3dv::app
