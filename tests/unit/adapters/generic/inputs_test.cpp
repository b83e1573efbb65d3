// Test of inputs through the client library: declarations arrive, events come back in order and checked, and
// drags end when their renderer is gone.
#include "fire3dv/input.h"

#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "fire3dv/client.hpp"
#include "protocol/wire/input.h"
#include "tests/unit/adapters/generic/client_fixture.h"

namespace fire3dv::test {
namespace {

using wire::InputAction;

struct InputRenderer {
  std::unique_ptr<transport::ListenerLink> link;
  transport::PeerId peer = 0;
  wire::Decoder decoder;
  std::map<std::string, wire::Input> declared;
  uint64_t epoch = 0, scene_version = 1, frames = 0, sequence = 0;

  explicit InputRenderer(const std::string& uri) { link = std::move(*transport::open_listener(uri)); }
  void poll() {
    link->wait(std::chrono::milliseconds(1));
    link->poll([this](const transport::LinkEvent& event) {
      using Kind = transport::LinkEvent::Kind;
      if (event.kind != Kind::pose && event.kind != Kind::control) return;
      peer = event.peer;
      auto message = decoder.decode(event.message);
      ASSERT_TRUE(message.ok()) << message.error().message;
      if (const auto* description = std::get_if<wire::StreamDescription>(&*message)) {
        if (epoch != description->epoch) sequence = 0;
        epoch = description->epoch;
        declared.clear();
      }
      if (const auto* frame = std::get_if<wire::PoseFrameView>(&*message)) {
        scene_version = frame->header.scene_version;
        ++frames;
      }
      auto* edit = std::get_if<wire::SceneEdit>(&*message);
      if (!edit) return;
      if (auto* input = std::get_if<wire::Input>(&edit->value)) declared[edit->node] = *input;
      if (std::holds_alternative<wire::Cleared>(edit->value)) declared.erase(edit->node);
    });
  }
  void send(wire::InputEvent event) {
    event.epoch = event.epoch ? event.epoch : epoch;
    event.source = event.source ? event.source : 77;
    event.sequence = event.sequence ? event.sequence : ++sequence;
    link->send(peer, wire::encode(event));
  }
  void act(const std::string& input, InputAction action, double value = 0, uint32_t node = 0) {
    wire::InputEvent event;
    event.input = input;
    event.action = action;
    event.value = value;
    event.node = node;
    event.target = {value, 0, 0};
    send(event);
  }
};

class ClientInputs : public testing::TestWithParam<const char*> {
 protected:
  ClientInputs() : renderer_(listener_uri(GetParam())), stream_(renderer_.link->uri()) {
    stream_.describe({"base", "arm"});
  }

  int declare(const char* name, int kind, double maximum = 0, double value = 0) {
    fire3dv_input input{};
    input.struct_size = sizeof input;
    input.kind = kind;
    input.flags = kind == FIRE3DV_INPUT_RUN ? FIRE3DV_INPUT_RUN_PAUSE | FIRE3DV_INPUT_STEP : 0;
    input.maximum = maximum;
    input.value = value;
    return fire3dv_declare_input(stream_.get(), name, &input);
  }
  void declare_all() {
    ASSERT_EQ(declare("gain", FIRE3DV_INPUT_SLIDER, 2, 1), FIRE3DV_OK) << fire3dv_last_error();
    ASSERT_EQ(declare("kick", FIRE3DV_INPUT_BUTTON), FIRE3DV_OK) << fire3dv_last_error();
    ASSERT_EQ(declare("note", FIRE3DV_INPUT_TEXT), FIRE3DV_OK) << fire3dv_last_error();
    ASSERT_EQ(declare("run", FIRE3DV_INPUT_RUN, 0, 1), FIRE3DV_OK) << fire3dv_last_error();
    ASSERT_EQ(declare("drag", FIRE3DV_INPUT_DRAG, 0, 100), FIRE3DV_OK) << fire3dv_last_error();
    ASSERT_TRUE(repeat_until([&] {
      renderer_.poll();
      (void)stream_.poll();
      return renderer_.declared.size() == 5;
    }));
  }
  // Events until one of `kick` has come, which is not among them: what was sent before has come by then.
  std::vector<fire3dv_event> take() {
    renderer_.act("kick", InputAction::press);
    std::vector<fire3dv_event> found;
    EXPECT_TRUE(repeat_until([&] {
      renderer_.poll();
      fire3dv_event event{};
      event.struct_size = sizeof event;
      const int count = fire3dv_poll_events(stream_.get(), &event, 1);
      EXPECT_GE(count, 0) << fire3dv_last_error();
      if (count == 1 && std::strcmp(event.input, "kick") == 0) return true;
      if (count == 1) found.push_back(event);
      return false;
    }));
    return found;
  }

