// Test of the randomisation of data sets: the file's errors, the distributions, and what is changed in a
// scene.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "renderer/dataset/randomize/randomizer.h"
#include "renderer/dataset/randomize/settle.h"
#include "renderer/state/edits/node_transform.h"

namespace fire3dv::dataset {
namespace {

std::string error_of(const std::string& text) {
  const auto plan = parse_plan(text, "r.yaml");
  return plan ? std::string() : plan.error().message;
}

TEST(Plan, ErrorsNameLineAndField) {
  const struct {
    const char* text;
    const char* error;
  } kCases[] = {
      {"nodes:\n  a:\n    scale: [2, 1]\n",
       "r.yaml:3: nodes.a.scale: [2, 1] is no range: the smaller number comes first"},
      {"nodes:\n  a:\n    size: 1\n",
       "r.yaml:3: nodes.a.size: no such field of nodes: there are position_m, move_m,"},
      {"lamps: {}\n", "r.yaml:1: lamps: no such section: there are cameras, nodes, materials, lights,"},
      {"nodes:\n  a: {scale: 1, scale: 2}\n", "nodes.a.scale: is there twice"},
      {"nodes: {a: {scale: big}}\n", "nodes.a.scale: needs a number, and not \"big\""},
      {"nodes: {a: {scale: .nan}}\n", "nodes.a.scale: needs a number"},
      {"nodes: {a: {scale: 1e9}}\n", "nodes.a.scale: 1000000000 is outside of 0.001 to 1000"},
      {"nodes: {a: {scale: [1, 2, 3]}}\n", "nodes.a.scale: a range is [LEAST, MOST]"},
      {"nodes: {a: {scale: {gauss: [1, 2]}}}\n",
       "nodes.a.scale: needs a number, a range [LEAST, MOST], or one of"},
      {"cameras: {a: {noise: {log: [0, 2]}}}\n", "cameras.a.noise: log needs numbers above 0"},
      {"cameras: {a: {noise: {normal: [1, -2]}}}\n", "cameras.a.noise: -2 is outside of 0 to"},
      {"cameras: {a: {noise: {choice: []}}}\n", "cameras.a.noise: choice is a list of numbers"},
      {"nodes: {a: {move_m: [1, 2]}}\n", "nodes.a.move_m: needs three values"},
      {"nodes: {a: {move_m: {choice: [[1, 2]]}}}\n", "nodes.a.move_m: a choice here is [A, B, C]"},
      {"nodes: {a: {rotation: [0, 1]}}\n", "nodes.a.rotation: must be uniform"},
      {"nodes: {a: {rotation: uniform, turn_deg: [0, 0, 0]}}\n", "rotation and turn_deg: choose one of them"},
      {"cameras: {a: {distance_m: 1, azimuth_deg: 0, elevation_deg: 0}}\n",
       "cameras.a: distance_m and azimuth_deg and elevation_deg need look_at"},
      {"cameras: {a: {azimuth_deg: 0}}\n",
       "cameras.a: azimuth_deg needs look_at, distance_m and elevation_deg"},
      {"cameras: {a: {look_at: b, distance_m: 1}}\n",
       "cameras.a: distance_m needs azimuth_deg and elevation_deg"},
      {"cameras: {a: {position_m: [0, 0, 0], distance_m: 1, path_at: 0, f_number: 2}}\n",
       "cameras.a: distance_m needs look_at, azimuth_deg and elevation_deg; position_m and distance_m: "
       "choose "
       "one of them; path_at needs path; f_number needs focus_distance_m, or look_at to focus on"},
      {"cameras: {a: {f_number: 2}}\n", "cameras.a: f_number needs focus_distance_m, or look_at to focus on"},
      {"cameras: {a: {path: x, position_m: [0, 0, 0]}}\n", "cameras.a: path and position_m: choose one"},
      {"scene: {variant: {choice: [[a]]}}\n", "scene.variant: a choice here is a text"},
      {"nodes: {a: {settle: 1}}\n", "nodes.a.settle: must be true or false"},
      {"materials: {a: {base_color_texture: []}}\n", "materials.a.base_color_texture: needs a text"},
      {"materials: {a: {base_color_texture: {files: a}}}\n",
       "needs a file, {choice: [A, B]}, or {folder: DIR}"},
      {"distractors: {files: a.glb}\n", "distractors: needs count"},
      {"distractors: {files: a.glb, count: 1, copies: 1.5}\n", "copies must be a whole number"},
      {"nodes: [a]\n", "r.yaml:1: nodes: a section is a map"},
      {"nodes: {a: 1}\n", "nodes.a: an object is a map"},
      {"nodes: {[a]: {}}\n", "nodes: a name is text"},
      {"", "r.yaml: the file is empty"},
      {"nodes: {a: {scale: [1, 2}\n", "cannot be read as YAML"},
      {"nodes: {a: {mvoe_m: 1}}\n", "did you mean move_m?"},
      {"nodes:\n  *: {scale: 1}\n", "r.yaml:2: a name with * stands in quotes, as in \"*\": or \"*_screw\":"},
      {"nodes:\n  a: {scale: 1}\n  *_screw: {scale: 1}\n", "r.yaml:3: a name with * stands in quotes"},
      {"nodes: {*: {scale: 1}}\n", "r.yaml:1: a name with * stands in quotes"},
      {"nodes: {\"*\": [1, 2}\n", "cannot be read as YAML"},
  };
  for (const auto& each : kCases)
    EXPECT_NE(error_of(each.text).find(each.error), std::string::npos) << each.text << error_of(each.text);
  EXPECT_NE(error_of("nodes: " + std::string(20'000, '[')).find("r.yaml"), std::string::npos);
  // Aliases repeat: the numbers of a small file are limited all the same.
  std::string bomb = "nodes:\n  a: &a {scale: {choice: [";
  for (int i = 0; i < 1000; ++i) bomb += "1,";
  bomb += "1]}}\n";
  for (int i = 0; i < 200; ++i) bomb += "  b" + std::to_string(i) + ": *a\n";
  EXPECT_NE(error_of(bomb).find("the file has more than 100000 numbers"), std::string::npos)
      << error_of(bomb);
}

TEST(Plan, PatternsMatch) {
  EXPECT_TRUE(matches("*", ""));
  EXPECT_TRUE(matches("a*c", "abbc"));
  EXPECT_TRUE(matches("a*b*", "aabc"));
  EXPECT_FALSE(matches("a*c", "abcd"));
  EXPECT_FALSE(matches("a", "ab"));
  EXPECT_FALSE(matches("ab", "a"));
}

// Mean and mean square of many draws.
struct Moments {
  double mean = 0, square = 0, least = INFINITY, most = -INFINITY;
};
Moments moments_of(const Distribution& distribution, int count = 40'000) {
  Moments moments;
  for (int i = 0; i < count; ++i) {
    const double value = ParameterDraw(7, static_cast<uint64_t>(i), "p").number(distribution);
    moments.mean += value / count;
    moments.square += value * value / count;
    moments.least = std::min(moments.least, value);
    moments.most = std::max(moments.most, value);
  }
  return moments;
}

TEST(Draw, HasTheDistribution) {
  using Kind = Distribution::Kind;
  const Moments uniform = moments_of({Kind::uniform, -1, 3, {}, 0, 0});
  EXPECT_NEAR(uniform.mean, 1, 0.02);
  EXPECT_NEAR(uniform.square, 1 + 16.0 / 12, 0.04);
  EXPECT_GE(uniform.least, -1);
  EXPECT_LT(uniform.most, 3);
  const Moments log = moments_of({Kind::log_uniform, 0.01, 100, {}, 0, 0});
  EXPECT_NEAR(log.mean, (100 - 0.01) / std::log(1e4), 0.4);
  const Moments normal = moments_of({Kind::normal, 2, 0.5, {}, -10, 10});
  EXPECT_NEAR(normal.mean, 2, 0.01);
  EXPECT_NEAR(normal.square - 4, 0.25, 0.03);
  const Moments clamped = moments_of({Kind::normal, 0, 1, {}, 0, 1});
  EXPECT_EQ(clamped.least, 0);
  EXPECT_EQ(clamped.most, 1);
  // Even over the sphere: the mean of the height is that of a uniform number.
  double height = 0;
  for (uint64_t i = 0; i < 40'000; ++i)
    height +=
        std::sin(glm::radians(ParameterDraw(1, i, "e").number({Kind::elevation, 0, 90, {}, 0, 0}))) / 40'000;
  EXPECT_NEAR(height, 0.5, 0.005);
  const Moments choice = moments_of({Kind::choice, 0, 0, {1, 2, 6}, 0, 0});
  EXPECT_NEAR(choice.mean, 3, 0.05);
  // Rotated axes point everywhere.
  glm::dvec3 mean(0), square(0);
  for (uint64_t i = 0; i < 40'000; ++i) {
    const glm::dvec3 axis = ParameterDraw(1, i, "r").rotation() * glm::dvec3(0, 0, 1);
    EXPECT_NEAR(glm::length(axis), 1, 1e-12);
    mean += axis / 40'000.0;
    square += axis * axis / 40'000.0;
  }
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(mean[i], 0, 0.01);
    EXPECT_NEAR(square[i], 1.0 / 3, 0.01);
  }
}

TEST(Draw, DependsOnSeedFrameAndNameAlone) {
  const auto draw = [](uint64_t seed, uint64_t frame, const char* name) {
    return ParameterDraw(seed, frame, name).unit();
  };
  EXPECT_EQ(draw(1, 2, "a"), draw(1, 2, "a"));
  EXPECT_NE(draw(1, 2, "a"), draw(2, 2, "a"));
  EXPECT_NE(draw(1, 2, "a"), draw(1, 3, "a"));
  EXPECT_NE(draw(1, 2, "a"), draw(1, 2, "b"));
  EXPECT_NE(draw(1, 2, "a"), draw(2, 1, "a"));
}

TEST(Noise, HasTheDeviation) {
  std::vector<uint8_t> image(size_t{4} * 20'000, 100), other = image;
  add_noise(image, 5, 1, 2);
  add_noise(other, 5, 1, 3);
  EXPECT_NE(image, other);
  double mean = 0, square = 0, product = 0;
  for (size_t i = 0; i < image.size(); ++i) {
    if (i % 4 == 3) {
      EXPECT_EQ(image[i], 100);
      continue;
    }
    mean += (image[i] - 100.0) / 60'000;
    square += (image[i] - 100.0) * (image[i] - 100.0) / 60'000;
    if (i % 4 == 0) product += (image[i] - 100.0) * (image[i + 1] - 100.0) / 20'000;
  }
  EXPECT_NEAR(mean, 0, 0.1);
  EXPECT_NEAR(square, 25 + 1.0 / 12, 0.5);
  EXPECT_NEAR(product, 0, 0.6);  // channels are independent
}

TEST(TrajectoryFile, ErrorsNameTheLine) {
  const std::string path = ::testing::TempDir() + "randomize_test_path.txt";
  const auto read = [&](const std::string& text) {
    std::ofstream(path, std::ios::trunc) << text;
    const auto trajectory = read_trajectory(path);
    return trajectory ? std::to_string(trajectory->poses.size()) : trajectory.error().message;
  };
  EXPECT_EQ(read("# comment\n1 0 0 0 0 0 0 1\n\n2 0 0 0 0 0 0 1 # more\n"), "2");
  EXPECT_NE(read("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0\n").find("line 2: a pose is TIME X Y Z"), std::string::npos);
  EXPECT_NE(read("1 0 0 0 0 0 0 1 5\n").find("line 1: a pose is TIME X Y Z"), std::string::npos);
  EXPECT_NE(read("1 0 0 nan 0 0 0 1\n").find("line 1: a pose is TIME X Y Z"), std::string::npos);
  EXPECT_NE(read("1 0 0 0 0 0 0 2\n").find("line 1: the quaternion has not the length 1"), std::string::npos);
  EXPECT_NE(read("1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n").find("line 2: times must ascend"), std::string::npos);
  EXPECT_NE(read("#\n").find("has no poses"), std::string::npos);
  ASSERT_EQ(read("5 1 2 3 0 0 0 1\n"), "1");
  const glm::dmat4 pose = read_trajectory(path)->at(0.7);
  EXPECT_EQ(pose[3], glm::dvec4(1, 2, 3, 1));
  EXPECT_EQ(pose[2], glm::dvec4(0, 0, -1, 0));  // OpenCV's z is forward, glTF's backward
}

// Corners of a box.
Hull box_of(const glm::vec3& half) {
  Hull points;
  for (int i = 0; i < 8; ++i)
    points.push_back(half * glm::vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
  return points;
}

// A floor at this height, 4 m wide.
FixedTriangles floor_at(float height) {
  return {{{-2, height, -2}, {-2, height, 2}, {2, height, 2}, {2, height, -2}}, {0, 1, 2, 0, 2, 3}};
}

double lowest_of(const RestingBody& body, const Hull& hull) {
  double lowest = INFINITY;
  for (const glm::vec3& point : hull)
    lowest = std::min(lowest, (body.position_m + body.rotation * glm::dvec3(point)).y);
  return lowest;
}

TEST(Settle, HullsKeepTheCornersOfBoxes) {
  std::vector<glm::vec3> points = box_of({1, 2, 3});
  for (int i = -9; i < 10; ++i) points.emplace_back(0.1f * static_cast<float>(i), 2, 1);  // on a face
  EXPECT_EQ(hull_of(points).size(), 8u);
  EXPECT_TRUE(hull_of({}).empty());
  std::vector<glm::vec3> ball;
  for (int i = 0; i < 20'000; ++i) {
    const float y = 1 - 2 * (static_cast<float>(i) + 0.5f) / 20'000, around = 2.4f * static_cast<float>(i);
    ball.push_back(
        glm::vec3(std::sqrt(1 - y * y) * std::cos(around), y, std::sqrt(1 - y * y) * std::sin(around)));
  }
  const Hull hull = hull_of(ball);
  EXPECT_LE(hull.size(), kMaxHullPoints);
  for (const glm::vec3& direction : ball) {
    float most = 0;
    for (const glm::vec3& point : hull) most = std::max(most, glm::dot(point, direction));
    ASSERT_GT(most, 0.99f);
  }
}

TEST(Settle, BoxesRestOnTheFloorAndOnEachOther) {
  const Hull flat = box_of({0.05f, 0.004f, 0.05f});
  Hull small = box_of(glm::vec3(0.01f));
  const glm::dvec3 beside(0.03, 0.02, 0.01);  // of its origin
  for (glm::vec3& point : small) point += glm::vec3(beside);
  std::vector<FallingBody> bodies(2);
  bodies[0] = {{flat}, glm::angleAxis(0.3, glm::dvec3(1, 0, 0)), {0, 0.7, 0}};
  const glm::dquat turned = glm::angleAxis(0.2, glm::dvec3(0, 0, 1));
  bodies[1] = {{small}, turned, glm::dvec3(0.002, 0.8, 0.001) - turned * beside};
  const FixedTriangles floor = floor_at(0.5f);
  const auto resting = settle(floor, bodies);
  ASSERT_TRUE(resting.ok()) << resting.error().message;
  for (const RestingBody& body : *resting) EXPECT_TRUE(body.is_at_rest && !body.has_fallen);
  EXPECT_NEAR(lowest_of((*resting)[0], flat), 0.5, 0.001);
  EXPECT_NEAR(lowest_of((*resting)[1], small), 0.508, 0.001) << "on the flat one";
  for (const RestingBody& body : *resting) {
    const glm::dmat3 axes = glm::mat3_cast(body.rotation);
    double upright = 0;
    for (int i = 0; i < 3; ++i) upright = std::max(upright, std::abs(axes[i].y));
    EXPECT_GT(upright, std::cos(0.02)) << "a face lies on what is below";
  }
  // The same, whatever was settled before.
  const auto again = settle(floor, bodies);
  ASSERT_TRUE(settle(floor, std::span(bodies).first(1)).ok());
  const auto third = settle(floor, bodies);
  for (size_t i = 0; i < bodies.size(); ++i) {
    EXPECT_TRUE((*again)[i].position_m == (*resting)[i].position_m);
    EXPECT_TRUE((*third)[i].rotation == (*resting)[i].rotation);
  }
}

TEST(Settle, BodiesOutsideKeepTheirPlace) {
  const std::vector<FallingBody> bodies{{{box_of(glm::vec3(0.1f))}, {1, 0, 0, 0}, {5, 1, 0}}};
  const auto beside = settle(floor_at(0), bodies), nowhere = settle({}, bodies);
  for (const auto* resting : {&beside, &nowhere}) {
    ASSERT_TRUE(resting->ok());
    EXPECT_TRUE((**resting)[0].has_fallen);
    EXPECT_EQ((**resting)[0].position_m, glm::dvec3(5, 1, 0));
  }
  EXPECT_FALSE(
      settle(floor_at(0), std::vector<FallingBody>{{{Hull{{1, 1, 1}}}, {1, 0, 0, 0}, {0, 1, 0}}}).ok());
  EXPECT_TRUE(settle({}, {}).ok());
}

class Randomized : public ::testing::Test {
 protected:
  Randomized() {
    for (const char* name : {"parent", "a", "a", "lamp"}) {
      scene::Node node;
      node.name = name;
      node.path = scene_.nodes.empty() ? name : std::string("parent/") + name;
      if (!scene_.nodes.empty()) node.parent = 0;
      scene_.nodes.push_back(node);
    }
    scene_.nodes[0].parent_from_node[3] = glm::vec4(1, 2, 3, 1);
    scene_.nodes[1].translation = glm::vec3(0, 5, 0);
    scene_.nodes[1].parent_from_node[3] = glm::vec4(0, 5, 0, 1);
    for (scene::Node& node : scene_.nodes)
      node.world_from_node = node.parent == scene::kNone
                                 ? node.parent_from_node
                                 : scene_.nodes[node.parent].world_from_node * node.parent_from_node;
    scene_.lights.emplace_back();
    scene_.nodes[3].light = 0;
    scene_.materials.resize(3);
    scene_.materials[1].name = "steel";
    scene_.materials[1].base_color = glm::vec4(1, 1, 1, 0.5f);
  }

  void begin(const std::string& text, std::vector<std::string> cameras = {"front", "side"}) {
    auto plan = parse_plan(text, "r.yaml");
    ASSERT_TRUE(plan.ok()) << plan.error().message;
    plan_ = std::move(*plan);
    plan_.seed = 3;
    randomizer_.emplace(plan_, cameras);
    auto good = randomizer_->set_scene(scene_, settings_);
    ASSERT_TRUE(good.ok()) << good.error().message;
  }

  state::UserEdits change(uint64_t frame) {
    state::UserEdits edits;
    draw_ = settings_;
    EXPECT_TRUE(randomizer_->change_frame(frame, edits, draw_).ok());
    return edits;
  }

  scene::Scene scene_;
  Plan plan_;
  settings::DrawSettings settings_, draw_;
  std::optional<Randomizer> randomizer_;
};

TEST_F(Randomized, NodesMove) {
  begin("nodes:\n  a: {move_m: [[1, 2], 0, 0], scale: 2}\n  \"parent/*\": {turn_deg: [0, 0, 90]}\n");
  const state::UserEdits edits = change(0);
  ASSERT_EQ(edits.transforms.size(), 3u);  // both of the name, and the lamp by its path
  const glm::mat4 pose = state::parent_from_node(edits.transforms.at(1));
  EXPECT_GE(pose[3].x, 1);
  EXPECT_LT(pose[3].x, 2);
  EXPECT_FLOAT_EQ(pose[3].y, 5);
  EXPECT_NEAR(pose[0].y, 2, 1e-6);  // x points along y, twice as long
  const DrawnValues drawn = randomizer_->drawn();
  std::vector<std::string> names;
  for (const auto& [name, values] : drawn) names.push_back(name);
  EXPECT_EQ(names, (std::vector<std::string>{"nodes.a.move_m", "nodes.a.turn_deg", "nodes.a.scale",
                                             "nodes.a#2.move_m", "nodes.a#2.turn_deg", "nodes.a#2.scale",
                                             "nodes.lamp.turn_deg"}));
  EXPECT_FLOAT_EQ(pose[3].x, static_cast<float>(drawn[0].second.numbers[0]));
  EXPECT_NE(drawn[0].second.numbers[0], drawn[3].second.numbers[0]);
  // A frame is the same whatever was drawn before it.
  const state::UserEdits later = change(9);
  EXPECT_FALSE(later == edits);
  EXPECT_TRUE(change(0) == edits);
}

TEST_F(Randomized, TitlesAreTheirOwn) {
  scene_.nodes[3].name = "a#2";
  begin("nodes: {\"a*\": {scale: [1, 2]}}\n");
  change(0);
  std::set<std::string> names;
  for (const auto& [name, values] : randomizer_->drawn()) names.insert(name);
  EXPECT_EQ(names, (std::set<std::string>{"nodes.a.scale", "nodes.a#2.scale", "nodes.a#2#2.scale"}));
}

TEST_F(Randomized, GivenValuesOfAFrameAgree) {
  auto plan = parse_plan("nodes: {parent: {scale: [1, 2]}}\n", "r.yaml");
  ASSERT_TRUE(plan.ok());
  plan->given.file = "draws.jsonl";
  plan->given.images[0]["nodes.parent.scale"] = {{1.5}, {}};
  plan->given.images[1]["nodes.parent.scale"] = {{1.25}, {}};
  EXPECT_TRUE(Randomizer(*plan, {"front"}).set_scene(scene_, settings_).ok());
  const auto good = Randomizer(*plan, {"front", "side"}).set_scene(scene_, settings_);
  ASSERT_FALSE(good.ok());
  EXPECT_NE(good.error().message.find("differs from the value of another image of its frame"),
            std::string::npos)
      << good.error().message;
}

TEST_F(Randomized, ObjectsAreDrawnAlone) {
  begin("nodes: {a: {scale: [1, 2]}}\n");
  const auto alone = change(4).transforms.at(1);
  begin("materials: {steel: {roughness: [0, 1]}}\nnodes: {parent: {visible: 0.5}, a: {scale: [1, 2]}}\n");
  EXPECT_TRUE(change(4).transforms.at(1) == alone);
}

TEST_F(Randomized, MaterialsLightsAndSettingsChange) {
  begin(
      "materials: {\"*\": {roughness: [0.2, 0.3]}, steel: {base_color: {choice: [[0.1, 0.2, 0.3]]}, "
      "roughness: 1}}\n"
      "lights: {lamp: {intensity: {log: [10, 100]}, on: 1}}\n"
      "environment: {intensity: 2, rotation_deg: 90}\n"
      "background: {color: [0.25, 0.5, 1]}\n");
  const state::UserEdits edits = change(1);
  ASSERT_EQ(edits.materials.size(), 3u);
  EXPECT_EQ(edits.materials.at(1).base_color, glm::vec4(0.1f, 0.2f, 0.3f, 0.5f));
  EXPECT_EQ(edits.materials.at(1).roughness, 1);
  EXPECT_LT(edits.materials.at(2).roughness, 0.3f);
  EXPECT_GE(edits.lights.at(3).intensity, 10);
  EXPECT_EQ(draw_.environment_intensity, 2);
  EXPECT_NEAR(draw_.environment_rotation_rad, glm::radians(90.0f), 1e-6);
  EXPECT_EQ(draw_.background.color, glm::vec3(0.25f, 0.5f, 1));
  begin("lights: {lamp: {on: 0}}\nnodes: {parent: {visible: 0}}\n");
  EXPECT_EQ(change(1).lights.at(3).intensity, 0);
  EXPECT_EQ(change(1).hidden, std::set<uint32_t>{0});
}

TEST_F(Randomized, LightsArePlacedInTheWorld) {
  begin("lights: {lamp: {look_at: [0, 1, 0], distance_m: 4, azimuth_deg: 90, elevation_deg: 0}}\n");
  change(0);
  state::NodeTransforms transforms;
  const auto added = randomizer_->add_transforms(state::PoseState(scene_), transforms);
  ASSERT_TRUE(added.ok() && *added);
  EXPECT_FALSE(*randomizer_->add_transforms(state::PoseState(scene_), transforms)) << "once a frame";
  const glm::mat4 pose = scene_.nodes[0].world_from_node * state::parent_from_node(transforms.at(3));
  EXPECT_NEAR(glm::distance(glm::vec3(pose[3]), glm::vec3(4, 1, 0)), 0, 1e-5);
  EXPECT_NEAR(glm::distance(-glm::vec3(pose[2]), glm::vec3(-1, 0, 0)), 0, 1e-5);  // it shines at the target
  EXPECT_TRUE(change(0).lights.empty()) << "a light that is placed alone keeps its stream's looks";
  begin("nodes: {a: {scale: 2}}\n");
  change(0);
  EXPECT_FALSE(*randomizer_->add_transforms(state::PoseState(scene_), transforms));
  // A place of the world cannot follow a parent that is placed, too.
  scene_.nodes[0].light = 0;
  const auto plan = parse_plan("lights: {\"*\": {position_m: [0, 1, 0]}}\n", "r.yaml");
  ASSERT_TRUE(plan.ok());
  const auto good = Randomizer(*plan, {"front"}).set_scene(scene_, settings_);
  ASSERT_FALSE(good.ok());
  EXPECT_EQ(good.error().message,
            "r.yaml:1: lights: \"parent/lamp\" lies below a light that is placed, too: place one of them");
}

TEST_F(Randomized, TargetsAreSingleNodes) {
  const auto plan = parse_plan("cameras: {front: {look_at: a}}\n", "r.yaml");
  ASSERT_TRUE(plan.ok());
  const auto good = Randomizer(*plan, {"front"}).set_scene(scene_, settings_);
  ASSERT_FALSE(good.ok());
  EXPECT_EQ(good.error().message,
            "r.yaml:1: cameras.front.look_at: the scene has no single node \"a\": write its name or path, or "
            "[x, y, z]; several have it");
}

TEST_F(Randomized, CamerasLookAtNodes) {
  begin(
      "cameras:\n  front: {look_at: parent, look_at_offset_m: [0, 1, 0], distance_m: [2, 3], azimuth_deg: "
      "[0, 90],"
      " elevation_deg: 30, roll_deg: 10, fov_deg: 40, exposure_ev: 1, noise: 3}\n");
  change(2);
  const state::PoseState poses(scene_);
  app::CameraRig::Placed camera{{}, glm::mat4(1)}, other = camera;
  randomizer_->change_camera(4, poses, camera);
  const glm::vec3 eye(camera.world_from_camera[3]), target(1, 3, 3);
  const DrawnValues drawn = randomizer_->drawn();
  ASSERT_EQ(drawn[0].first, "cameras.front.look_at_offset_m");
  ASSERT_EQ(drawn[1].first, "cameras.front.distance_m");
  EXPECT_NEAR(glm::distance(eye, target), drawn[1].second.numbers[0], 1e-5);
  EXPECT_NEAR(eye.y - target.y, drawn[1].second.numbers[0] * 0.5, 1e-5);
  EXPECT_NEAR(glm::dot(glm::normalize(target - eye), -glm::vec3(camera.world_from_camera[2])), 1, 1e-6);
  // The right axis is level without roll.
  EXPECT_NEAR(camera.world_from_camera[0].y, std::sin(glm::radians(10.0)) * std::cos(glm::radians(30.0)),
              1e-5);
  EXPECT_NEAR(camera.camera.vertical_fov_rad, glm::radians(40.0), 1e-6);
  EXPECT_NEAR(camera.camera.exposure, 2 * settings_.post.exposure, 1e-6);
  EXPECT_EQ(randomizer_->noise(), 3);
  randomizer_->change_camera(5, poses, other);  // "side" has no fields
  EXPECT_EQ(other.world_from_camera, glm::mat4(1));
  EXPECT_EQ(randomizer_->noise(), 0);
}

TEST_F(Randomized, UnknownNamesAreNamed) {
  const auto plan =
      parse_plan("cameras: {x: {}}\nnodes:\n  b*: {}\nlights: {a: {}}\nmaterials: {gold: {}}\n", "r.yaml");
  ASSERT_TRUE(plan.ok());
  std::vector<std::string> texts;
  for (const auto& each : Randomizer::unmatched(*plan, scene_, {"front"})) {
    texts.push_back(each.text);
    EXPECT_EQ(each.is_pattern, each.text.find("b*") != std::string::npos);
  }
  EXPECT_EQ(texts,
            (std::vector<std::string>{
                "r.yaml:1: cameras: no camera of the set has the name \"x\"; there is \"front\"",
                "r.yaml:3: nodes: no node has the name \"b*\"; did you mean \"a\"?",
                "r.yaml:5: materials: no material has the name \"gold\"; there are \"#0\", \"#2\", \"steel\"",
                "r.yaml:4: lights: no node with a light has the name \"a\"; there is \"lamp\""}));
}

}  // namespace
}  // namespace fire3dv::dataset
