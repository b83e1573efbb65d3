// What the renderer makes of what its links deliver, without links and without a GPU: a scripted listener
// stands in.
#include "renderer/app/stream_intake.h"

#include <gtest/gtest.h>

#include <deque>

#include "protocol/wire/encode.h"
#include "renderer/app/mark_held.h"

namespace fire3dv::app {
namespace {

using transport::LinkEvent;
using transport::PeerId;

// Delivers what a test puts in; keeps what it is asked to send.
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
  void send(PeerId peer, std::span<const std::byte> message) override {
    sent.emplace_back(peer, wire::Bytes(message.begin(), message.end()));
  }
  transport::LinkStats stats() const override { return {}; }
  std::string uri() const override { return "test://listener"; }

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
  struct Image {
    PeerId peer;
    uint64_t request;
    std::vector<std::byte> pixels;
  };
  std::vector<Image> images;
  bool carries = true;

 private:
  struct Entry {
    LinkEvent::Kind kind;
    PeerId peer;
    wire::Bytes message;
    std::string text;
  };
  std::deque<Entry> script_;
};

class StreamIntakeTest : public ::testing::Test {
 protected:
  StreamIntakeTest() : scene_(make_scene()), poses_(scene_), intake_(poses_, false) {
    auto listener = std::make_unique<ScriptedListener>();
    link_ = listener.get();
    intake_.add(std::move(listener));
  }

  static scene::Scene make_scene() {
    scene::Scene scene;
    scene::Node node;
    node.name = node.path = "arm";
    scene.nodes.push_back(node);
    return scene;
  }