  InputRenderer renderer_;
  Stream stream_;
};

TEST_P(ClientInputs, EventsComeBack) {
  declare_all();
  EXPECT_EQ(renderer_.declared["gain"].maximum, 2);
  stream_.publish(std::chrono::nanoseconds(1), std::vector<Pose>(2));
  ASSERT_TRUE(repeat_until([&] {
    renderer_.poll();
    return renderer_.frames > 0;
  }));
  EXPECT_EQ(renderer_.scene_version, 0u) << "frames do not wait for inputs";
  wire::InputEvent note;
  note.input = "note";
  note.text = "K\u00f6rper";
  note.viewer = 4;
  note.time_ns = 9;
  note.sim_time_ns = -3;
  renderer_.send(note);
  renderer_.act("run", InputAction::pause);
  const std::vector<fire3dv_event> events = take();
  ASSERT_EQ(events.size(), 2u);
  EXPECT_STREQ(events[0].input, "note");
  EXPECT_STREQ(events[0].text, "K\u00f6rper");
  EXPECT_EQ(events[0].kind, FIRE3DV_INPUT_TEXT);
  EXPECT_EQ(events[0].action, FIRE3DV_EVENT_SET);
  EXPECT_EQ(events[0].viewer, 4u);
  EXPECT_EQ(events[0].source, 77u);
  EXPECT_EQ(events[0].time_ns, 9u);
  EXPECT_EQ(events[0].sim_time_ns, -3);
  EXPECT_EQ(events[0].lost, 0u);
  EXPECT_EQ(events[1].action, FIRE3DV_EVENT_PAUSE);
  // All viewers see the values that the program has.
  ASSERT_TRUE(repeat_until([&] {
    renderer_.poll();
    (void)stream_.poll();
    return renderer_.declared["note"].text == "K\u00f6rper" && renderer_.declared["run"].value == 0;
  }));
  stream_.describe({"base"});
  ASSERT_TRUE(repeat_until([&] {
    renderer_.poll();
    (void)stream_.poll();
    return renderer_.declared.size() == 5 && renderer_.declared["run"].value == 0;
  })) << "a new description keeps the inputs";
}

TEST_P(ClientInputs, NewestOfContinuousWinsAndOthersStay) {
  declare_all();
  for (int i = 1; i <= 20; ++i) {
    renderer_.act("gain", InputAction::set, 0.1 * i);
    if (i == 10) renderer_.act("run", InputAction::step, 3);
  }
  renderer_.act("drag", InputAction::begin, 1, 1);
  for (int i = 2; i <= 9; ++i) renderer_.act("drag", InputAction::move, i, 1);
  renderer_.act("drag", InputAction::end, 0, 1);
  ASSERT_TRUE(repeat_until([&] {
    (void)stream_.poll();  // lets them wait in the queue
    return stream_.poll().renderers == 1 && renderer_.link->stats().messages_sent >= 31;
  }));
  const std::vector<fire3dv_event> events = take();
  std::vector<int> steps, moves;
  double gain = 0;
  for (const fire3dv_event& event : events) {
    if (event.action == FIRE3DV_EVENT_STEP) steps.push_back(static_cast<int>(event.value));
    if (event.action == FIRE3DV_EVENT_MOVE) moves.push_back(static_cast<int>(event.target[0]));
    if (event.kind == FIRE3DV_INPUT_SLIDER) gain = event.value;
  }
  EXPECT_EQ(steps, std::vector<int>{3});
  EXPECT_EQ(gain, 2);
  ASSERT_FALSE(moves.empty());
  EXPECT_EQ(moves.back(), 9);
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(events.back().action, FIRE3DV_EVENT_END);
  EXPECT_EQ(events.back().node, 1u);
}

TEST_P(ClientInputs, WhatIsNotDeclaredIsDropped) {
  declare_all();
  renderer_.act("other", InputAction::press);
  renderer_.act("gain", InputAction::set, 2.5);     // above its range
  renderer_.act("gain", InputAction::press);        // no action of a slider
  renderer_.act("run", InputAction::reset);         // not among its flags
  renderer_.act("drag", InputAction::end, 1);       // nothing is held
  renderer_.act("drag", InputAction::begin, 1, 2);  // no such node
  wire::InputEvent late;
  late.input = "gain";
  late.epoch = renderer_.epoch ^ 1;
  renderer_.send(late);  // of another epoch
  late.epoch = 0;
  late.sequence = 1;
  renderer_.send(late);  // repeated
  renderer_.act("gain", InputAction::set, 0.5);
  const std::vector<fire3dv_event> events = take();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].value, 0.5);
  EXPECT_GE(events[0].lost, 6u);
}

