// Comparison of a recording from AMBF 2.0 with the scene converted from the same files. AMBF ran the small
// scene of tests/assets/adf without a window (tests/assets/adf/recorded/README.md). The scene has a node for
// each recorded body, and its rest pose is the first recorded pose.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "convert/readers.h"
#include "protocol/record/playback.h"

namespace fire3dv {
namespace {

const std::filesystem::path kScene = std::filesystem::path(FIRE3DV_SOURCE_DIR) / "tests/assets/adf";

struct Recorded {
  wire::StreamDescription description;
  std::vector<wire::Affine3x4> first, last;  // world_from_body
  size_t frames = 0;
  double first_s = 0;
};

Recorded read_recording(const std::string& file) {
  Recorded recorded;
  auto source = record::open_source((kScene / "recorded" / file).string());
  EXPECT_TRUE(source.ok());
  if (!source) return recorded;
  auto playback = record::Playback::open(std::move(*source));
  EXPECT_TRUE(playback.ok());
  if (!playback) return recorded;
  wire::Decoder decoder;
  playback->rewind();
  record::Played played;
  record::Playback::Step step;
  while ((step = playback->next(played)) == record::Playback::Step::played) {
    const auto message = decoder.decode(played.message);
    EXPECT_TRUE(message.ok());
    if (!message) continue;
    if (const auto* description = std::get_if<wire::StreamDescription>(&*message))
      recorded.description = *description;
    const auto* frame = std::get_if<wire::PoseFrameView>(&*message);
    if (!frame || frame->poses.size() != recorded.description.node_names.size()) continue;
    recorded.last.assign(frame->poses.begin(), frame->poses.end());
    if (recorded.frames++ > 0) continue;
    recorded.first = recorded.last;
    recorded.first_s = static_cast<double>(frame->header.sim_time_ns) * 1e-9;
  }
  EXPECT_EQ(step, record::Playback::Step::end) << playback->problem();
  return recorded;
}

std::map<std::string, glm::dmat4> places_in(const convert::Model& model) {
  std::vector<glm::dmat4> world;
  std::map<std::string, glm::dmat4> places;
  for (const convert::Node& node : model.nodes) {
    glm::dmat4 local = glm::mat4_cast(node.rotation);
    for (int axis = 0; axis < 3; ++axis) local[axis] *= node.scale[axis];
    local[3] = glm::dvec4(node.translation, 1);
    world.push_back(node.parent ? world[*node.parent] * local : local);
    places[node.name] = world.back();
  }
  return places;
}

double largest_difference(const wire::Affine3x4& pose, const glm::dmat4& place) {
  double largest = 0;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      largest =
          std::max(largest, std::abs(pose.m[static_cast<size_t>(4 * row + column)] - place[column][row]));
  return largest;
}

TEST(AmbfRecording, ConvertedSceneMatchesAmbf) {
  convert::ReadOptions options;
  options.launch_indices = {0, 1, 2, 3};
  const auto model = convert::read_adf(kScene / "launch.yaml", options);
  ASSERT_TRUE(model.ok()) << model.error().message;
  const auto places = places_in(*model);
  const Recorded recorded = read_recording("ambf-2.0.mcap");
  ASSERT_EQ(recorded.description.node_names.size(), 24u);
  ASSERT_GT(recorded.frames, 20u);
  // AMBF creates a body that is listed but not described. It drops the parent of this ghost, whose collision
  // mesh is missing, so that the ghost stays at the world's origin.
  const std::set<std::string> ambf_alone = {"/ambf/env/parts/BODY nowhere described"};
  const std::set<std::string> elsewhere = {"/ambf/env/ghosts/GHOST marker"};
  // Distance fallen until the first frame, 5 ms after the start.
  const double fallen_m = 9.81 * recorded.first_s * recorded.first_s / 2 + 1e-4;
  size_t compared = 0, fell = 0;
  for (size_t i = 0; i < recorded.description.node_names.size(); ++i) {
    const std::string& name = recorded.description.node_names[i];
    const auto place = places.find(name);
    EXPECT_EQ(place == places.end(), ambf_alone.contains(name)) << name;
    if (place == places.end() || elsewhere.contains(name)) continue;
    EXPECT_LT(largest_difference(recorded.first[i], place->second), fallen_m) << name;
    fell += largest_difference(recorded.last[i], place->second) > 1;
    ++compared;
  }
  EXPECT_EQ(compared, 22u);
  EXPECT_EQ(fell, 19u) << "all but the floor, a lamp and a camera, which stand";
}

}  // namespace
}  // namespace fire3dv
