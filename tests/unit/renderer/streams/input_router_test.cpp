// Tests of events of people to streams: declared ones alone, the newest of continuous ones, rates, and the
// end of drags whose viewer has left.
#include <string>
#include <vector>

#include "tests/unit/renderer/streams/receiver_fixture.h"

namespace fire3dv::app {
namespace {

using wire::InputAction;
using wire::InputKind;

constexpr uint64_t kEpoch = 5;
constexpr PeerId kPeer = 1;

class InputRouterTest : public StreamReceiverTest {
 protected:
  InputRouterTest() {
    link_->deliver(kPeer, LinkEvent::Kind::connected);
    link_->deliver(kPeer, LinkEvent::Kind::control, description(kEpoch));
    receiver_.poll();
  }

  void declare(const std::string& name, wire::Input input) {
    link_->deliver(kPeer, LinkEvent::Kind::control,
                   wire::encode(wire::SceneEdit{kEpoch, ++version_, name, wire::Property::input, input}));
    receiver_.poll();
  }
  void declare_all() {
    wire::Input gain;
    gain.kind = InputKind::slider;
    gain.maximum = 1;
    declare("gain", gain);
    declare("kick", {});
    wire::Input drag;
    drag.kind = InputKind::drag;
    declare("drag", drag);
  }

  // The stream's connection is lost; another peer brings it back.
  void reconnect(PeerId from, PeerId to) {
    link_->deliver(from, LinkEvent::Kind::disconnected);
    receiver_.poll();
    EXPECT_FALSE(act("kick", InputAction::press)) << "the stream is away";
    link_->deliver(to, LinkEvent::Kind::connected);
    link_->deliver(to, LinkEvent::Kind::control, description(kEpoch));
    wire::Input kick;
    link_->deliver(to, LinkEvent::Kind::control,
                   wire::encode(wire::SceneEdit{kEpoch, ++version_, "kick", wire::Property::input, kick}));
    receiver_.poll();
  }

  bool act(const std::string& input, InputAction action, double value = 0, InputViewer viewer = 0) {
    wire::InputEvent event;
    event.input = input;
    event.action = action;
    event.value = value;
    event.target = {value, 0, 0};
    return receiver_.inputs().act(kEpoch, viewer, event);
  }
  std::vector<wire::InputEvent> events() { return answers<wire::InputEvent>(kPeer); }
  void advance(int64_t ns) {
    now_ns_ += ns;
    receiver_.poll();
  }

