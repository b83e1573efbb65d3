// Test of the markers of a MuJoCo simulation, against values that mechanics gives: forces of bodies at rest,
// axes, centres of mass and tendons of a model without motion.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "adapters/mujoco/markers.h"
#include "protocol/wire/decode.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/adapters/generic/client_fixture.h"
#include "tests/unit/adapters/mujoco/models.h"

namespace fire3dv::mujoco {
namespace {

constexpr uint32_t kAll = kShowContacts | kShowForces | kShowJoints | kShowCentresOfMass | kShowTendons;
constexpr double kGravity = 9.81, kMetresPerNewton = 0.02 / 4;

// A ball of 1 kg on a box of 3 kg. MuJoCo orders the geoms of a contact by type, so that the first one is the
// ball, of the body with the higher id.
constexpr std::string_view kAtRest = R"(<mujoco>
  <option timestep="0.002"/>
  <statistic meanmass="4" meansize="0.5"/>
  <visual><map force="0.02"/><scale contactwidth="0.1" jointlength="0.8"/>
    <rgba contactpoint="1 0 0 1" joint="0 1 0 0.5"/></visual>
  <worldbody>
    <geom type="plane" size="5 5 0.1"/>
    <body name="box" pos="0 0 0.2"><freejoint/>
      <geom type="box" size="0.4 0.3 0.2" mass="3"/></body>
    <body name="ball" pos="0 0 0.5"><freejoint/>
      <geom type="sphere" size="0.1" mass="1"/></body>
  </worldbody></mujoco>)";

constexpr std::string_view kMechanism = R"(<mujoco>
  <option gravity="0 0 0"/>
  <statistic meansize="0.5"/>
  <visual><scale jointlength="0.8" com="0.2"/></visual>
  <worldbody>
    <site name="high" pos="0 0 2"/>
    <body name="arm" pos="1 0 0"><joint type="hinge" axis="0 1 0" pos="0 0 0.5"/>
      <geom type="sphere" size="0.1" mass="1"/>
      <body name="slider" pos="0 0 1"><joint type="slide" axis="1 0 0"/>
        <geom type="sphere" size="0.1" mass="3" contype="0"/><site name="low" pos="0 0 0.25"/></body>
    </body>
    <body name="pendulum" pos="0 3 0"><joint type="ball"/>
      <geom type="sphere" size="0.1" mass="2" pos="0 0 -1"/></body>
    <body name="hidden" pos="0 5 0"><joint type="hinge" axis="0 0 1" group="4"/>
      <geom type="sphere" size="0.1" mass="1"/></body>
  </worldbody>
  <tendon><spatial rgba="0 0 1 1"><site site="high"/><site site="low"/></spatial>
    <spatial rgba="1 1 0 1" group="5"><site site="low"/><site site="high"/></spatial></tendon>
</mujoco>)";

class MujocoMarkers : public testing::Test {
 protected:
  Simulation load(std::string_view text) { return loaded(folder_.write("model.xml", text), Drive::hold); }
  test::ScratchFolder folder_;
};

using ByName = std::map<std::string, SimulationMarker>;

ByName markers_of(const Simulation& simulation, uint32_t quantities = kAll) {
  SimulationMarkers markers(quantities);
  ByName by_name;
  for (const SimulationMarker& each : markers.update(simulation.model(), simulation.data()))
    by_name[each.name] = each;
  return by_name;
}

void expect_point(const std::array<float, 3>& point, double x, double y, double z) {
  EXPECT_NEAR(point[0], x, 1e-6);
  EXPECT_NEAR(point[1], y, 1e-6);
  EXPECT_NEAR(point[2], z, 1e-6);
}

TEST_F(MujocoMarkers, RestForcesCarryWeight) {
  Simulation simulation = load(kAtRest);
  for (int step = 0; step < 2000; ++step) ASSERT_TRUE(simulation.step().ok());
  ASSERT_TRUE(simulation.update_poses().ok());
  const ByName markers = markers_of(simulation, kShowContacts | kShowForces);
  ASSERT_EQ(markers.size(), 2u);
  const SimulationMarker& forces = markers.at("contacts/forces");
  EXPECT_EQ(forces.kind, FIRE3DV_MARKER_ARROWS);
  ASSERT_EQ(forces.positions.size() % 2, 0u);
  double floor_N = 0, ball_N = 0, sideways_N = 0;
  for (size_t i = 0; i < forces.positions.size(); i += 2) {
    const auto &tail = forces.positions[i], &tip = forces.positions[i + 1];
    const auto newtons = [&](size_t axis) {
      return (double{tip[axis]} - double{tail[axis]}) / kMetresPerNewton;
    };
    const bool is_floor = tail[2] < 0.2f;
    EXPECT_NEAR(tail[2], is_floor ? 0 : 0.4, 0.005) << "a contact lies on a surface";
    (is_floor ? floor_N : ball_N) += newtons(2);
    sideways_N += std::hypot(newtons(0), newtons(1));
  }
  EXPECT_NEAR(floor_N, 4 * kGravity, 0.01) << "the floor carries both, upwards";
  EXPECT_NEAR(ball_N, 1 * kGravity, 0.01) << "the force on the body of the higher id, the ball";
  EXPECT_LT(sideways_N, 0.01);
  const SimulationMarker& points = markers.at("contacts/points");
  EXPECT_EQ(points.positions.size(), forces.positions.size() / 2);
  EXPECT_EQ(points.positions.size(), 5u) << "four corners and the ball";
  EXPECT_FLOAT_EQ(points.width_m, 2 * 0.1f * 0.5f);
  EXPECT_EQ(points.colors.at(0), (std::array<uint8_t, 4>{255, 0, 0, 255}));
}

