// MuJoCo's end of a stream: poses are those of mjData, nodes are those of the scene, rates and resets are
// what was asked for, and what MuJoCo gives up on ends nothing but the call.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <future>
#include <map>
#include <optional>
#include <span>

#include "adapters/mujoco/image_names.h"
#include "adapters/mujoco/pace.h"
#include "adapters/mujoco/publisher.h"
#include "adapters/mujoco/simulation.h"
#include "protocol/wire/image_block.h"
#include "renderer/scene/load_gltf.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/client_fixture.h"
#include "tools/convert/mjcf_load.h"
#include "tools/convert/readers.h"

namespace fire3dv::mujoco {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCrane = "tests/assets/robots/crane.xml";

fs::path in_tree(const char* file) {
  return fs::path(FIRE3DV_SOURCE_DIR) / file;
}

// Those of the tree, and robots of the collection where it is.
std::vector<fs::path> models() {
  std::vector<fs::path> found{in_tree(kCrane), in_tree("tests/assets/robots/arm.xml")};
  const char* const named = std::getenv("FIRE3DV_ASSETS");
  const fs::path assets = named ? fs::path(named) : fs::path(FIRE3DV_SOURCE_DIR) / "../shared/assets";
  for (const char* robot : {"franka_emika_panda/scene.xml", "robotiq_2f85/scene.xml"})
    if (fs::exists(assets / "robots" / robot)) found.push_back(assets / "robots" / robot);
  return found;
}

Simulation loaded(const fs::path& file, Drive drive = Drive::sine, const std::string& keyframe = "") {
  Result<Simulation> simulation = Simulation::load(file, keyframe, drive);
  EXPECT_TRUE(simulation.ok()) << simulation.error().message;
  return std::move(*simulation);  // a test without one cannot go on
}

void run(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) {
    const Result<void> done = simulation.step();
    ASSERT_TRUE(done.ok()) << done.error().message;
  }
  ASSERT_TRUE(simulation.place().ok());
}

glm::dmat4 matrix_of(const float* rows) {
  glm::dmat4 matrix(1);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      matrix[column][row] = static_cast<double>(rows[4 * row + column]);
  return matrix;
}

std::map<std::string, glm::dmat4> poses_of(const Simulation& simulation) {
  MovedNodes nodes(simulation.model(), convert::MjcfNames(simulation.model()));
  std::vector<float> poses;
  nodes.write(simulation.model(), simulation.data(), poses);
  std::map<std::string, glm::dmat4> by_name;
  for (size_t i = 0; i < nodes.names().size(); ++i) by_name[nodes.names()[i]] = matrix_of(&poses[12 * i]);
  EXPECT_EQ(by_name.size(), nodes.names().size()) << "a name is there twice";
  return by_name;
}

double apart(const glm::dmat4& a, const glm::dmat4& b) {
  double most = 0;
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row) most = std::max(most, std::abs(a[column][row] - b[column][row]));
  return most;
}

glm::dmat4 matrix_of(const mjtNum* place, const mjtNum* rows) {
  glm::dmat4 matrix(1);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) matrix[column][row] = rows[3 * row + column];
    matrix[3][row] = place[row];
  }
  return matrix;
}

TEST(MujocoAdapter, PosesAreThoseOfMjData) {
  for (const fs::path& file : models()) {
    Simulation simulation = loaded(file);
    run(simulation, 300);
    const mjModel& m = simulation.model();
    const mjData& d = simulation.data();
    const auto poses = poses_of(simulation);
    double farthest = 1;
    for (int body = 1; body < m.nbody; ++body) {
      const glm::dmat4 meant = matrix_of(d.xpos + 3 * body, d.xmat + 9 * body);
      for (int i = 0; i < 3; ++i) farthest = std::max(farthest, std::abs(meant[3][i]));
      const std::string name = m.names + m.name_bodyadr[body];
      const auto found = poses.find(name.empty() ? "body_" + std::to_string(body) : name);
      ASSERT_NE(found, poses.end()) << file << " " << body;
      EXPECT_LE(apart(found->second, meant), 1e-7 * farthest) << file << " " << name;
    }
    for (int camera = 0; camera < m.ncam; ++camera) {
      const auto found = poses.find(convert::MjcfNames(m).cameras[static_cast<size_t>(camera)]);
      ASSERT_NE(found, poses.end());
      EXPECT_LE(apart(found->second, matrix_of(d.cam_xpos + 3 * camera, d.cam_xmat + 9 * camera)), 1e-6)
          << file;
    }
    for (int light = 0; light < m.nlight; ++light) {
      const auto found = poses.find(convert::MjcfNames(m).lights[static_cast<size_t>(light)]);
      ASSERT_NE(found, poses.end());
      for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(-found->second[2][i], d.light_xdir[3 * light + i], 1e-6) << file;
        EXPECT_NEAR(found->second[3][i], d.light_xpos[3 * light + i], 1e-5) << file;
      }
    }
  }
}