TEST_P(ClientInputs, QueueIsBounded) {
  declare_all();
  constexpr size_t kSent = 1100, kQueued = 1024;
  size_t sent = 0;
  ASSERT_TRUE(repeat_until([&] {  // a ring of the link holds fewer
    for (int i = 0; i < 50 && sent < kSent; ++i, ++sent) renderer_.act("run", InputAction::step, 1);
    for (int i = 0; i < 4; ++i) (void)stream_.poll();
    renderer_.poll();
    return sent == kSent;
  }));
  renderer_.act("note", InputAction::set);
  size_t steps = 0, lost = 0;
  ASSERT_TRUE(repeat_until([&] {
    fire3dv_event event{};
    event.struct_size = sizeof event;
    while (fire3dv_poll_events(stream_.get(), &event, 1) == 1) {
      lost += event.lost;
      if (event.action == FIRE3DV_EVENT_STEP) ++steps;
    }
    renderer_.act("note", InputAction::set);
    return steps + lost >= kSent;
  }));
  EXPECT_GE(steps, kQueued / 2);
  EXPECT_LE(steps, kSent);
}

// The renderer was killed: nothing comes any more.
TEST_P(ClientInputs, LostDragsEnd) {
  declare_all();
  renderer_.act("drag", InputAction::begin, 1, 1);
  fire3dv_event event{};
  event.struct_size = sizeof event;
  ASSERT_TRUE(repeat_until([&] {
    renderer_.poll();
    return fire3dv_poll_events(stream_.get(), &event, 1) == 1;
  }));
  EXPECT_EQ(event.action, FIRE3DV_EVENT_BEGIN);
  renderer_.link.reset();
  ASSERT_TRUE(repeat_until([&] { return fire3dv_poll_events(stream_.get(), &event, 1) == 1; }));
  EXPECT_EQ(event.action, FIRE3DV_EVENT_END);
  EXPECT_EQ(event.node, 1u);
  EXPECT_EQ(event.time_ns, 0u);
}

// The renderer was stopped: it is connected, and nothing comes for kHoldTimeoutNs.
TEST_P(ClientInputs, SilentDragsEnd) {
  declare_all();
  renderer_.act("drag", InputAction::begin, 1, 1);
  ASSERT_EQ(take().size(), 1u);
  fire3dv_event event{};
  event.struct_size = sizeof event;
  ASSERT_TRUE(repeat_until([&] { return fire3dv_poll_events(stream_.get(), &event, 1) == 1; }));
  EXPECT_EQ(event.action, FIRE3DV_EVENT_END);
  EXPECT_EQ(stream_.poll().renderers, 1u);
  renderer_.act("drag", InputAction::move, 7, 1);  // it goes on
  const std::vector<fire3dv_event> events = take();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].action, FIRE3DV_EVENT_BEGIN);
  EXPECT_EQ(events[0].target[0], 7);
}

TEST_P(ClientInputs, ClearedInputsEndTheirDrags) {
  declare_all();
  renderer_.act("drag", InputAction::begin, 1, 1);
  ASSERT_EQ(take().size(), 1u);
  ASSERT_EQ(fire3dv_clear_input(stream_.get(), "drag"), FIRE3DV_OK);
  renderer_.act("drag", InputAction::move, 2, 1);
  const std::vector<fire3dv_event> events = take();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].action, FIRE3DV_EVENT_END);
  ASSERT_TRUE(repeat_until([&] {
    renderer_.poll();
    (void)stream_.poll();
    return !renderer_.declared.contains("drag");
  }));
  EXPECT_EQ(fire3dv_clear_input(stream_.get(), "drag"), FIRE3DV_OK) << "not declared is no error";
}

// Whoever reads the events need not know that the renderer's nodes are others now.
TEST_P(ClientInputs, NewDescriptionsEndDrags) {
  declare_all();
  renderer_.act("drag", InputAction::begin, 1, 1);
  ASSERT_EQ(take().size(), 1u);
  const uint64_t before = renderer_.epoch;
  stream_.describe({"arm"});
  ASSERT_TRUE(repeat_until([&] {
    renderer_.poll();
    (void)stream_.poll();
    return renderer_.epoch != before && renderer_.declared.size() == 5;
  }));
  const std::vector<fire3dv_event> events = take();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].action, FIRE3DV_EVENT_END);
  EXPECT_EQ(events[0].source, 77u);
  EXPECT_EQ(events[0].node, 1u);
}