  uint64_t version_ = 0;
};

TEST_F(InputRouterTest, SendsWhatIsDeclared) {
  EXPECT_FALSE(act("kick", InputAction::press)) << "nothing is declared";
  EXPECT_TRUE(receiver_.inputs().streams().empty());
  declare_all();
  ASSERT_EQ(receiver_.inputs().streams().size(), 1u);
  EXPECT_TRUE(act("kick", InputAction::press, 0, 3));
  EXPECT_FALSE(act("kick", InputAction::set)) << "not an action of a button";
  EXPECT_FALSE(act("gain", InputAction::set, 1.5)) << "out of its range";
  EXPECT_FALSE(act("other", InputAction::press));
  EXPECT_FALSE(receiver_.inputs().act(kEpoch + 1, 0, {})) << "another stream";
  ASSERT_EQ(events().size(), 1u);
  EXPECT_EQ(events()[0].epoch, kEpoch);
  EXPECT_EQ(events()[0].sequence, 1u);
  EXPECT_EQ(events()[0].viewer, 3u);
  EXPECT_EQ(events()[0].input, "kick");
  EXPECT_NE(events()[0].source, 0u);
  EXPECT_EQ(receiver_.inputs().dropped(), 5u);
}

TEST_F(InputRouterTest, SendsNothingOverOtherLinks) {
  declare_all();
  link_->takes_input = false;
  EXPECT_FALSE(act("kick", InputAction::press));
  EXPECT_TRUE(receiver_.inputs().streams().empty());
  EXPECT_EQ(receiver_.inputs().revision(), 0u);
  EXPECT_TRUE(events().empty());
}

TEST_F(InputRouterTest, NewestOfContinuousWins) {
  declare_all();
  for (int i = 0; i <= 100; ++i) EXPECT_TRUE(act("gain", InputAction::set, 0.01 * i));
  EXPECT_EQ(events().size(), 1u) << "the others wait";
  EXPECT_TRUE(receiver_.inputs().is_busy());
  advance(InputRouter::kSendPeriodNs);
  ASSERT_EQ(events().size(), 2u);
  EXPECT_EQ(events()[0].value, 0);
  EXPECT_EQ(events()[1].value, 1);
  EXPECT_FALSE(receiver_.inputs().is_busy());
  advance(kSecondNs);
  EXPECT_EQ(events().size(), 2u) << "a slider is not repeated";
}

TEST_F(InputRouterTest, BoundsTheRateOfOthers) {
  declare_all();
  uint32_t taken = 0;
  for (int i = 0; i < 1000; ++i) taken += act("kick", InputAction::press);
  EXPECT_EQ(taken, InputRouter::kEventsPerSecond);
  EXPECT_EQ(events().size(), InputRouter::kEventsPerSecond) << "each that was taken was sent";
  now_ns_ += 2 * kSecondNs;
  EXPECT_TRUE(act("kick", InputAction::press));
}

TEST_F(InputRouterTest, DragsHaveBeginMovesAndEnd) {
  declare_all();
  EXPECT_FALSE(act("drag", InputAction::move, 1)) << "nothing is held";
  EXPECT_TRUE(act("drag", InputAction::begin, 1));
  EXPECT_FALSE(act("drag", InputAction::begin, 1)) << "held already";
  EXPECT_TRUE(act("drag", InputAction::move, 2));
  EXPECT_TRUE(act("drag", InputAction::move, 3));
  EXPECT_TRUE(act("drag", InputAction::end, 3));
  EXPECT_FALSE(act("drag", InputAction::end, 3));
  ASSERT_EQ(events().size(), 3u);
  EXPECT_EQ(events()[0].action, InputAction::begin);
  EXPECT_EQ(events()[1].action, InputAction::move);
  EXPECT_EQ(events()[1].target[0], 3) << "the last place comes before the end";
  EXPECT_EQ(events()[2].action, InputAction::end);
  advance(kSecondNs);
  EXPECT_EQ(events().size(), 3u);
}

TEST_F(InputRouterTest, HeldDragsGiveSignsOfLife) {
  declare_all();
  EXPECT_TRUE(act("drag", InputAction::begin, 1));
  advance(InputRouter::kRepeatPeriodNs);
  advance(InputRouter::kRepeatPeriodNs);
  ASSERT_EQ(events().size(), 3u);
  EXPECT_EQ(events()[2].action, InputAction::move);
  EXPECT_EQ(events()[2].target[0], 1);
  EXPECT_EQ(events()[2].sequence, 3u);
}

TEST_F(InputRouterTest, ViewerThatLeavesReleases) {
  declare_all();
  EXPECT_TRUE(act("drag", InputAction::begin, 1, 7));
  EXPECT_TRUE(act("drag", InputAction::begin, 1, 8));
  receiver_.inputs().release(7);
  ASSERT_EQ(events().size(), 3u);
  EXPECT_EQ(events()[2].action, InputAction::end);
  EXPECT_EQ(events()[2].viewer, 7u);
  EXPECT_TRUE(receiver_.inputs().is_busy()) << "the other one holds on";
  receiver_.inputs().release(7);
  EXPECT_EQ(events().size(), 3u);
}

TEST_F(InputRouterTest, NodesAreThoseOfTheStream) {
  declare_all();
  wire::InputEvent event;
  event.input = "drag";
  event.action = InputAction::begin;
  event.node = 1;
  EXPECT_FALSE(receiver_.inputs().act(kEpoch, 0, event)) << "the stream has one node";
}

TEST_F(InputRouterTest, EndedStreamsAreForgotten) {
  declare_all();
  EXPECT_TRUE(act("drag", InputAction::begin, 1));
  link_->deliver(kPeer, LinkEvent::Kind::control, wire::encode(wire::Goodbye{kEpoch}));
  advance(kSecondNs);
  EXPECT_FALSE(receiver_.inputs().is_busy());
  EXPECT_TRUE(receiver_.inputs().streams().empty());
  EXPECT_FALSE(act("drag", InputAction::end, 1));
}

// Its receiver drops events whose sequence is not above the last one.
TEST_F(InputRouterTest, SequencesGoOnAfterALostConnection) {
  declare_all();
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(act("kick", InputAction::press));
  ASSERT_EQ(events().size(), 3u);
  reconnect(kPeer, kPeer + 1);
  EXPECT_TRUE(act("kick", InputAction::press));
  const auto after = answers<wire::InputEvent>(kPeer + 1);
  ASSERT_EQ(after.size(), 1u);
  EXPECT_EQ(after[0].sequence, 4u);
  EXPECT_EQ(after[0].source, events()[0].source);
}

// A drag of an input that is declared as another kind is no drag any more.
TEST_F(InputRouterTest, KindsThatChangeRelease) {
  declare_all();
  EXPECT_TRUE(act("drag", InputAction::begin, 1));
  declare("drag", {});
  advance(kSecondNs);
  EXPECT_FALSE(receiver_.inputs().is_busy());
  EXPECT_EQ(events().size(), 1u) << "a button is not moved";
  EXPECT_TRUE(act("drag", InputAction::press));
}

TEST_F(InputRouterTest, TextsWithControlCharactersAreNotSent) {
  wire::Input note;
  note.kind = InputKind::text;
  declare("note", note);
  wire::InputEvent event;
  event.input = "note";
  event.text = "a\nb";
  EXPECT_FALSE(receiver_.inputs().act(kEpoch, 0, event));
  event.text = "ab";
  EXPECT_TRUE(receiver_.inputs().act(kEpoch, 0, event));
  ASSERT_EQ(events().size(), 1u);
  EXPECT_EQ(events()[0].sequence, 1u) << "what is dropped uses no number";
}

TEST_F(InputRouterTest, HostileDeclarationsAreRefused) {
  wire::Input gain;
  gain.kind = InputKind::slider;
  gain.maximum = 1;
  for (uint64_t i = 0; i < 1000; ++i) declare("input " + std::to_string(i), gain);
  EXPECT_EQ(poses_.streams()[0].inputs().inputs().size(), wire::kMaxInputs);
  EXPECT_EQ(count_of(receiver_.take_log_messages(), "at most 256 inputs"), 1u) << "said once";
  const uint64_t before = receiver_.rejected_messages();
  gain.value = std::numeric_limits<double>::quiet_NaN();
  declare("nan", gain);
  EXPECT_EQ(receiver_.rejected_messages(), before + 1);
}

}  // namespace
}  // namespace fire3dv::app