TEST(MujocoAdapter, TendonsRunAsMuJoCoHasThem) {
  Simulation simulation = loaded(in_tree(kCrane));
  const mjModel& m = simulation.model();
  const mjData& d = simulation.data();
  bool lay_on_drum = false;
  for (int i = 0; i < 40; ++i) {
    run(simulation, 25);
    const auto poses = poses_of(simulation);
    for (const char* tendon : {"rope", "tackle"}) {
      const int index = mj_name2id(&m, mjOBJ_TENDON, tendon);
      int piece = 0;
      for (int p = d.ten_wrapadr[index]; p + 1 < d.ten_wrapadr[index] + d.ten_wrapnum[index]; ++p) {
        if (d.wrap_obj[p] == -2 || d.wrap_obj[p + 1] == -2) continue;
        const glm::dmat4& pose = poses.at(std::string(tendon) + "#" + std::to_string(piece));
        const bool lies_on = d.wrap_obj[p] >= 0 && d.wrap_obj[p + 1] >= 0;
        lay_on_drum |= lies_on;
        for (const double side : {-1.0, 1.0}) {  // a cylinder from -1 to 1
          const glm::dvec3 end(pose * glm::dvec4(0, 0, side, 1));
          const mjtNum* meant = d.wrap_xpos + 3 * (side < 0 ? p : p + 1);
          EXPECT_LT(glm::distance(end, glm::dvec3(meant[0], meant[1], meant[2])), 1e-6) << tendon << piece;
        }
        EXPECT_NEAR(glm::length(glm::dvec3(pose[0])), lies_on ? 0.006 : 0.012, 1e-7);
        ++piece;
      }
    }
    const int used = d.ten_wrapnum[0] - 1;
    for (int spare = used; spare < 3; ++spare)
      EXPECT_EQ(glm::determinant(glm::dmat3(poses.at("rope#" + std::to_string(spare)))), 0) << "is seen";
    EXPECT_FALSE(poses.contains("unseen#0"));
  }
  EXPECT_TRUE(lay_on_drum);
}

// Where the scene has each node at rest, in the description's frame.
std::map<std::string, glm::dmat4> at_rest(const convert::Model& model) {
  std::vector<glm::dmat4> matrices;
  std::map<std::string, glm::dmat4> by_name;
  for (const convert::Node& node : model.nodes) {
    glm::dmat4 matrix(glm::mat3_cast(node.rotation));
    for (int axis = 0; axis < 3; ++axis) matrix[axis] *= node.scale[axis];
    matrix[3] = glm::dvec4(node.translation, 1);
    if (node.parent) matrix = matrices[*node.parent] * matrix;
    matrices.push_back(matrix);
    EXPECT_TRUE(by_name.emplace(node.name, matrix).second) << node.name << " is there twice";
  }
  return by_name;
}

TEST(MujocoAdapter, EveryNameIsANodeOfTheSceneAndRestsWhereItIsPublished) {
  for (const fs::path& file : models()) {
    const auto model = convert::read_mjcf(file, {});
    ASSERT_TRUE(model.ok()) << model.error().message;
    const auto rest = at_rest(*model);
    const Simulation simulation = loaded(file);
    for (const auto& [name, pose] : poses_of(simulation)) {
      const auto found = rest.find(name);
      ASSERT_NE(found, rest.end()) << file << ": " << name << " is no node of the scene";
      EXPECT_LT(apart(found->second, pose), 1e-5) << file << ": " << name;
    }
  }
}