INSTANTIATE_TEST_SUITE_P(Links, ClientInputs, testing::Values("shm", "tcp"));

// Without a key anyone could forge them.
TEST(ClientInputsOverUdp, AreIgnored) {
  InputRenderer renderer(listener_uri("udp"));
  Stream stream(renderer.link->uri());
  stream.describe({"base", "arm"});
  fire3dv_input kick{};
  kick.struct_size = sizeof kick;
  kick.kind = FIRE3DV_INPUT_BUTTON;
  ASSERT_EQ(fire3dv_declare_input(stream.get(), "kick", &kick), FIRE3DV_OK) << fire3dv_last_error();
  ASSERT_TRUE(repeat_until([&] {
    renderer.poll();
    (void)stream.poll();
    return renderer.declared.size() == 1;
  }));
  ASSERT_TRUE(repeat_until([&] {  // datagrams may be lost
    renderer.act("kick", InputAction::press);
    wire::Welcome welcome;
    welcome.epoch = renderer.epoch;
    renderer.link->send(renderer.peer, wire::encode(welcome));
    renderer.poll();
    fire3dv_event event{};
    event.struct_size = sizeof event;
    EXPECT_EQ(fire3dv_poll_events(stream.get(), &event, 1), 0);
    return poll(stream.get()).welcome == 0;
  }));
  fire3dv_event event{};
  event.struct_size = sizeof event;
  EXPECT_EQ(fire3dv_poll_events(stream.get(), &event, 1), 0);
}

TEST(ClientInputErrors, NameTheField) {
  Stream stream(silent_uri("shm"));
  const auto refused = [&](const char* name, const fire3dv_input& input, int code, const std::string& text) {
    EXPECT_EQ(fire3dv_declare_input(stream.get(), name, &input), code);
    EXPECT_NE(std::string(fire3dv_last_error()).find(text), std::string::npos) << fire3dv_last_error();
  };
  fire3dv_input input{};
  refused("a", input, FIRE3DV_ERROR_ARGUMENT, "struct_size");
  input.struct_size = sizeof input;
  input.kind = 99;
  refused("a", input, FIRE3DV_ERROR_ARGUMENT, "input.kind is 99");
  input.kind = FIRE3DV_INPUT_SLIDER;
  refused("a", input, FIRE3DV_ERROR_ARGUMENT, "maximum is 0");
  input.maximum = 1;
  input.value = NAN;
  refused("a", input, FIRE3DV_ERROR_ARGUMENT, "value is nan");
  input.value = 0;
  refused("", input, FIRE3DV_ERROR_ARGUMENT, "node is empty");
  refused(std::string(128, 'x').c_str(), input, FIRE3DV_ERROR_ARGUMENT, "128 bytes");
  refused(nullptr, input, FIRE3DV_ERROR_ARGUMENT, "name is NULL");
  input.kind = FIRE3DV_INPUT_CHOICE;
  input.choice_count = 100'000;
  refused("a", input, FIRE3DV_ERROR_ARGUMENT, "at most 256 choices");
  input = {};
  input.struct_size = sizeof input;
  input.kind = FIRE3DV_INPUT_BUTTON;
  for (int i = 0; i < FIRE3DV_MAX_INPUTS; ++i)
    ASSERT_EQ(fire3dv_declare_input(stream.get(), std::to_string(i).c_str(), &input), FIRE3DV_OK);
  refused("more", input, FIRE3DV_ERROR_BUDGET, "256 inputs");
  EXPECT_EQ(fire3dv_declare_input(stream.get(), "7", &input), FIRE3DV_OK) << "declared again";
  fire3dv_event event{};
  EXPECT_EQ(fire3dv_poll_events(stream.get(), &event, 1), FIRE3DV_ERROR_ARGUMENT);
  EXPECT_EQ(fire3dv_poll_events(stream.get(), nullptr, 1), FIRE3DV_ERROR_ARGUMENT);
  event.struct_size = 4097;
  EXPECT_EQ(fire3dv_poll_events(stream.get(), &event, 1), FIRE3DV_ERROR_ARGUMENT);
  event.struct_size = sizeof event;
  EXPECT_EQ(fire3dv_poll_events(stream.get(), &event, 1), 0);
}

}  // namespace
}  // namespace fire3dv::test