  static wire::Bytes description(uint64_t epoch) {
    wire::StreamDescription d;
    d.epoch = epoch;
    d.adapter_name = "adapter";
    d.node_names = {"arm"};
    return wire::encode(d);
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

  // The answers of one kind that a peer got.
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
  StreamIntake intake_;
  ScriptedListener* link_ = nullptr;
};

TEST_F(StreamIntakeTest, ImagesGoBackToWhoAskedForThem) {
  intake_.offer_images({});
  link_->deliver(1, LinkEvent::Kind::control, description(42));
  link_->deliver(2, LinkEvent::Kind::control, description(43));
  link_->deliver(1, LinkEvent::Kind::control, wire::encode(image_request(42, 5)));
  link_->deliver(2, LinkEvent::Kind::control, wire::encode(image_request(43, 5)));
  link_->deliver(2, LinkEvent::Kind::control,
                 wire::encode(image_request(42, 6)));  // of an epoch that is not its own
  link_->deliver(1, LinkEvent::Kind::pose, frame(42, 3));
  intake_.poll();
  EXPECT_EQ(intake_.open_image_requests(), 2u);
  std::vector<state::ImageBook::Due> due;
  for (const state::ImageDemand& demand : intake_.image_demands(0)) {
    const auto images = intake_.due_images(demand.asker, 0);
    due.insert(due.end(), images.begin(), images.end());
  }
  ASSERT_EQ(due.size(), 2u);
  for (const state::ImageBook::Due& one : due) intake_.image_made(one);
  EXPECT_EQ(intake_.image_demands(0).size(), 0u);
  EXPECT_EQ(due[0].sequence, 3u);
  EXPECT_EQ(due[1].sequence, 0u);
  wire::ImageFrame image;
  image.request = 5;
  image.pixel_bytes = 64;
  EXPECT_TRUE(
      intake_.send_image(due[1].asker, image, [](std::span<std::byte> pixels) { pixels[0] = std::byte{9}; }));
  ASSERT_EQ(link_->images.size(), 1u);
  EXPECT_EQ(link_->images[0].peer, 2u);
  EXPECT_EQ(link_->images[0].request, 5u);
  EXPECT_EQ(link_->images[0].pixels[0], std::byte{9});

  link_->deliver(2, LinkEvent::Kind::disconnected, {}, "it left");
  intake_.poll();
  EXPECT_EQ(intake_.open_image_requests(), 1u);
  EXPECT_FALSE(intake_.send_image(due[1].asker, image, [](std::span<std::byte>) {}));
  // What cannot be drawn is over, and its asker knows why.
  intake_.refuse_image(due[0], wire::ImageRefusal::unknown_camera, "no such node");
  EXPECT_EQ(intake_.open_image_requests(), 0u);
  const auto refused = answers<wire::ImageRefused>(1);
  ASSERT_EQ(refused.size(), 1u);
  EXPECT_EQ(refused[0].request, 5u);
  EXPECT_EQ(refused[0].message, "no such node");
}

TEST_F(StreamIntakeTest, ImagesThatCannotBeHadAreRefusedWithAReason) {
  const auto last_refusal = [&] {
    intake_.poll();
    const auto refused = answers<wire::ImageRefused>(1);
    return refused.empty() ? wire::ImageRefused{} : refused.back();
  };
  link_->deliver(1, LinkEvent::Kind::control, description(42));
  link_->deliver(1, LinkEvent::Kind::control, wire::encode(image_request(42, 1)));
  EXPECT_EQ(last_refusal().reason, wire::ImageRefusal::no_way_back) << "nothing is offered";
  intake_.offer_images({});
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
  EXPECT_EQ(intake_.open_image_requests(), 0u);
  EXPECT_EQ(answers<wire::Welcome>(1).size(), 1u) << "a bad request says nothing of the description";
  link_->deliver(7, LinkEvent::Kind::control, wire::encode(image_request(42, 1)));
  intake_.poll();
  EXPECT_EQ(intake_.refusals()[static_cast<size_t>(Refusal::before_description)], 1u);
}

TEST_F(StreamIntakeTest, AStreamThatComesBackOverAnotherConnectionKeepsItsNodes) {
  link_->deliver(1, LinkEvent::Kind::control, description(42));
  link_->deliver(1, LinkEvent::Kind::pose, frame(42, 1));
  EXPECT_TRUE(intake_.poll());
  link_->deliver(2, LinkEvent::Kind::control,
                 description(42));  // the first connection has not been missed yet
  link_->deliver(2, LinkEvent::Kind::pose, frame(42, 2));
  EXPECT_TRUE(intake_.poll());
  EXPECT_EQ(intake_.active_streams(), 1u);
  ASSERT_EQ(answers<wire::Welcome>(2).size(), 1u);
  EXPECT_TRUE(answers<wire::Welcome>(2)[0].conflicting_names.empty());
  ASSERT_EQ(poses_.shown().size(), 1u);
  EXPECT_EQ(poses_.shown()[0].sequence, 2u);
  EXPECT_NE(poses_.node_drives()[0].stream, state::kNone);

  link_->deliver(1, LinkEvent::Kind::disconnected, {},
                 "timed out");  // the old one is missed at last: nothing changes
  intake_.poll();
  EXPECT_EQ(intake_.active_streams(), 1u);
}

TEST_F(StreamIntakeTest, AnotherStreamOnTheSameNodeIsToldAndGetsItWhenItIsFree) {
  link_->deliver(1, LinkEvent::Kind::control, description(1));
  link_->deliver(2, LinkEvent::Kind::control, description(2));
  intake_.poll();
  ASSERT_EQ(answers<wire::Welcome>(2).size(), 1u);
  EXPECT_EQ(answers<wire::Welcome>(2)[0].conflicting_names, std::vector<std::string>{"arm"});
  link_->deliver(1, LinkEvent::Kind::disconnected, {}, "it left");
  intake_.poll();
  ASSERT_EQ(answers<wire::Welcome>(2).size(), 2u);
  EXPECT_TRUE(answers<wire::Welcome>(2)[1].conflicting_names.empty());
}

TEST_F(StreamIntakeTest, WhoeverKeepsANodeHearsThatAnotherStreamAsksForIt) {
  link_->deliver(1, LinkEvent::Kind::control, description(1));
  intake_.poll();
  EXPECT_TRUE(answers<wire::Status>(1).empty()) << "nobody else is there";
  link_->deliver(2, LinkEvent::Kind::control, description(2));
  intake_.poll();
  ASSERT_EQ(answers<wire::Status>(1).size(), 1u);
  EXPECT_EQ(answers<wire::Status>(1)[0].epoch, 1u);
  EXPECT_EQ(answers<wire::Status>(1)[0].contested_names, std::vector<std::string>{"arm"});
  link_->deliver(3, LinkEvent::Kind::control, description(3));
  intake_.poll();
  EXPECT_EQ(answers<wire::Status>(1).size(), 1u) << "a third one changes nothing for the first";
  EXPECT_TRUE(answers<wire::Status>(2).empty()) << "it drives nothing that could be asked for";

  link_->deliver(1, LinkEvent::Kind::disconnected, {}, "it left");
  intake_.poll();
  ASSERT_EQ(answers<wire::Status>(2).size(), 1u) << "the second has the node now, and the third asks for it";
  link_->deliver(3, LinkEvent::Kind::control, wire::encode(wire::Goodbye{3}));
  intake_.poll();
  ASSERT_EQ(answers<wire::Status>(2).size(), 2u);
  EXPECT_TRUE(answers<wire::Status>(2)[1].contested_names.empty());
}

TEST_F(StreamIntakeTest, AFrameIsShownTogetherWithItsSceneEdits) {
  const wire::SceneEdit edit{7, 3, "arm", wire::Property::visible, wire::Visible{false}};
  link_->deliver(1, LinkEvent::Kind::control, wire::encode(edit));
  EXPECT_FALSE(intake_.poll());
  EXPECT_EQ(intake_.rejected_messages(), 1u) << "nobody knows yet whose edit it is";
  static const wire::Affine3x4 pose;
  wire::PoseFrameView view;
  view.header.epoch = 7;
  view.header.sequence = 1;
  view.header.scene_version = 3;
  view.node_count = 1;
  view.poses = {&pose, 1};
  link_->deliver(1, LinkEvent::Kind::control, description(7));
  link_->deliver(1, LinkEvent::Kind::pose, wire::encode(view));
  EXPECT_FALSE(intake_.poll());
  EXPECT_TRUE(poses_.shown().empty());
  link_->deliver(1, LinkEvent::Kind::control, wire::encode(edit));
  EXPECT_TRUE(intake_.poll());
  EXPECT_EQ(poses_.shown().size(), 1u);
  const auto changes = poses_.take_scene_changes();
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].edits, std::vector<wire::SceneEdit>{edit});
}