TEST(MujocoAdapter, GeomsApartAreWhereMjDataHasThem) {
  Simulation simulation = loaded(in_tree(kCrane));
  convert::ReadOptions options;
  options.geoms_apart = true;
  const auto model = convert::read_mjcf(in_tree(kCrane), options);
  ASSERT_TRUE(model.ok());
  const auto rest = at_rest(*model);
  const mjModel& m = simulation.model();
  const mjData& d = simulation.data();
  const convert::MjcfNames names(m);
  EXPECT_EQ(names.geoms[2], "drum geom") << "a body has that name";
  int shown = 0;
  for (int geom = 0; geom < m.ngeom; ++geom) {
    const auto found = rest.find(names.geoms[static_cast<size_t>(geom)]);
    EXPECT_EQ(found != rest.end(), m.geom_group[geom] < 3) << geom;
    if (found == rest.end()) continue;
    ++shown;
    EXPECT_LT(apart(found->second, matrix_of(d.geom_xpos + 3 * geom, d.geom_xmat + 9 * geom)), 1e-9) << geom;
  }
  EXPECT_EQ(shown, 6);
  std::vector<std::string> warnings;
  const auto glb = scene_of(m, d, "crane", warnings);
  ASSERT_TRUE(glb.ok()) << glb.error().message;
  const auto scene = scene::load_glb(*glb, "crane");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_TRUE(warnings.empty()) << warnings.front();
}

TEST(FrameClock, KeepsTheRateWhateverTheStepIs) {
  for (const double step_s : {0.001, 0.002, 0.005, 1.0 / 240}) {
    for (const double rate_hz : {24.0, 60.0, 100.0, 0.0}) {
      FrameClock clock(rate_hz);
      int frames = 0, steps = 0;
      for (double time_s = 0; time_s < 10 + step_s / 2; time_s += step_s, ++steps) {
        const int64_t now_ns = std::llround(time_s * 1e9);
        if (!clock.due(now_ns)) continue;
        EXPECT_EQ(clock.published(now_ns), frames == 0) << "a jump into the first one alone";
        EXPECT_FALSE(clock.due(now_ns)) << "the same time twice";
        ++frames;
      }
      const double meant = rate_hz > 0 ? 10 * std::min(rate_hz, 1 / step_s) + 1 : steps;
      EXPECT_NEAR(frames, meant, 1) << step_s << " " << rate_hz;
    }
  }
}

TEST(Pace, NothingIsDueBeforeItsTimeHoweverFarAwayItIs) {
  using namespace std::chrono_literals;
  const Pace::Clock::time_point start{1h};
  for (const double speed : {0.1, 1.0, 10.0}) {
    Pace pace(speed);
    EXPECT_EQ(pace.sleep_before(5, start), 0s) << "the first one begins the time";
    // A frame each second: whoever sleeps as told is asked again until then.
    Pace::Clock::time_point now = start;
    for (int frame = 1; frame <= 5; ++frame) {
      for (Pace::Clock::duration sleep; (sleep = pace.sleep_before(5 + frame, now)) > 0s; now += sleep)
        ASSERT_LE(sleep, 250ms);
      EXPECT_NEAR(std::chrono::duration<double>(now - start).count(), frame / speed, 1e-6);
    }
    // Who was held up goes on from there.
    now += 1h;
    EXPECT_EQ(pace.sleep_before(11, now), 0s);
    EXPECT_EQ(pace.sleep_before(12, now), 0s);
    EXPECT_GT(pace.sleep_before(13, now), 0s);
    pace.restart();
    EXPECT_EQ(pace.sleep_before(100, now), 0s);
  }
  EXPECT_EQ(Pace(0).sleep_before(1e9, start), 0s);
}

TEST(ImageNames, CamerasMayHaveColonsAndSizes) {
  const auto wish = [](const std::string& text) {
    const Result<ImageWish> parsed = image_wish(text);
    return parsed
               ? parsed->camera + " " + std::to_string(parsed->width) + " " + std::to_string(parsed->height)
               : parsed.error().message;
  };
  EXPECT_EQ(wish("wrist"), "wrist 640 480");
  EXPECT_EQ(wish("wrist:64x48"), "wrist 64 48");
  EXPECT_EQ(wish("left:wrist:64x48"), "left:wrist 64 48");
  for (const char* no_size : {"a:b", "a:64", "a:64x", "a:x48", "a:64x48x2", "a:-1x48", "a:64x 48", "a:"})
    EXPECT_EQ(wish(no_size), std::string(no_size) + " 640 480");
  EXPECT_NE(wish("a:0x48").find("1 to 8192"), std::string::npos);
  EXPECT_NE(wish("a:64x8193").find("1 to 8192"), std::string::npos);
  EXPECT_NE(wish(":64x48").find("names no camera"), std::string::npos);
  EXPECT_NE(wish("").find("names no camera"), std::string::npos);
}

