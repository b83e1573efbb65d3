// Tests of people's hands on a MuJoCo simulation: the spring's force, what is released, actuators and the run
// bar.
#include "adapters/mujoco/interaction.h"

#include <unistd.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/transport/open.h"
#include "protocol/wire/decode.h"
#include "protocol/wire/encode.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/adapters/mujoco/models.h"

namespace fire3dv::mujoco {
namespace {

constexpr const char* kModel = R"(<mujoco>
  <option gravity="0 0 0" timestep="0.002"/> <visual><map stiffness="150"/></visual>
  <worldbody>
    <body name="box" pos="0 0 1"><freejoint/><geom type="box" size="0.1 0.2 0.3" mass="2"/>
      <body name="rod" pos="0 0 0.4"><joint name="hinge" axis="0 1 0"/><geom type="capsule" size="0.02 0.1" mass="1"/></body>
    </body>
  </worldbody>
  <actuator><motor name="a/b" joint="hinge" ctrllimited="true" ctrlrange="-3 2"/><motor joint="hinge"/></actuator>
</mujoco>)";

// A simulation, its stream, and the renderer's end of the link.
class MujocoInteraction : public testing::Test {
 protected:
  MujocoInteraction() : simulation_(make()), interaction_(simulation_.model(), true, 1) {
    static int count = 0;
    auto link = transport::open_listener("shm://mujoco-hands-" + std::to_string(::getpid()) + "-" +
                                         std::to_string(count++));
    EXPECT_TRUE(link.ok());
    link_ = std::move(*link);
    Result<Publisher> publisher = Publisher::open(simulation_.model(), {.uris = {link_->uri()}});
    EXPECT_TRUE(publisher.ok());
    publisher_.emplace(std::move(*publisher));
    const Result<void> declared = interaction_.declare(stream());
    EXPECT_TRUE(declared.ok()) << declared.error().message;
    while (declared_.size() < 4) listen();
  }

  Simulation make() { return loaded(folder_.write("model.xml", std::string_view(kModel)), Drive::hold); }
  fire3dv_stream* stream() { return publisher_->streams().front(); }
  void listen() {
    (void)publisher_->poll();
    link_->wait(std::chrono::milliseconds(1));
    link_->poll([this](const transport::LinkEvent& event) {
      if (event.message.empty()) return;
      peer_ = event.peer;
      auto message = decoder_.decode(event.message);
      ASSERT_TRUE(message.ok());
      if (const auto* description = std::get_if<wire::StreamDescription>(&*message))
        epoch_ = description->epoch;
      const auto* edit = std::get_if<wire::SceneEdit>(&*message);
      if (edit && std::holds_alternative<wire::Input>(edit->value))
        declared_[edit->node] = std::get<wire::Input>(edit->value);
    });
  }
  Interaction::Requests act(const std::string& input, wire::InputAction action, double value = 0,
                            uint32_t node = 0, std::array<double, 3> point = {},
                            std::array<double, 3> target = {}) {
    wire::InputEvent event;
    event.epoch = epoch_;
    event.source = 9;
    event.sequence = ++sequence_;
    event.input = input;
    event.action = action;
    event.value = value;
    event.node = node;
    event.node_point = point;
    event.target = target;
    link_->send(peer_, wire::encode(event));
    if (holds_back_) return {};
    const Result<Interaction::Requests> requests = interaction_.poll(stream(), 0);
    EXPECT_TRUE(requests.ok());
    return requests ? *requests : Interaction::Requests();
  }
  void step(int count = 1) {
    for (int i = 0; i < count; ++i)
      ASSERT_TRUE(simulation_.step([this](const mjModel& m, mjData& d) { interaction_.apply(m, d); }).ok());
  }
  const mjtNum* applied(int body) const { return simulation_.data().xfrc_applied + 6 * body; }