TEST_F(StreamIntakeTest, AFrameIsAcknowledgedOnceHoweverManyImagesShowIt) {
  link_->deliver(1, LinkEvent::Kind::control, description(7));
  link_->deliver(1, LinkEvent::Kind::pose, frame(7, 1));
  intake_.poll();
  for (int image = 0; image < 100; ++image) intake_.acknowledge(poses_.shown());
  link_->deliver(1, LinkEvent::Kind::pose, frame(7, 2));
  intake_.poll();
  intake_.acknowledge(poses_.shown());
  const std::vector<wire::Ack> acks = answers<wire::Ack>(1);
  ASSERT_EQ(acks.size(), 2u);
  EXPECT_EQ(acks[0].sequence, 1u);
  EXPECT_EQ(acks[1].sequence, 2u);
}

TEST_F(StreamIntakeTest, WhatCannotBeReadIsAnsweredAndCounted) {
  link_->deliver(1, LinkEvent::Kind::control, wire::Bytes(100, std::byte{0x5a}));
  intake_.poll();
  EXPECT_EQ(intake_.rejected_messages(), 1u);
  ASSERT_EQ(answers<wire::Welcome>(1).size(), 1u);
  EXPECT_EQ(answers<wire::Welcome>(1)[0].status, wire::WelcomeStatus::bad_description);
  EXPECT_EQ(intake_.take_notes().size(), 1u);
}

TEST_F(StreamIntakeTest, NotesAreBounded) {
  for (uint64_t epoch = 1; epoch <= 1000; ++epoch)
    link_->deliver(1, LinkEvent::Kind::control, description(epoch));
  intake_.poll();
  EXPECT_LT(intake_.take_notes().size(), 100u);  // 20 a second; each description would give two
  EXPECT_EQ(intake_.active_streams(), 1u);
}

// Another boot id is another machine: its frames are shown with a delay, and its clock is asked for.
TEST_F(StreamIntakeTest, WhatComesFromAnotherMachineIsInterpolatedOnItsClock) {
  wire::StreamDescription d;
  d.epoch = 3;
  d.adapter_name = "remote";
  d.node_names = {"arm"};
  d.clock.boot_id = "the boot of another machine";
  link_->deliver(1, LinkEvent::Kind::control, wire::encode(d));
  intake_.poll();
  const std::vector<wire::Ping> pings = answers<wire::Ping>(1);
  ASSERT_EQ(pings.size(), 1u);
  link_->deliver(1, LinkEvent::Kind::control,
                 wire::encode(wire::Pong{pings[0].id, pings[0].sender_time_ns, 5'000'000'000}));
  link_->deliver(1, LinkEvent::Kind::control, wire::encode(wire::Pong{99, 1, 1}));  // nobody asked
  link_->deliver(1, LinkEvent::Kind::pose, frame(3, 1));
  intake_.poll();
  ASSERT_EQ(poses_.shown().size(), 1u) << "the first frame is held until a second one comes";
  EXPECT_EQ(poses_.streams()[0].frames_received, 1u);
  EXPECT_EQ(intake_.rejected_messages(), 0u);
}

TEST(MarkHeld, TheWorstOfTheStreamsThatAreToBeMarked) {
  using state::Condition;
  std::vector<state::Stream> streams(4);
  for (state::Stream& stream : streams) {
    stream.active = true;
    stream.header.sequence = 1;
  }
  streams[0].condition = Condition::late;
  streams[1].condition = Condition::late;
  streams[1].interpolated = true;
  streams[2].condition = Condition::lost;  // on this machine, where a pause is seen to be one
  streams[3].condition = Condition::lost;
  streams[3].interpolated = true;
  streams[3].header.sequence = 0;  // it has shown nothing that could be held
  EXPECT_EQ(condition_to_mark(streams, MarkHeld::interpolated), Condition::late);
  EXPECT_EQ(condition_to_mark(streams, MarkHeld::on), Condition::lost);
  EXPECT_EQ(condition_to_mark(streams, MarkHeld::off), Condition::live);
  streams[1].active = false;
  EXPECT_EQ(condition_to_mark(streams, MarkHeld::interpolated), Condition::live);
}

}  // namespace
}  // namespace fire3dv::app
