// Test of the stream receiver without links and a GPU: a scripted listener delivers the messages.
#include "renderer/app/streams/stream_receiver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>

#include "protocol/wire/encode.h"
#include "renderer/app/options/stream_options.h"
#include "renderer/app/streams/image_requests.h"

namespace fire3dv::app {
namespace {

using transport::LinkEvent;
using transport::PeerId;

// Delivers the test's messages and records the replies.
class ScriptedListener final : public transport::ListenerLink {
 public:
  void poll(const std::function<void(const LinkEvent&)>& on_event) override {
    while (!script_.empty()) {
      const Entry entry = std::move(script_.front());
      script_.pop_front();
      on_event({entry.kind, entry.peer, entry.message, entry.text, 0});
    }
  }
  void wait(std::chrono::nanoseconds) override {}
  void pause_peer(PeerId peer, bool is_paused) override { pauses.emplace_back(peer, is_paused); }
  void send(PeerId peer, std::span<const std::byte> message) override {
    sent.emplace_back(peer, wire::Bytes(message.begin(), message.end()));
  }
  transport::LinkStats stats() const override { return {}; }
  std::string uri() const override { return address; }

  void deliver(PeerId peer, LinkEvent::Kind kind, wire::Bytes message = {}, std::string text = {}) {
    script_.push_back({kind, peer, std::move(message), std::move(text)});
  }

  bool carries_images() const override { return carries; }
  bool send_image(PeerId peer, uint64_t request, std::span<const std::byte>, size_t pixel_bytes,
                  const FillPixels& fill) override {
    std::vector<std::byte> pixels(pixel_bytes);
    fill(pixels);
    images.push_back({peer, request, std::move(pixels)});
    return true;
  }

  std::vector<std::pair<PeerId, wire::Bytes>> sent;
  std::vector<std::pair<PeerId, bool>> pauses;
  struct Image {
    PeerId peer;
    uint64_t request;
    std::vector<std::byte> pixels;
  };
  std::vector<Image> images;
  bool carries = true;
  std::string address = "test://listener";

 private:
  struct Entry {
    LinkEvent::Kind kind;
    PeerId peer;
    wire::Bytes message;
    std::string text;
  };
  std::deque<Entry> script_;
};

class StreamReceiverTest : public ::testing::Test {
 protected:
  StreamReceiverTest() : scene_(make_scene()), poses_(scene_), receiver_(poses_, false) {
    auto listener = std::make_unique<ScriptedListener>();
    link_ = listener.get();
    receiver_.add(std::move(listener));
    receiver_.set_clock([this] { return now_ns_ += step_ns_; });
  }

  static scene::Scene make_scene() {
    scene::Scene scene;
    scene::Node node;
    node.name = node.path = "arm";
    scene.nodes.push_back(node);
    return scene;
  }

  static wire::Bytes description(uint64_t epoch, const std::string& name = "adapter",
                                 std::vector<std::string> nodes = {"arm"}) {
    wire::StreamDescription d;
    d.epoch = epoch;
    d.adapter_name = name;
    d.node_names = std::move(nodes);
    return wire::encode(d);
  }
  static wire::Bytes visible(uint64_t epoch, uint64_t version) {
    return wire::encode(
        wire::SceneEdit{epoch, version, "arm", wire::Property::visible, wire::Visible{false}});
  }
  // Returns the epoch of the stream that drives the arm; 0: none.
  uint64_t driver() const {
    const std::optional<uint64_t> age = poses_.age_of_driver(0);
    for (const state::Stream& stream : poses_.streams()) {
      if (age && stream.active && stream.scene_node_of_pose[0] == 0) return stream.epoch;
    }
    return 0;
  }

  static wire::Bytes frame(uint64_t epoch, uint64_t sequence) {
    static const wire::Affine3x4 pose;
    wire::PoseFrameView view;
    view.header.epoch = epoch;
    view.header.sequence = sequence;
    view.node_count = 1;
    view.poses = {&pose, 1};
    return wire::encode(view);
  }

  static wire::ImageRequest image_request(uint64_t epoch, uint64_t id) {
    wire::ImageRequest request;
    request.epoch = epoch;
    request.id = id;
    request.place = static_cast<uint32_t>(id);
    request.intrinsics = {8, 4, 10, 10, 3.5f, 1.5f, 0.01f, 0, {}};
    request.when = wire::ImageWhen::every_nth;
    return request;
  }

  static size_t count_of(const std::vector<std::string>& log, const std::string& text) {
    return static_cast<size_t>(std::count_if(log.begin(), log.end(), [&](const std::string& line) {
      return line.find(text) != std::string::npos;
    }));
  }

  // Returns the answers of one type to a peer.
  template <typename T>
  std::vector<T> answers(PeerId peer) {
    std::vector<T> found;
    wire::Decoder decoder;
    for (const auto& [to, bytes] : link_->sent) {
      auto message = decoder.decode(bytes);
      EXPECT_TRUE(message.ok());
      if (to == peer && std::holds_alternative<T>(*message)) found.push_back(std::get<T>(*message));
    }
    return found;
  }