  test::ScratchFolder folder_;
  Simulation simulation_;
  Interaction interaction_;
  std::unique_ptr<transport::ListenerLink> link_;
  std::optional<Publisher> publisher_;
  wire::Decoder decoder_;
  transport::PeerId peer_ = 0;
  uint64_t epoch_ = 0, sequence_ = 0;
  bool holds_back_ = false;  // events for a later poll
  std::map<std::string, wire::Input> declared_;
};

TEST_F(MujocoInteraction, ForceIsThatOfTheSpring) {
  const std::array<double, 3> point{0.1, 0, 0}, target{0.3, 0.05, 1};
  act("drag", wire::InputAction::begin, 0, 0, point, target);
  step();
  // 150 N/m for each of the 3 kg of the box and the rod; the point rests at (0.1, 0, 1).
  EXPECT_NEAR(applied(1)[0], 450 * 0.2, 0.9);
  EXPECT_NEAR(applied(1)[1], 450 * 0.05, 0.225);
  EXPECT_NEAR(applied(1)[2], 0, 1e-6);
  // The centre of the box's mass is in the origin of its frame: torque = (0.1 0 0) x force.
  EXPECT_NEAR(applied(1)[5], 0.1 * 450 * 0.05, 0.03);
  EXPECT_GT(simulation_.data().qvel[0], 0) << "it moves towards the target";
  act("drag", wire::InputAction::end, 0, 0);
  step();
  for (int i = 0; i < 6; ++i) EXPECT_EQ(applied(1)[i], 0) << "it is released";
}

TEST_F(MujocoInteraction, DraggedPointComesToRestAtItsTarget) {
  const std::array<double, 3> target{0.2, -0.1, 1.3};
  act("drag", wire::InputAction::begin, 0, 0, {}, target);
  for (int i = 0; i < 60; ++i) {  // signs of life
    act("drag", wire::InputAction::move, 0, 0, {}, target);
    step(50);
  }
  ASSERT_TRUE(simulation_.update_poses().ok());
  for (size_t axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(simulation_.data().xpos[3 + axis], target[axis], 2e-3) << axis;
}

TEST_F(MujocoInteraction, SpringIsBounded) {
  act("drag", wire::InputAction::begin, 0, 0, {}, {1e12, 0, 0});
  step();
  EXPECT_LE(applied(1)[0], 450 * simulation_.model().stat.extent * 1.01);
  EXPECT_GT(applied(1)[0], 0);
}

TEST_F(MujocoInteraction, LeverIsBounded) {
  act("drag", wire::InputAction::begin, 0, 0, {1e12, 0, 0}, {0, 1, 1});
  step();
  const double reach = simulation_.model().stat.extent;
  EXPECT_GT(applied(1)[5], 0);
  EXPECT_LE(applied(1)[5], reach * 450 * reach);
}

TEST_F(MujocoInteraction, CamerasAreNotDragged) {
  act("drag", wire::InputAction::begin, 0, 5, {}, {1, 0, 0});  // no such node: refused by the client
  EXPECT_FALSE(interaction_.is_dragging());
}

TEST_F(MujocoInteraction, SlidersMoveActuators) {
  ASSERT_TRUE(declared_.contains("actuators/a_b"));
  EXPECT_EQ(declared_["actuators/a_b"].minimum, -3);
  EXPECT_EQ(declared_["actuators/a_b"].maximum, 2);
  EXPECT_EQ(declared_["actuators/actuator_1"].minimum, -1) << "without a range";
  act("actuators/a_b", wire::InputAction::set, 1.5);
  step();
  EXPECT_EQ(simulation_.data().ctrl[0], 1.5);
  EXPECT_EQ(simulation_.data().ctrl[1], 0);
  interaction_.reset();
  step();
  EXPECT_EQ(simulation_.data().ctrl[0], 0);
}

TEST_F(MujocoInteraction, RunBarIsRequested) {
  EXPECT_EQ(declared_["run"].value, 1);
  EXPECT_EQ(act("run", wire::InputAction::pause).is_running, false);
  const Interaction::Requests steps = act("run", wire::InputAction::step, 3);
  EXPECT_EQ(steps.steps, 3);
  EXPECT_FALSE(steps.is_running);
  EXPECT_TRUE(act("run", wire::InputAction::reset).reset);
  EXPECT_EQ(act("run", wire::InputAction::speed, 0.5).speed, 0.5);
  EXPECT_EQ(act("run", wire::InputAction::run).is_running, true);
}

TEST_F(MujocoInteraction, StepsAreBoundedAndEndWithARunAPauseOrAReset) {
  const auto act_at_once = [&](std::optional<wire::InputAction> last) {
    holds_back_ = true;
    for (int i = 0; i < 4; ++i) act("run", wire::InputAction::step, 1e6);
    if (last) act("run", *last);
    holds_back_ = false;
    return act("run", wire::InputAction::step, 2).steps;
  };
  EXPECT_EQ(act_at_once({}), Interaction::kMaxSteps);
  for (const auto action : {wire::InputAction::run, wire::InputAction::pause, wire::InputAction::reset})
    EXPECT_EQ(act_at_once(action), 2) << static_cast<int>(action);
}

}  // namespace
}  // namespace fire3dv::mujoco