TEST_F(MujocoMarkers, ContactsThatEndVanishOnce) {
  Simulation simulation = load(kAtRest);
  ASSERT_TRUE(simulation.step().ok());
  SimulationMarkers markers(kShowContacts);
  EXPECT_TRUE(markers.update(simulation.model(), simulation.data()).at(0).is_changed);
  ASSERT_TRUE(simulation.reset().ok());  // has no contacts before the first step
  const auto& emptied = markers.update(simulation.model(), simulation.data()).at(0);
  EXPECT_TRUE(emptied.is_changed && emptied.positions.empty());
  EXPECT_EQ(marker_of(emptied).position_count, 0u);
  EXPECT_FALSE(markers.update(simulation.model(), simulation.data()).at(0).is_changed);
}

TEST_F(MujocoMarkers, MarkersMatchTheModel) {
  const ByName markers = markers_of(load(kMechanism));
  ASSERT_EQ(markers.size(), 7u);
  const auto& hinges = markers.at("joints/hinges").positions;
  ASSERT_EQ(hinges.size(), 2u) << "the group of the other is hidden";
  expect_point(hinges[0], 1, 0, 0.5);
  expect_point(hinges[1], 1, 0.4, 0.5);
  const auto& slides = markers.at("joints/slides").positions;
  ASSERT_EQ(slides.size(), 2u);
  expect_point(slides[0], 1, 0, 1);
  expect_point(slides[1], 1.4, 0, 1);
  const auto& balls = markers.at("joints/balls");
  ASSERT_EQ(balls.positions.size(), 1u);
  expect_point(balls.positions[0], 0, 3, 0);
  const auto& trees = markers.at("com/trees");
  ASSERT_EQ(trees.positions.size(), 3u);
  expect_point(trees.positions[0], 1, 0, 0.75);  // (1 kg at 0 + 3 kg at 1) / 4 kg
  expect_point(trees.positions[1], 0, 3, -1);
  expect_point(trees.positions[2], 0, 5, 0);
  EXPECT_FLOAT_EQ(trees.sizes.at(0)[0], 2 * 0.2f * 0.5f);
  const auto& tendons = markers.at("tendons/paths");
  ASSERT_EQ(tendons.positions.size(), 2u) << "the group of the other is hidden";
  expect_point(tendons.positions[0], 0, 0, 2);
  expect_point(tendons.positions[1], 1, 0, 1.25);
  EXPECT_EQ(tendons.colors.at(1), (std::array<uint8_t, 4>{0, 0, 255, 255}));
}

TEST_F(MujocoMarkers, NonFiniteElementsAreSkipped) {
  Simulation simulation = load(kMechanism);
  mjData& d = const_cast<mjData&>(simulation.data());  // like a simulation that has diverged
  d.xaxis[0] = std::nan("");
  d.subtree_com[3] = 1e300;
  const ByName markers = markers_of(simulation);
  EXPECT_TRUE(markers.at("joints/hinges").positions.empty());
  EXPECT_EQ(markers.at("joints/slides").positions.size(), 2u);
  EXPECT_EQ(markers.at("com/trees").positions.size(), 2u);
}

TEST_F(MujocoMarkers, PublisherSendsThemBeforeFrame) {
  auto link = std::move(transport::open_listener(test::listener_uri("shm")).value());
  Simulation simulation = load(kAtRest);
  for (int step = 0; step < 3; ++step) ASSERT_TRUE(simulation.step().ok());
  ASSERT_TRUE(simulation.update_poses().ok());
  Result<Publisher> publisher = Publisher::open(
      simulation.model(), {.uris = {link->uri()}, .show = kShowContacts | kShowCentresOfMass});
  ASSERT_TRUE(publisher.ok()) << publisher.error().message;
  ASSERT_TRUE(publisher->publish(simulation.model(), simulation.data()).ok());
  std::map<std::string, wire::Marker> seen;
  wire::Decoder decoder;
  ASSERT_TRUE(test::repeat_until([&] {
    link->wait(std::chrono::milliseconds(1));
    link->poll([&](const transport::LinkEvent& event) {
      if (event.kind != transport::LinkEvent::Kind::control) return;
      const auto message = decoder.decode(event.message);
      ASSERT_TRUE(message.ok()) << message.error().message;
      if (const auto* edit = std::get_if<wire::SceneEdit>(&*message))
        seen[edit->node] = std::get<wire::Marker>(edit->value);
    });
    return seen.size() == 2;
  }));
  const ByName meant = markers_of(simulation);
  for (const auto& [name, marker] : seen) {
    EXPECT_EQ(marker.positions, meant.at(name).positions) << name;
    EXPECT_FALSE(marker.positions.empty()) << name;
    EXPECT_EQ(marker.flags, wire::kMarkerOverlaid);
  }
}

TEST(MujocoShow, NamesAreListedOnce) {
  EXPECT_EQ(*shown_quantities("contacts,forces,joints,com,tendons"), kAll);
  EXPECT_EQ(*shown_quantities("com"), uint32_t{kShowCentresOfMass});
  for (const char* wrong : {"", "contact", "com,", "com,com", "Joints"})
    EXPECT_FALSE(shown_quantities(wrong).ok()) << wrong;
  EXPECT_NE(shown_quantities("all").error().message.find("contacts, forces, joints"), std::string::npos);
}

}  // namespace
}  // namespace fire3dv::mujoco