TEST(ImageNames, OutputsAreThoseOfTheRenderer) {
  EXPECT_EQ(*image_outputs("color"), uint32_t{FIRE3DV_IMAGE_COLOR_SRGB8});
  EXPECT_EQ(*image_outputs("color,linear,depth,instance,semantic,normal,motion,boxes2d,boxes3d"), 511u);
  for (const char* wrong : {"", "colour", "color,", ",color", "color,color", "Depth", "color depth"})
    EXPECT_FALSE(image_outputs(wrong).ok()) << wrong;
}

// All that comes over a link, frame by frame.
struct Seen {
  explicit Seen(const std::string& uri) : link(std::move(transport::open_listener(uri).value())) {}

  void poll() {
    link->wait(std::chrono::milliseconds(1));
    link->poll([&](const transport::LinkEvent& event) {
      using Kind = transport::LinkEvent::Kind;
      if (event.kind != Kind::pose && event.kind != Kind::control) return;
      peer = event.peer;
      const auto message = decoder.decode(event.message);
      ASSERT_TRUE(message.ok()) << message.error().message;
      if (const auto* m = std::get_if<wire::ImageRequest>(&*message)) request = *m;
      if (const auto* m = std::get_if<wire::StreamDescription>(&*message)) description = *m;
      if (const auto* m = std::get_if<wire::SceneEdit>(&*message)) edits.push_back(*m);
      if (const auto* m = std::get_if<wire::PoseFrameView>(&*message)) {
        header = m->header;
        poses.assign(m->poses.begin(), m->poses.end());
      }
    });
  }
  // An image of that frame, all black.
  bool answer(uint64_t number, uint64_t sequence) {
    wire::ImageFrame frame;
    frame.request = request->id;
    frame.number = number;
    frame.epoch = request->epoch;
    frame.sequence = sequence;
    frame.intrinsics = request->intrinsics;
    frame.intrinsics.fx = frame.intrinsics.fy =
        10;  // the camera's own, which the request leaves to the renderer
    frame.intrinsics.near_m = 0.1f;
    const uint32_t width = frame.intrinsics.width, height = frame.intrinsics.height;
    frame.planes = {{0, wire::ImageFormat::rgba8, width, height, 4 * width, 0, 4 * width * height}};
    frame.pixel_bytes = (frame.planes[0].bytes + 63) / 64 * 64;
    return link->send_image(peer, frame.request, wire::encode(frame), frame.pixel_bytes,
                            [](std::span<std::byte> pixels) { std::ranges::fill(pixels, std::byte{}); });
  }
  bool wait_for(uint64_t sequence) {
    return test::repeat_until([&] {
      poll();
      return header.sequence >= sequence;
    });
  }

  std::unique_ptr<transport::ListenerLink> link;
  transport::PeerId peer = 0;
  std::optional<wire::ImageRequest> request;
  wire::Decoder decoder;
  wire::StreamDescription description;
  std::vector<wire::SceneEdit> edits;
  wire::PoseFrameHeader header{};
  std::vector<wire::Affine3x4> poses;
};