  scene::Scene scene_;
  state::PoseState poses_;
  StreamReceiver receiver_;
  ScriptedListener* link_ = nullptr;
  int64_t now_ns_ = 100'000'000'000;
  int64_t step_ns_ = 0;  // per clock read: once per handled message
};
constexpr int64_t kSecondNs = 1'000'000'000;

TEST_F(StreamReceiverTest, ImagesGoBackToWhoAskedForThem) {
  ImageRequestQueue requests(receiver_, {});
  receiver_.set_image_handler(&requests);
  link_->deliver(1, LinkEvent::Kind::control, description(42));
  link_->deliver(2, LinkEvent::Kind::control, description(43));
  link_->deliver(1, LinkEvent::Kind::control, wire::encode(image_request(42, 5)));
  link_->deliver(2, LinkEvent::Kind::control, wire::encode(image_request(43, 5)));
  link_->deliver(2, LinkEvent::Kind::control, wire::encode(image_request(42, 6)));  // of another peer's epoch
  link_->deliver(1, LinkEvent::Kind::pose, frame(42, 3));
  receiver_.poll();
  EXPECT_EQ(requests.count(), 2u);
  std::vector<state::ImageRequestRegistry::Due> due;
  for (const state::ImageDemand& demand : requests.demands(0)) {
    const auto images = requests.due(demand.requester, 0);
    due.insert(due.end(), images.begin(), images.end());
  }
  ASSERT_EQ(due.size(), 2u);
  for (const state::ImageRequestRegistry::Due& one : due) requests.mark_rendered(one);
  EXPECT_EQ(requests.demands(0).size(), 0u);
  EXPECT_EQ(due[0].sequence, 3u);
  EXPECT_EQ(due[1].sequence, 0u);
  wire::ImageFrame image;
  image.request = 5;
  image.pixel_bytes = 64;
  EXPECT_TRUE(
      requests.send(due[1].requester, image, [](std::span<std::byte> pixels) { pixels[0] = std::byte{9}; }));
  ASSERT_EQ(link_->images.size(), 1u);
  EXPECT_EQ(link_->images[0].peer, 2u);
  EXPECT_EQ(link_->images[0].request, 5u);
  EXPECT_EQ(link_->images[0].pixels[0], std::byte{9});

  link_->deliver(2, LinkEvent::Kind::disconnected, {}, "it left");
  receiver_.poll();
  EXPECT_EQ(requests.count(), 1u);
  EXPECT_FALSE(requests.send(due[1].requester, image, [](std::span<std::byte>) {}));
  // An impossible request ends, and its peer gets the reason.
  requests.refuse(due[0], wire::ImageRefusal::unknown_camera, "no such node");
  EXPECT_EQ(requests.count(), 0u);
  const auto refused = answers<wire::ImageRefused>(1);
  ASSERT_EQ(refused.size(), 1u);
  EXPECT_EQ(refused[0].request, 5u);
  EXPECT_EQ(refused[0].message, "no such node");
  const std::vector<std::string> log = receiver_.take_log_messages();
  ASSERT_FALSE(log.empty());
  EXPECT_EQ(log.back(), "warning: image request of stream \"adapter\" refused: no such node");
}

TEST_F(StreamReceiverTest, ImagesThatCannotBeHadAreRefusedWithAReason) {
  const auto last_refusal = [&] {
    receiver_.poll();
    const auto refused = answers<wire::ImageRefused>(1);
    return refused.empty() ? wire::ImageRefused{} : refused.back();
  };
  link_->deliver(1, LinkEvent::Kind::control, description(42));
  link_->deliver(1, LinkEvent::Kind::control, wire::encode(image_request(42, 1)));
  EXPECT_EQ(last_refusal().reason, wire::ImageRefusal::no_way_back) << "there is no handler";
  ImageRequestQueue requests(receiver_, {});
  receiver_.set_image_handler(&requests);
  link_->carries = false;
  link_->deliver(1, LinkEvent::Kind::control, wire::encode(image_request(42, 2)));
  EXPECT_EQ(last_refusal().request, 2u);
  EXPECT_EQ(last_refusal().reason, wire::ImageRefusal::no_way_back);
  link_->carries = true;
  wire::ImageRequest bad = image_request(42, 3);
  bad.intrinsics.fx = -1;
  link_->deliver(1, LinkEvent::Kind::control, wire::encode(bad));
  EXPECT_EQ(last_refusal().request, 3u);
  EXPECT_EQ(last_refusal().reason, wire::ImageRefusal::bad_request);
  EXPECT_NE(last_refusal().message.find("fx"), std::string::npos) << last_refusal().message;
  bad = image_request(42, 4);
  bad.outputs = 1u << 30;
  link_->deliver(1, LinkEvent::Kind::control, wire::encode(bad));
  EXPECT_EQ(last_refusal().reason, wire::ImageRefusal::not_supported);
  EXPECT_EQ(requests.count(), 0u);
  EXPECT_EQ(answers<wire::Welcome>(1).size(), 1u) << "a bad request says nothing of the description";
  link_->deliver(7, LinkEvent::Kind::control, wire::encode(image_request(42, 1)));
  receiver_.poll();
  EXPECT_EQ(receiver_.refusals()[static_cast<size_t>(Refusal::before_description)], 1u);
}

TEST_F(StreamReceiverTest, AStreamThatComesBackOverAnotherConnectionKeepsItsNodes) {
  link_->deliver(1, LinkEvent::Kind::control, description(42));
  link_->deliver(1, LinkEvent::Kind::pose, frame(42, 1));
  EXPECT_TRUE(receiver_.poll());
  link_->deliver(3, LinkEvent::Kind::control, description(7));
  // The first connection is dead, and its time-out has not expired.
  link_->deliver(2, LinkEvent::Kind::control, description(42));
  link_->deliver(2, LinkEvent::Kind::pose, frame(42, 2));
  EXPECT_FALSE(receiver_.poll());
  EXPECT_EQ(answers<wire::Ping>(1).size(), 1u) << "it may be alive";
  ASSERT_EQ(answers<wire::Status>(1).size(), 1u);
  EXPECT_EQ(answers<wire::Status>(1)[0].contested_names, std::vector<std::string>{"arm"});
  EXPECT_NE(answers<wire::Status>(1)[0].message.find("another connection"), std::string::npos);
  now_ns_ += 2 * kSecondNs - 1;
  EXPECT_FALSE(receiver_.poll());
  EXPECT_TRUE(answers<wire::Welcome>(2).empty());
  now_ns_ += 1;
  receiver_.poll();
  EXPECT_TRUE(receiver_.poll());
  EXPECT_EQ(receiver_.active_streams(), 2u);
  ASSERT_EQ(answers<wire::Welcome>(2).size(), 1u);
  EXPECT_TRUE(answers<wire::Welcome>(2)[0].conflicting_names.empty());
  ASSERT_EQ(poses_.shown().size(), 1u);
  EXPECT_EQ(poses_.shown()[0].sequence, 2u);
  EXPECT_NE(poses_.node_drives()[0].stream, state::kNone);

  link_->deliver(1, LinkEvent::Kind::disconnected, {},
                 "timed out");  // the late time-out of the old connection changes nothing
  now_ns_ += 10 * kSecondNs;
  receiver_.poll();
  EXPECT_EQ(receiver_.active_streams(), 2u);
  EXPECT_EQ(driver(), 42u);
}

TEST_F(StreamReceiverTest, AnEpochIsNotEnoughToTakeAStreamOver) {
  link_->deliver(1, LinkEvent::Kind::control, description(42));
  link_->deliver(1, LinkEvent::Kind::pose, frame(42, 1));
  receiver_.poll();
  now_ns_ += 10 * kSecondNs;  // a simulator that pauses
  link_->deliver(2, LinkEvent::Kind::control, description(42));
  link_->deliver(2, LinkEvent::Kind::pose, frame(42, 9));
  receiver_.poll();
  now_ns_ += kSecondNs / 4;
  const std::vector<wire::Ping> pings = answers<wire::Ping>(1);
  ASSERT_EQ(pings.size(), 1u);
  link_->deliver(1, LinkEvent::Kind::control,
                 wire::encode(wire::Pong{pings[0].id, pings[0].sender_time_ns, 5'000'000'000}));
  for (int i = 0; i < 3; ++i) {
    receiver_.poll();
    now_ns_ += kSecondNs / 4;
  }
  ASSERT_EQ(answers<wire::Welcome>(2).size(), 1u);
  EXPECT_EQ(answers<wire::Welcome>(2)[0].status, wire::WelcomeStatus::refused);
  EXPECT_EQ(answers<wire::Welcome>(2)[0].epoch, 42u);
  EXPECT_EQ(receiver_.active_streams(), 1u);
  EXPECT_EQ(poses_.shown().at(0).sequence, 1u);
  EXPECT_EQ(receiver_.rejected_messages(), 1u) << "the frame";
  // A peer with its own stream cannot take it over either.
  link_->deliver(3, LinkEvent::Kind::control, description(7, "other"));
  link_->deliver(3, LinkEvent::Kind::control, description(42));
  receiver_.poll();
  link_->deliver(1, LinkEvent::Kind::pose, frame(42, 2));
  now_ns_ += 1;
  EXPECT_TRUE(receiver_.poll());
  receiver_.poll();
  EXPECT_EQ(driver(), 42u);
  EXPECT_EQ(answers<wire::Welcome>(3).back().status, wire::WelcomeStatus::refused);
}

TEST_F(StreamReceiverTest, AStreamThatLosesItsLinkFindsItsPlaceAgain) {
  link_->deliver(1, LinkEvent::Kind::control, description(1));
  link_->deliver(2, LinkEvent::Kind::control, description(2, "waits"));
  link_->deliver(1, LinkEvent::Kind::disconnected, {}, "reset");
  receiver_.poll();
  EXPECT_EQ(driver(), 0u);
  link_->deliver(3, LinkEvent::Kind::control, description(1, "another name"));
  receiver_.poll();
  EXPECT_EQ(driver(), 0u) << "neither who waits nor who pretends";
  link_->deliver(3, LinkEvent::Kind::control, wire::encode(wire::Goodbye{1}));
  now_ns_ += 5 * kSecondNs - 1;
  link_->deliver(4, LinkEvent::Kind::control, description(1));
  receiver_.poll();
  EXPECT_EQ(driver(), 1u);
  now_ns_ += 10 * kSecondNs;
  receiver_.poll();
  EXPECT_EQ(driver(), 1u);
  link_->deliver(4, LinkEvent::Kind::control, wire::encode(wire::Goodbye{1}));
  receiver_.poll();
  EXPECT_EQ(driver(), 2u) << "who says goodbye leaves no place";
}

TEST_F(StreamReceiverTest, APublisherThatIsStartedAgainHasThePlaceUntilTheRunBeforeReturns) {
  link_->deliver(1, LinkEvent::Kind::control, description(1));
  link_->deliver(2, LinkEvent::Kind::control, description(2, "waits"));
  link_->deliver(1, LinkEvent::Kind::disconnected, {}, "reset");
  link_->deliver(3, LinkEvent::Kind::control, description(3));
  link_->deliver(4, LinkEvent::Kind::control, description(4));
  receiver_.poll();
  EXPECT_EQ(driver(), 3u) << "of that name";
  now_ns_ += 4 * kSecondNs;
  link_->deliver(5, LinkEvent::Kind::control, description(1));
  receiver_.poll();
  EXPECT_EQ(driver(), 1u) << "that epoch";
  EXPECT_EQ(answers<wire::Welcome>(3).back().status, wire::WelcomeStatus::refused);
  EXPECT_EQ(receiver_.active_streams(), 3u);
  link_->deliver(5, LinkEvent::Kind::disconnected, {}, "reset");
  link_->deliver(6, LinkEvent::Kind::control, description(6));
  receiver_.poll();
  EXPECT_EQ(driver(), 4u) << "of that name, and there already";
  now_ns_ += 6 * kSecondNs;
  link_->deliver(7, LinkEvent::Kind::control, description(1));
  receiver_.poll();
  EXPECT_EQ(driver(), 4u) << "too late";
}

// Over UDP a killed publisher times out only after seconds.
TEST_F(StreamReceiverTest, APublisherThatIsStartedAgainBeforeItsEndIsNoticedGetsTheNodesAtOnce) {
  link_->deliver(1, LinkEvent::Kind::control, description(1));
  link_->deliver(2, LinkEvent::Kind::control, description(2, "waits"));
  link_->deliver(3, LinkEvent::Kind::control, description(3));
  receiver_.poll();
  EXPECT_EQ(driver(), 1u);
  link_->deliver(1, LinkEvent::Kind::disconnected, {}, "nothing came from it for 10 seconds");
  receiver_.poll();
  EXPECT_EQ(driver(), 3u);
  link_->deliver(4, LinkEvent::Kind::control, description(1));  // only its link was lost
  receiver_.poll();
  EXPECT_EQ(driver(), 1u);
  EXPECT_EQ(answers<wire::Welcome>(3).back().status, wire::WelcomeStatus::refused);
  EXPECT_EQ(receiver_.active_streams(), 2u);
}

TEST_F(StreamReceiverTest, AStreamThatDescribesItselfAnewKeepsItsNodes) {
  link_->deliver(1, LinkEvent::Kind::control, description(1));
  link_->deliver(2, LinkEvent::Kind::control, description(2));
  for (uint64_t epoch = 3; epoch < 20; ++epoch) {
    link_->deliver(1, LinkEvent::Kind::control, description(epoch));
    receiver_.poll();
    EXPECT_EQ(driver(), epoch);
  }
  EXPECT_EQ(answers<wire::Welcome>(2).size(), 1u) << "nothing changed for the one that waits";
}

TEST_F(StreamReceiverTest, ASegmentHasOnePublisherThatMayStartAgain) {
  link_->address = "shm://robot";
  link_->deliver(1, LinkEvent::Kind::control, description(1));
  link_->deliver(9, LinkEvent::Kind::control, description(9, "waits"));
  link_->deliver(1, LinkEvent::Kind::disconnected, {}, "killed");
  link_->deliver(2, LinkEvent::Kind::control, description(2, "restarted"));
  receiver_.poll();
  EXPECT_EQ(driver(), 2u);
}

TEST_F(StreamReceiverTest, APeerWithManyMessagesDelaysOthersByOneSlice) {
  link_->deliver(1, LinkEvent::Kind::control, description(1, "busy", {"nothing"}));
  link_->deliver(2, LinkEvent::Kind::connected);
  receiver_.poll();
  step_ns_ = 1'000'000;  // a slice is two messages
  constexpr uint64_t kEdits = 1000;
  for (uint64_t version = 1; version <= kEdits; ++version)
    link_->deliver(1, LinkEvent::Kind::control, visible(1, version));
  link_->deliver(2, LinkEvent::Kind::control, description(2));
  link_->deliver(2, LinkEvent::Kind::pose, frame(2, 1));
  EXPECT_TRUE(receiver_.poll());
  EXPECT_EQ(poses_.streams()[1].header.sequence, 1u);
  EXPECT_EQ(poses_.streams()[0].edits_received, 2u);
  EXPECT_EQ(receiver_.deferred_messages(), kEdits - 2);
  const auto budget = poses_.take_scene_changes().at(0).budget;
  EXPECT_GT(budget->used(Resource::received_bytes), (kEdits - 2) * visible(1, 1).size());
  const int64_t begin_ns = now_ns_;
  for (uint64_t i = 2; i <= 200; ++i) {
    link_->deliver(2, LinkEvent::Kind::pose, frame(2, i));
    const uint64_t before = poses_.streams()[0].edits_received;
    EXPECT_TRUE(receiver_.poll());
    EXPECT_EQ(poses_.streams()[1].header.sequence, i);
    EXPECT_LE(poses_.streams()[0].edits_received - before, 2u);
  }
  const auto quarter = static_cast<uint64_t>((now_ns_ - begin_ns) / step_ns_ / 4);
  EXPECT_LE(poses_.streams()[0].edits_received, quarter + 2) << "a quarter of the time";
  EXPECT_GE(poses_.streams()[0].edits_received, quarter / 2) << "and not much less";
  step_ns_ = 0;
  now_ns_ += 1'000'000'000;
  receiver_.poll();
  EXPECT_EQ(poses_.streams()[0].edits_received, kEdits) << "in order: none was stale";
  EXPECT_EQ(poses_.streams()[0].edits_stale, 0u);
  EXPECT_EQ(receiver_.deferred_messages(), 0u);
  EXPECT_EQ(budget->used(Resource::received_bytes), 0u);
}

TEST_F(StreamReceiverTest, ALinkKeepsTheMessagesOfAPeerWhoseMessagesWait) {
  link_->deliver(1, LinkEvent::Kind::control, description(1, "busy", {"nothing"}));
  link_->deliver(2, LinkEvent::Kind::connected);
  receiver_.poll();
  step_ns_ = 1'000'000;  // a slice is two messages
  for (uint64_t version = 1; version <= 5; ++version)
    link_->deliver(1, LinkEvent::Kind::control, visible(1, version));
  receiver_.poll();
  ASSERT_EQ(receiver_.deferred_messages(), 3u);
  using Pauses = std::vector<std::pair<PeerId, bool>>;
  EXPECT_EQ(link_->pauses, (Pauses{{1, true}}));
  for (int turn = 0; turn < 2; ++turn) {
    now_ns_ += 10'000'000;  // its rest is over
    receiver_.poll();
  }
  ASSERT_EQ(receiver_.deferred_messages(), 0u);
  EXPECT_EQ(link_->pauses, (Pauses{{1, true}, {1, false}}));
}

TEST_F(StreamReceiverTest, OfPosesThatWaitTheNewestIsHandled) {
  link_->deliver(1, LinkEvent::Kind::control, description(1));
  link_->deliver(2, LinkEvent::Kind::connected);
  receiver_.poll();
  step_ns_ = 1'000'000;
  for (uint64_t version = 1; version <= 9; ++version)
    link_->deliver(1, LinkEvent::Kind::control, visible(1, version));
  for (uint64_t i = 1; i <= 100; ++i) link_->deliver(1, LinkEvent::Kind::pose, frame(1, i));
  receiver_.poll();
  EXPECT_EQ(receiver_.deferred_messages(), 8u) << "seven edits and a frame";
  int polls = 1;
  while (!receiver_.poll()) {
    now_ns_ += 10'000'000;  // its rest is over
    ASSERT_LT(++polls, 10);
  }
  EXPECT_EQ(poses_.shown().at(0).sequence, 100u);
  EXPECT_EQ(poses_.streams()[0].frames_received, 1u);
}

TEST_F(StreamReceiverTest, InLockstepAllIsHandledInOrder) {
  state::PoseState poses(scene_);
  StreamReceiver receiver(poses, true);
  auto listener = std::make_unique<ScriptedListener>();
  ScriptedListener* const link = listener.get();
  receiver.add(std::move(listener));
  receiver.set_clock([this] { return now_ns_ += 10'000'000; });  // five slices a message
  link->deliver(2, LinkEvent::Kind::control, description(2, "second", {"nothing"}));
  link->deliver(1, LinkEvent::Kind::control, description(1));
  for (uint64_t i = 1; i <= 3; ++i) {
    link->deliver(2, LinkEvent::Kind::pose, frame(2, i));
    link->deliver(1, LinkEvent::Kind::pose, frame(1, i));
  }
  for (uint64_t i = 1; i <= 3; ++i) {
    EXPECT_TRUE(receiver.poll());
    EXPECT_EQ(poses.streams()[0].header.sequence, i);
    EXPECT_EQ(poses.streams()[1].header.sequence, i - 1);
    EXPECT_TRUE(receiver.poll());
    EXPECT_EQ(poses.streams()[1].header.sequence, i);
  }
  EXPECT_FALSE(receiver.poll());
}

TEST_F(StreamReceiverTest, APeerThatDescribesItselfAThousandTimesDelaysNobody) {
  step_ns_ = 1'000'000;
  link_->deliver(2, LinkEvent::Kind::control, description(5000));
  receiver_.poll();
  uint64_t epoch = 0;
  for (uint64_t i = 1; i <= 10; ++i) {
    for (int n = 0; n < 100; ++n) link_->deliver(1, LinkEvent::Kind::control, description(++epoch));
    link_->deliver(2, LinkEvent::Kind::pose, frame(5000, i));
    const uint64_t before = poses_.name_lookups();
    EXPECT_TRUE(receiver_.poll());
    EXPECT_LE(poses_.name_lookups() - before, 10u) << "two descriptions a poll";
  }
  EXPECT_EQ(driver(), 5000u);
  EXPECT_LE(answers<wire::Status>(2).size(), 10u) << "the other one hears of it once a poll at most";
}

TEST_F(StreamReceiverTest, APeerWithLongMessagesRestsAfterEach) {
  link_->deliver(2, LinkEvent::Kind::control, description(5000));
  receiver_.poll();
  link_->deliver(1, LinkEvent::Kind::control, description(1, "large"));
  link_->deliver(1, LinkEvent::Kind::control, description(2, "large"));
  step_ns_ = 100'000'000;
  receiver_.poll();
  step_ns_ = 1;
  EXPECT_EQ(receiver_.deferred_messages(), 1u);
  now_ns_ += 100'000'000;
  for (uint64_t i = 1; i <= 100; ++i) {
    link_->deliver(2, LinkEvent::Kind::pose, frame(5000, i));
    EXPECT_TRUE(receiver_.poll());
    EXPECT_EQ(receiver_.deferred_messages(), 1u);
  }
  now_ns_ += 200'000'000;
  receiver_.poll();
  EXPECT_EQ(receiver_.deferred_messages(), 0u);
}

TEST_F(StreamReceiverTest, APeerRestsAfterLongEdits) {
  link_->deliver(1, LinkEvent::Kind::control, description(1, "editor", {"nothing"}));
  link_->deliver(2, LinkEvent::Kind::control, description(2));
  receiver_.poll();
  uint64_t version = 0;
  const auto edits_after = [&](int64_t edit_ns, int64_t pause_ns) {
    receiver_.add_edit_time(0, edit_ns);
    now_ns_ += pause_ns;
    link_->deliver(1, LinkEvent::Kind::control, visible(1, ++version));
    receiver_.poll();
    return poses_.streams()[0].edits_received;
  };
  EXPECT_EQ(edits_after(1'000'000, 1'000), 1u) << "less than a slice";
  EXPECT_EQ(edits_after(10'000'000, 25'000'000), 1u) << "it rests for 30 ms";
  now_ns_ += 10'000'000;
  receiver_.poll();
  EXPECT_EQ(poses_.streams()[0].edits_received, 2u);
}

TEST_F(StreamReceiverTest, ADescriptionBeyondTheBudgetIsRefused) {
  PeerLimits limits;
  limits.of(Resource::names) = 10;
  state::PoseState poses(scene_);
  StreamReceiver receiver(poses, false, {}, BudgetPool::create(limits));
  auto listener = std::make_unique<ScriptedListener>();
  link_ = listener.get();
  receiver.add(std::move(listener));
  std::vector<std::string> nodes;
  for (int i = 0; i < 11; ++i) nodes.push_back(std::to_string(i));
  link_->deliver(1, LinkEvent::Kind::control, description(1, "large", nodes));
  receiver.poll();
  EXPECT_EQ(receiver.active_streams(), 0u);
  ASSERT_EQ(answers<wire::Welcome>(1).size(), 1u);
  EXPECT_EQ(answers<wire::Welcome>(1)[0].status, wire::WelcomeStatus::bad_description);
  EXPECT_NE(answers<wire::Welcome>(1)[0].message.find("--peer-limit names="), std::string::npos);
  nodes.pop_back();
  for (uint64_t epoch = 2; epoch < 10; ++epoch)  // a replaced description is not charged
    link_->deliver(1, LinkEvent::Kind::control, description(epoch, "large", nodes));
  receiver.poll();
  EXPECT_EQ(answers<wire::Welcome>(1).back().status, wire::WelcomeStatus::accepted);
}

TEST_F(StreamReceiverTest, ReportsNodesThatLoseTheirScaleOnce) {
  scene_.nodes[0].world_from_node = scene_.nodes[0].parent_from_node =
      glm::mat4(glm::mat3(0.01f));  // a mesh in centimetres
  link_->deliver(1, LinkEvent::Kind::control, description(42));
  receiver_.poll();
  EXPECT_EQ(count_of(receiver_.take_log_messages(), "without the scale"), 0u) << "before a frame";
  for (uint64_t sequence = 1; sequence <= 3; ++sequence) {
    link_->deliver(1, LinkEvent::Kind::pose, frame(42, sequence));
    receiver_.poll();
  }
  const std::vector<std::string> log = receiver_.take_log_messages();
  EXPECT_EQ(count_of(log,
                     "warning: stream \"adapter\" moves 1 node without the scale of the scene file: "
                     "\"arm\"; multiply the scale into the poses"),
            1u);
  EXPECT_EQ(count_of(log, "without the scale"), 1u);
  const auto statuses = answers<wire::Status>(1);
  ASSERT_EQ(statuses.size(), 1u);
  EXPECT_NE(statuses[0].message.find("without the scale of the scene file: \"arm\""), std::string::npos);
}

TEST_F(StreamReceiverTest, ReportsStalledStreamsUnlessAReplayStands) {
  const auto stalled = [&] {
    receiver_.poll();
    return count_of(receiver_.take_log_messages(), "stalled");
  };
  link_->deliver(1, LinkEvent::Kind::control, description(42));
  link_->deliver(1, LinkEvent::Kind::pose, frame(42, 1));
  EXPECT_EQ(stalled(), 0u);
  receiver_.expect_frames(false);
  now_ns_ += 60'000'000'000;
  EXPECT_EQ(stalled(), 0u) << "paused";
  receiver_.expect_frames(true);
  EXPECT_EQ(stalled(), 0u) << "the first frame needs a moment";
  now_ns_ += 2'000'000'000;
  EXPECT_EQ(stalled(), 1u);
}

TEST_F(StreamReceiverTest, ReportsPosesOfZerosOnce) {
  const wire::Affine3x4 zeros{{}};
  wire::PoseFrameView view;
  view.header.epoch = 42;
  view.node_count = 1;
  view.poses = {&zeros, 1};
  link_->deliver(1, LinkEvent::Kind::control, description(42));
  for (view.header.sequence = 1; view.header.sequence <= 3; ++view.header.sequence) {
    link_->deliver(1, LinkEvent::Kind::pose, wire::encode(view));
    receiver_.poll();
  }
  const std::vector<std::string> log = receiver_.take_log_messages();
  EXPECT_EQ(count_of(log, "warning: stream \"adapter\" has poses of zeros only for 1 node: \"arm\""), 1u);
  const auto statuses = answers<wire::Status>(1);
  ASSERT_EQ(statuses.size(), 1u);
  EXPECT_NE(statuses[0].message.find("ones on its diagonal"), std::string::npos);
}

TEST_F(StreamReceiverTest, PosesWithTheScaleOfTheSceneAreNotReported) {
  scene_.nodes[0].world_from_node = scene_.nodes[0].parent_from_node = glm::mat4(glm::mat3(0.01f));
  wire::Affine3x4 scaled;
  scaled.m = {0, -0.01f, 0, 5, 0.01f, 0, 0, 0, 0, 0, 0.01f, 0};
  wire::PoseFrameView view;
  view.header.epoch = 42;
  view.header.sequence = 1;
  view.node_count = 1;
  view.poses = {&scaled, 1};
  // The scale in body_from_node counts as well.
  wire::StreamDescription offset;
  offset.epoch = 43;
  offset.adapter_name = "offset";
  offset.node_names = {"arm"};
  wire::Affine3x4 shrink;
  shrink.m = {0.01f, 0, 0, 0, 0, 0.01f, 0, 0, 0, 0, 0.01f, 0};
  offset.body_from_node = {shrink};
  link_->deliver(1, LinkEvent::Kind::control, description(42));
  link_->deliver(1, LinkEvent::Kind::pose, wire::encode(view));
  receiver_.poll();
  link_->deliver(1, LinkEvent::Kind::control, wire::encode(offset));
  link_->deliver(1, LinkEvent::Kind::pose, frame(43, 1));
  receiver_.poll();
  EXPECT_EQ(driver(), 43u);
  EXPECT_EQ(count_of(receiver_.take_log_messages(), "without the scale"), 0u);
}

TEST_F(StreamReceiverTest, BadConnectionsDoNotHideWhatOthersSay) {
  for (PeerId peer = 1; peer <= 80; ++peer)
    link_->deliver(peer, LinkEvent::Kind::control, wire::Bytes(100, std::byte{0x5a}));
  for (uint64_t epoch = 1; epoch <= 1000; ++epoch)
    link_->deliver(81, LinkEvent::Kind::control, description(epoch));
  link_->deliver(82, LinkEvent::Kind::control, description(2000, "honest"));
  receiver_.poll();
  const std::vector<std::string> log = receiver_.take_log_messages();
  // Each bad peer is logged once, the one that describes itself anew ten times a second.
  EXPECT_EQ(count_of(log, "warning: dropped a message from test://listener peer "), 80u);
  EXPECT_EQ(count_of(log, "stream \"adapter\""), 10u);
  EXPECT_EQ(count_of(log, "stream \"honest\" with 1 node accepted; another stream drives \"arm\""), 1u);
  EXPECT_EQ(log.size(), 91u);
}

// The disconnected stream keeps its nodes for a grace time.
TEST_F(StreamReceiverTest, AnotherStreamOnTheSameNodeIsToldAndGetsItWhenItIsFree) {
  link_->deliver(1, LinkEvent::Kind::control, description(1));
  link_->deliver(2, LinkEvent::Kind::control, description(2, "another"));
  receiver_.poll();
  ASSERT_EQ(answers<wire::Welcome>(2).size(), 1u);
  EXPECT_EQ(answers<wire::Welcome>(2)[0].conflicting_names, std::vector<std::string>{"arm"});
  link_->deliver(1, LinkEvent::Kind::disconnected, {}, "it left");
  receiver_.poll();
  EXPECT_EQ(answers<wire::Welcome>(2).size(), 1u);
  now_ns_ += 5 * kSecondNs;
  receiver_.poll();
  ASSERT_EQ(answers<wire::Welcome>(2).size(), 2u);
  EXPECT_TRUE(answers<wire::Welcome>(2)[1].conflicting_names.empty());
}

TEST_F(StreamReceiverTest, WhoeverKeepsANodeHearsThatAnotherStreamAsksForIt) {
  link_->deliver(1, LinkEvent::Kind::control, description(1));
  receiver_.poll();
  EXPECT_TRUE(answers<wire::Status>(1).empty()) << "nobody else is there";
  link_->deliver(2, LinkEvent::Kind::control, description(2));
  receiver_.poll();
  ASSERT_EQ(answers<wire::Status>(1).size(), 1u);
  EXPECT_EQ(answers<wire::Status>(1)[0].epoch, 1u);
  EXPECT_EQ(answers<wire::Status>(1)[0].contested_names, std::vector<std::string>{"arm"});
  link_->deliver(3, LinkEvent::Kind::control, description(3));
  receiver_.poll();
  EXPECT_EQ(answers<wire::Status>(1).size(), 1u) << "a third one changes nothing for the first";
  EXPECT_TRUE(answers<wire::Status>(2).empty()) << "it drives nothing that could be asked for";

  link_->deliver(1, LinkEvent::Kind::control, wire::encode(wire::Goodbye{1}));
  receiver_.poll();
  ASSERT_EQ(answers<wire::Status>(2).size(), 1u) << "the second has the node now, and the third asks for it";
  link_->deliver(3, LinkEvent::Kind::control, wire::encode(wire::Goodbye{3}));
  receiver_.poll();
  ASSERT_EQ(answers<wire::Status>(2).size(), 2u);
  EXPECT_TRUE(answers<wire::Status>(2)[1].contested_names.empty());
}

TEST_F(StreamReceiverTest, AFrameIsShownTogetherWithItsSceneEdits) {
  const wire::SceneEdit edit{7, 3, "arm", wire::Property::visible, wire::Visible{false}};
  link_->deliver(1, LinkEvent::Kind::control, wire::encode(edit));
  EXPECT_FALSE(receiver_.poll());
  EXPECT_EQ(receiver_.rejected_messages(), 1u) << "nobody knows yet whose edit it is";
  static const wire::Affine3x4 pose;
  wire::PoseFrameView view;
  view.header.epoch = 7;
  view.header.sequence = 1;
  view.header.scene_version = 3;
  view.node_count = 1;
  view.poses = {&pose, 1};
  link_->deliver(1, LinkEvent::Kind::control, description(7));
  link_->deliver(1, LinkEvent::Kind::pose, wire::encode(view));
  EXPECT_FALSE(receiver_.poll());
  EXPECT_TRUE(poses_.shown().empty());
  link_->deliver(1, LinkEvent::Kind::control, wire::encode(edit));
  EXPECT_TRUE(receiver_.poll());
  EXPECT_EQ(poses_.shown().size(), 1u);
  const auto changes = poses_.take_scene_changes();
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].edits, std::vector<wire::SceneEdit>{edit});
}

TEST_F(StreamReceiverTest, AFrameIsAcknowledgedOnceHoweverManyImagesShowIt) {
  link_->deliver(1, LinkEvent::Kind::control, description(7));
  link_->deliver(1, LinkEvent::Kind::pose, frame(7, 1));
  receiver_.poll();
  for (int image = 0; image < 100; ++image) receiver_.acknowledge(poses_.shown());
  link_->deliver(1, LinkEvent::Kind::pose, frame(7, 2));
  receiver_.poll();
  receiver_.acknowledge(poses_.shown());
  const std::vector<wire::Ack> acks = answers<wire::Ack>(1);
  ASSERT_EQ(acks.size(), 2u);
  EXPECT_EQ(acks[0].sequence, 1u);
  EXPECT_EQ(acks[1].sequence, 2u);
}

TEST_F(StreamReceiverTest, WhatCannotBeReadIsAnsweredAndCounted) {
  link_->deliver(1, LinkEvent::Kind::control, wire::Bytes(100, std::byte{0x5a}));
  receiver_.poll();
  EXPECT_EQ(receiver_.rejected_messages(), 1u);
  ASSERT_EQ(answers<wire::Welcome>(1).size(), 1u);
  EXPECT_EQ(answers<wire::Welcome>(1)[0].status, wire::WelcomeStatus::bad_description);
  const std::vector<std::string> log = receiver_.take_log_messages();
  ASSERT_EQ(log.size(), 1u);
  EXPECT_EQ(log[0], "warning: dropped a message from test://listener peer 1: " +
                        answers<wire::Welcome>(1)[0].message);
  EXPECT_NE(log[0].find("not FIRE-3DV traffic"), std::string::npos) << log[0];
  link_->deliver(1, LinkEvent::Kind::control, wire::Bytes(100, std::byte{0x5a}));
  receiver_.poll();
  EXPECT_TRUE(receiver_.take_log_messages().empty())
      << "a peer's first invalid message is logged, not the others";
}

TEST_F(StreamReceiverTest, UnreadableMessagesOfOnePollGetOneAnswer) {
  for (int i = 0; i < 1000; ++i) link_->deliver(1, LinkEvent::Kind::control, wire::Bytes(12));
  link_->deliver(2, LinkEvent::Kind::control, wire::Bytes(12));
  receiver_.poll();
  EXPECT_EQ(receiver_.rejected_messages(), 1001u);
  EXPECT_EQ(answers<wire::Welcome>(1).size(), 1u);
  EXPECT_EQ(answers<wire::Welcome>(2).size(), 1u);
  link_->deliver(1, LinkEvent::Kind::control, wire::Bytes(12));
  receiver_.poll();
  EXPECT_EQ(answers<wire::Welcome>(1).size(), 2u) << "the next mistake is answered again";
}

// On a multicast group every host sees the epoch of a stream.
TEST_F(StreamReceiverTest, AnEpochSeenElsewhereDoesNotTakeAStreamOver) {
  auto other = std::make_unique<ScriptedListener>();
  ScriptedListener* const open_link = other.get();
  receiver_.add(std::move(other));
  link_->deliver(1, LinkEvent::Kind::control, description(42));
  link_->deliver(1, LinkEvent::Kind::pose, frame(42, 1));
  receiver_.poll();
  const auto owner = poses_.node_drives()[0].stream;
  open_link->deliver(1, LinkEvent::Kind::control, description(42));
  open_link->deliver(1, LinkEvent::Kind::pose, frame(42, 7));
  receiver_.poll();
  EXPECT_EQ(receiver_.active_streams(), 2u);
  EXPECT_EQ(poses_.node_drives()[0].stream, owner);
  link_->deliver(1, LinkEvent::Kind::pose, frame(42, 2));
  EXPECT_TRUE(receiver_.poll()) << "the first stream still drives its node";
}

TEST_F(StreamReceiverTest, LogMessagesAreBounded) {
  for (uint64_t epoch = 1; epoch <= 1000; ++epoch)
    link_->deliver(1, LinkEvent::Kind::control, description(epoch));
  receiver_.poll();
  const std::vector<std::string> log = receiver_.take_log_messages();
  ASSERT_EQ(log.size(), 10u) << "per second; each description would add two";
  EXPECT_EQ(log[0], "stream \"adapter\" with 1 node accepted");
  EXPECT_EQ(log[1], "stream \"adapter\" ended: it began anew");
  EXPECT_EQ(log[2], "stream \"adapter\" with 1 node accepted");
  EXPECT_EQ(receiver_.active_streams(), 1u);
  now_ns_ += kSecondNs;
  link_->deliver(1, LinkEvent::Kind::control, description(1001));
  receiver_.poll();
  const std::vector<std::string> later = receiver_.take_log_messages();
  ASSERT_EQ(later.size(), 3u);
  EXPECT_EQ(later[0], "and 1989 more such events") << "1000 accepted and 999 ended, of which 10 were logged";
  EXPECT_EQ(later[2], "stream \"adapter\" with 1 node accepted");
}

// Another boot id means another machine: its frames are shown with a delay, and pings measure its clock.
TEST_F(StreamReceiverTest, WhatComesFromAnotherMachineIsInterpolatedOnItsClock) {
  wire::StreamDescription d;
  d.epoch = 3;
  d.adapter_name = "remote";
  d.node_names = {"arm"};
  d.clock.boot_id = "the boot of another machine";
  link_->deliver(1, LinkEvent::Kind::control, wire::encode(d));
  receiver_.poll();
  const std::vector<wire::Ping> pings = answers<wire::Ping>(1);
  ASSERT_EQ(pings.size(), 1u);
  link_->deliver(1, LinkEvent::Kind::control,
                 wire::encode(wire::Pong{pings[0].id, pings[0].sender_time_ns, 5'000'000'000}));
  link_->deliver(1, LinkEvent::Kind::control, wire::encode(wire::Pong{99, 1, 1}));  // no matching ping
  link_->deliver(1, LinkEvent::Kind::pose, frame(3, 1));
  receiver_.poll();
  ASSERT_EQ(poses_.shown().size(), 1u) << "the first frame is held until a second one comes";
  EXPECT_EQ(poses_.streams()[0].frames_received, 1u);
  EXPECT_EQ(receiver_.rejected_messages(), 0u);
}

TEST(StaleOverlay, TheWorstOfTheStreamsThatAreToBeMarked) {
  using state::Condition;
  std::vector<state::Stream> streams(4);
  for (state::Stream& stream : streams) {
    stream.active = true;
    stream.header.sequence = 1;
  }
  streams[0].condition = Condition::late;
  streams[1].condition = Condition::late;
  streams[1].interpolated = true;
  streams[2].condition = Condition::lost;  // on this machine, where a pause is detected as such
  streams[3].condition = Condition::lost;
  streams[3].interpolated = true;
  streams[3].header.sequence = 0;  // no frame that could be stale
  EXPECT_EQ(stale_condition(streams, StaleOverlay::interpolated), Condition::late);
  EXPECT_EQ(stale_condition(streams, StaleOverlay::on), Condition::lost);
  EXPECT_EQ(stale_condition(streams, StaleOverlay::off), Condition::live);
  streams[1].active = false;
  EXPECT_EQ(stale_condition(streams, StaleOverlay::interpolated), Condition::live);
}

}  // namespace
}  // namespace fire3dv::app
