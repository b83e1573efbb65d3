// Test of the MuJoCo publisher: frame rate, pacing, resets, appearance edits, and returned images.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <future>
#include <optional>
#include <span>

#include "adapters/mujoco/options.h"
#include "adapters/mujoco/timing.h"
#include "protocol/wire/image.h"
#include "tests/unit/adapters/generic/client_fixture.h"
#include "tests/unit/adapters/mujoco/models.h"

namespace fire3dv::mujoco {
namespace {

TEST(FrameClock, KeepsRateWhateverStepIs) {
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

TEST(Pace, NothingIsDueEarly) {
  using namespace std::chrono_literals;
  const Pace::Clock::time_point start{1h};
  for (const double speed : {0.1, 1.0, 10.0}) {
    Pace pace(speed);
    EXPECT_EQ(pace.sleep_before(5, start), 0s) << "the first one begins the time";
    // One frame per second: sleeping for the returned times reaches each due time exactly.
    Pace::Clock::time_point now = start;
    for (int frame = 1; frame <= 5; ++frame) {
      for (Pace::Clock::duration sleep; (sleep = pace.sleep_before(5 + frame, now)) > 0s; now += sleep)
        ASSERT_LE(sleep, 250ms);
      EXPECT_NEAR(std::chrono::duration<double>(now - start).count(), frame / speed, 1e-6);
    }
    // After a delay the schedule continues from the current time.
    now += 1h;
    EXPECT_EQ(pace.sleep_before(11, now), 0s);
    EXPECT_EQ(pace.sleep_before(12, now), 0s);
    EXPECT_GT(pace.sleep_before(13, now), 0s);
    pace.restart();
    EXPECT_EQ(pace.sleep_before(100, now), 0s);
  }
  EXPECT_EQ(Pace(0).sleep_before(1e9, start), 0s);
}

TEST(ImageNames, ColonsAndSizesAreParsed) {
  const auto spec = [](const std::string& text) {
    const Result<ImageSpec> parsed = image_spec(text);
    return parsed
               ? parsed->camera + " " + std::to_string(parsed->width) + " " + std::to_string(parsed->height)
               : parsed.error().message;
  };
  EXPECT_EQ(spec("wrist"), "wrist 640 480");
  EXPECT_EQ(spec("wrist:64x48"), "wrist 64 48");
  EXPECT_EQ(spec("left:wrist:64x48"), "left:wrist 64 48");
  for (const char* no_size : {"a:b", "a:64", "a:64x", "a:x48", "a:64x48x2", "a:-1x48", "a:64x 48", "a:"})
    EXPECT_EQ(spec(no_size), std::string(no_size) + " 640 480");
  EXPECT_NE(spec("a:0x48").find("1 to 8192"), std::string::npos);
  EXPECT_NE(spec("a:64x8193").find("1 to 8192"), std::string::npos);
  EXPECT_NE(spec(":64x48").find("names no camera"), std::string::npos);
  EXPECT_NE(spec("").find("names no camera"), std::string::npos);
}

TEST(ImageNames, OutputsAreThoseOfRenderer) {
  EXPECT_EQ(*image_outputs("color"), uint32_t{FIRE3DV_IMAGE_COLOR_SRGB8});
  EXPECT_EQ(*image_outputs("color,linear,depth,instance,semantic,normal,motion,boxes2d,boxes3d"), 511u);
  for (const char* wrong : {"", "colour", "color,", ",color", "color,color", "Depth", "color depth"})
    EXPECT_FALSE(image_outputs(wrong).ok()) << wrong;
}

// All messages of a link, frame by frame.
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
  // Answers with a black image of that frame.
  bool answer(uint64_t number, uint64_t sequence) {
    wire::ImageFrame frame;
    frame.request = request->id;
    frame.number = number;
    frame.epoch = request->epoch;
    frame.sequence = sequence;
    frame.intrinsics = request->intrinsics;
    frame.intrinsics.fx = frame.intrinsics.fy =
        10;  // the camera's own value, which the request leaves to the renderer
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

TEST(MujocoAdapter, PublishingSendsRateAndResets) {
  for (const char* scheme : {"shm", "tcp"}) {
    Seen seen(test::listener_uri(scheme));
    Simulation simulation = loaded(in_tree(kCrane));
    mjModel& m = const_cast<mjModel&>(simulation.model());  // like a simulation that edits its appearance
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
      ASSERT_TRUE(simulation.update_poses().ok());
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
    m.geom_rgba[4 * mark] = 0;  // invisible
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

TEST(MujocoAdapter, JointScalarsHaveUnits) {
  Seen seen(test::listener_uri("tcp"));
  Simulation simulation = loaded(in_tree(kCrane));
  const mjModel& m = simulation.model();
  PublishOptions options;
  options.uris = {seen.link->uri()};
  options.joint_scalars = true;
  Result<Publisher> publisher = Publisher::open(m, options);
  ASSERT_TRUE(publisher.ok()) << publisher.error().message;
  const auto of = [&](const char* group, auto wanted) {
    std::optional<decltype(wanted)> newest;
    for (const wire::SceneEdit& edit : seen.edits) {
      const auto* value = std::get_if<decltype(wanted)>(&edit.value);
      if (value && edit.node == group) newest = *value;
    }
    return newest;
  };
  for (int step = 0; step < 20; ++step) ASSERT_TRUE(simulation.step().ok());
  ASSERT_TRUE(publisher->publish(m, simulation.data()).ok());
  ASSERT_TRUE(test::repeat_until([&] {
    (void)publisher->poll();
    seen.poll();
    return of("joint_efforts", wire::ScalarValues()).has_value();
  }));
  // The crane has a hinge, a free joint and a slide without a name, in this order.
  const mjData& d = simulation.data();
  const auto expect = [&](const char* group, const std::vector<std::string>& units,
                          const std::vector<double>& values) {
    const auto declared = of(group, wire::Scalars());
    const auto newest = of(group, wire::ScalarValues());
    ASSERT_TRUE(declared && newest) << group;
    EXPECT_EQ(declared->names, (std::vector<std::string>{"drum", "joint_2"}));
    EXPECT_EQ(declared->units, units);
    EXPECT_EQ(newest->values, values);
    EXPECT_EQ(newest->sim_time_ns, std::llround(d.time * 1e9));
  };
  expect("joint_positions", {"rad", "m"}, {d.qpos[0], d.qpos[8]});
  expect("joint_velocities", {"rad/s", "m/s"}, {d.qvel[0], d.qvel[7]});
  expect("joint_efforts", {"N m", "N"}, {d.qfrc_actuator[0], d.qfrc_actuator[7]});
  EXPECT_NE(d.qpos[8], 0) << "gravity moves the slide";
}

// An image that is too late for its frame counts as lost: the wait is for the image of the last frame.
TEST(MujocoAdapter, LastImageIsAwaited) {
  for (const bool is_stopped : {false, true}) {
    Seen seen(test::listener_uri("tcp"));
    Simulation simulation = loaded(in_tree(kCrane));
    Result<Publisher> publisher = Publisher::open(simulation.model(), {.uris = {seen.link->uri()}});
    ASSERT_TRUE(publisher.ok()) << publisher.error().message;
    const Result<uint64_t> id =
        publisher->request_images(simulation.model(), {.camera = "chaser", .width = 8, .height = 4});
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
    // Long enough to receive the first image; the result is the same if not.
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

}  // namespace
}  // namespace fire3dv::mujoco