TEST(MujocoAdapter, WhatIsPublishedComesWithRateResetsAndLooks) {
  for (const char* scheme : {"shm", "tcp"}) {
    Seen seen(test::listener_uri(scheme));
    Simulation simulation = loaded(in_tree(kCrane));
    mjModel& m = const_cast<mjModel&>(simulation.model());  // as a simulation that changes its looks
    PublishOptions options;
    options.uris = {seen.link->uri()};
    options.rate_hz = 100;
    Result<Publisher> publisher = Publisher::open(m, options);
    ASSERT_TRUE(publisher.ok()) << publisher.error().message;
    ASSERT_TRUE(test::repeat_until([&] {
      seen.poll();
      return (*publisher->poll())[0].status.renderers == 1;
    }));
    uint64_t frames = 0;
    const auto publish = [&] {
      ASSERT_TRUE(simulation.place().ok());
      const Result<bool> sent = publisher->publish(m, simulation.data());
      ASSERT_TRUE(sent.ok()) << sent.error().message;
      if (!*sent) return;
      ASSERT_TRUE(seen.wait_for(++frames));
      EXPECT_EQ(seen.header.sim_time_ns, std::llround(simulation.data().time * 1e9));
    };
    publish();
    EXPECT_EQ(seen.header.flags, wire::kFrameDiscontinuity) << "into the first frame";
    EXPECT_EQ(seen.description.node_names, publisher->node_names());
    EXPECT_EQ(seen.description.nominal_rate_hz, 100);
    for (int step = 0; step < 50; ++step) {
      ASSERT_TRUE(simulation.step().ok());
      publish();
    }
    EXPECT_EQ(frames, 11u) << "every fifth step of 2 ms";
    EXPECT_EQ(seen.header.flags, 0u);
    const auto meant = poses_of(simulation);
    for (size_t i = 0; i < seen.poses.size(); ++i)
      EXPECT_EQ(apart(matrix_of(seen.poses[i].m.data()), meant.at(seen.description.node_names[i])), 0);
    EXPECT_TRUE(seen.edits.empty()) << "nothing has changed its looks";

    const int load = mj_name2id(&m, mjOBJ_GEOM, "load"), mark = mj_name2id(&m, mjOBJ_GEOM, "mark");
    m.geom_rgba[4 * load] = 1;
    m.geom_group[mark] = 5;
    m.geom_rgba[4 * mark] = 0;  // nobody sees it
    ASSERT_TRUE(simulation.reset().ok());
    publish();
    EXPECT_EQ(seen.header.sim_time_ns, 0);
    EXPECT_EQ(seen.header.flags, wire::kFrameDiscontinuity) << "time has run backwards";
    ASSERT_EQ(seen.edits.size(), 2u);
    EXPECT_EQ(seen.edits[0].node, "mark");
    EXPECT_FALSE(std::get<wire::Visible>(seen.edits[0].value).visible);
    EXPECT_EQ(seen.edits[1].node, "load geom") << "a body has its name";
    const auto rgba = std::get<wire::BaseColor>(seen.edits[1].value).rgba;
    EXPECT_EQ(rgba[0], 1);
    EXPECT_NEAR(rgba[1], 0.13287f, 1e-5f) << "0.4 as displayed";
    m.geom_group[mark] = 0;
    publisher->jump();
    publish();
    ASSERT_EQ(seen.edits.size(), 4u) << "it is seen again, in the colour that it has got";
    EXPECT_TRUE(std::get<wire::Visible>(seen.edits[2].value).visible);
    EXPECT_EQ(std::get<wire::BaseColor>(seen.edits[3].value).rgba[0], 0);
  }
}

// An image that came too late for its frame is lost, and counted: it is not the frame's that is waited for.
TEST(MujocoAdapter, OnlyTheImageOfTheLastFrameIsWaitedFor) {
  for (const bool is_stopped : {false, true}) {
    Seen seen(test::listener_uri("tcp"));
    Simulation simulation = loaded(in_tree(kCrane));
    Result<Publisher> publisher = Publisher::open(simulation.model(), {.uris = {seen.link->uri()}});
    ASSERT_TRUE(publisher.ok()) << publisher.error().message;
    const Result<uint64_t> id =
        publisher->ask_images(simulation.model(), {.camera = "chaser", .width = 8, .height = 4});
    ASSERT_TRUE(id.ok()) << id.error().message;
    ASSERT_TRUE(test::repeat_until([&] {
      seen.poll();
      return (*publisher->poll())[0].status.renderers == 1;
    }));
    for (uint64_t frame = 1; frame <= 2; ++frame) {
      publisher->jump();
      ASSERT_TRUE(publisher->publish(simulation.model(), simulation.data()).ok());
    }
    ASSERT_TRUE(seen.wait_for(2));
    ASSERT_TRUE(test::repeat_until([&] {
      seen.poll();
      return seen.request.has_value();
    }));
    ASSERT_TRUE(seen.answer(1, 1));
    std::atomic<bool> stop{false};
    auto waited = std::async(std::launch::async, [&] { return publisher->wait_image(*id, 60, stop); });
    // Long enough to take the first one; whether it does is the same to what comes of it.
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(300);
    while (std::chrono::steady_clock::now() < end) seen.poll();
    if (is_stopped)
      stop = true;
    else
      ASSERT_TRUE(seen.answer(2, 2));
    ASSERT_TRUE(test::repeat_until([&] {
      seen.poll();
      return waited.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    }));
    const Result<Image> image = waited.get();
    ASSERT_TRUE(image.ok()) << image.error().message;
    if (is_stopped) {
      EXPECT_EQ(*image, nullptr) << "an image of another frame";
    } else {
      ASSERT_NE(*image, nullptr);
      EXPECT_EQ((*image)->sequence, 2u);
      EXPECT_EQ((*image)->lost, 1u);
    }
  }
}

TEST(MujocoAdapter, AnotherModelIsRefused) {
  const Simulation crane = loaded(in_tree(kCrane)), arm = loaded(in_tree("tests/assets/robots/arm.xml"));
  PublishOptions options;
  options.uris = {test::unique_shm_uri()};
  Result<Publisher> publisher = Publisher::open(crane.model(), options);
  ASSERT_TRUE(publisher.ok());
  const Result<bool> sent = publisher->publish(arm.model(), arm.data());
  ASSERT_FALSE(sent.ok());
  EXPECT_NE(sent.error().message.find("not the model"), std::string::npos);
  options.uris = {"nonsense"};
  EXPECT_NE(Publisher::open(crane.model(), options).error().message.find("nonsense"), std::string::npos);
}

TEST(Simulation, DrivesWithinTheRangesAndResetsToItsKeyframe) {
  Simulation arm = loaded(in_tree("tests/assets/robots/arm.xml"));
  const std::vector<mjtNum> first(arm.data().qpos, arm.data().qpos + arm.model().nq);
  EXPECT_EQ(first[0], 0.5) << "the first keyframe is where it begins";
  run(arm, 200);
  EXPECT_NE(first[0], arm.data().qpos[0]);
  ASSERT_TRUE(arm.reset().ok());
  EXPECT_EQ(first, std::vector<mjtNum>(arm.data().qpos, arm.data().qpos + arm.model().nq));
  EXPECT_EQ(arm.data().time, 0);

  Simulation crane = loaded(in_tree(kCrane));
  bool moved = false;
  for (int step = 0; step < 2000; ++step) {
    ASSERT_TRUE(crane.step().ok());
    EXPECT_LE(std::abs(crane.data().ctrl[0]), 4);
    moved |= std::abs(crane.data().ctrl[1]) > 0.05;
  }
  EXPECT_TRUE(moved);
  Simulation still = loaded(in_tree(kCrane), Drive::zero);
  run(still, 10);
  EXPECT_EQ(still.data().ctrl[0], 0);
  for (const char* keyframe : {"1", "-1", "none such"}) {
    const auto wrong = Simulation::load(in_tree("tests/assets/robots/arm.xml"), keyframe, Drive::hold);
    ASSERT_FALSE(wrong.ok());
    EXPECT_NE(wrong.error().message.find(keyframe), std::string::npos);
  }
}

void (*const kErrorAtStart)(const char*) = mju_user_error;

TEST(Simulation, WhatMuJoCoWarnsOfLaterIsItsOwnersAgain) {
  static int warned = 0;
  mju_user_warning = [](const char*) { ++warned; };
  std::vector<std::string> warnings;
  ASSERT_TRUE(convert::call_mujoco([] { mju_warning("within"); }, &warnings).ok());
  EXPECT_FALSE(convert::call_mujoco([] { mju_error("a fault"); }, &warnings).ok());
  EXPECT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warned, 0);
  mju_warning("later");
  EXPECT_EQ(warned, 1);
  EXPECT_EQ(warnings.size(), 1u);
  EXPECT_EQ(mju_user_error, kErrorAtStart);
  mju_user_warning = nullptr;
}

TEST(Simulation, WhatMuJoCoGivesUpOnEndsNothingElse) {
  const test::ScratchFolder folder;
  std::string bodies;  // they fall into contacts for which there is no memory
  for (int i = 1; i <= 12; ++i)
    bodies += "<body pos='0 0 " + std::to_string(0.2 * i) + "'><freejoint/><geom size='0.09'/></body>";
  Result<Simulation> simulation = Error{"none yet"};
  for (double words = 500; !simulation && words < 1e6; words *= 1.1) {  // as many as do without contacts
    simulation = Simulation::load(
        folder.write("full.xml",
                     std::string_view("<mujoco><size nstack='" + std::to_string(std::lround(words)) +
                                      "'/><worldbody><geom type='plane' size='9 9 1'/>" + bodies +
                                      "</worldbody></mujoco>")),
        "", Drive::hold);
  }
  ASSERT_TRUE(simulation.ok()) << simulation.error().message;
  std::string said;
  for (int step = 0; said.empty() && step < 1000; ++step)
    if (const Result<void> done = simulation->step(); !done) said = done.error().message;
  EXPECT_NE(said.find("cannot step the model: "), std::string::npos) << said;
  EXPECT_NE(said.find("tack overflow"), std::string::npos) << said;
  Simulation other = loaded(in_tree(kCrane));
  run(other, 10);
}

}  // namespace
}  // namespace fire3dv::mujoco
