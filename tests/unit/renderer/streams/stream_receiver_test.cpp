// Answers and reports of a stream receiver.
#include "renderer/streams/stream_receiver.h"

#include <cmath>
#include <utility>

#include "tests/unit/renderer/streams/receiver_fixture.h"

namespace fire3dv::app {
namespace {

TEST_F(StreamReceiverTest, ImagesReturnToRequester) {
  ImageRequestQueue requests(receiver_.images(), {});
  receiver_.images().set_handler(&requests);
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

TEST_F(StreamReceiverTest, ImpossibleImagesAreRefused) {
  const auto last_refusal = [&] {
    receiver_.poll();
    const auto refused = answers<wire::ImageRefused>(1);
    return refused.empty() ? wire::ImageRefused{} : refused.back();
  };
  link_->deliver(1, LinkEvent::Kind::control, description(42));
  link_->deliver(1, LinkEvent::Kind::control, wire::encode(image_request(42, 1)));
  EXPECT_EQ(last_refusal().reason, wire::ImageRefusal::no_way_back) << "there is no handler";
  ImageRequestQueue requests(receiver_.images(), {});
  receiver_.images().set_handler(&requests);
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
  bad = image_request(42, 3);
  bad.intrinsics.focus_distance_m = 2;
  link_->deliver(1, LinkEvent::Kind::control, wire::encode(bad));
  EXPECT_EQ(last_refusal().reason, wire::ImageRefusal::bad_request);
  EXPECT_NE(last_refusal().message.find("f_number is 0"), std::string::npos) << last_refusal().message;
  bad.intrinsics.f_number = 2;
  link_->deliver(1, LinkEvent::Kind::control, wire::encode(bad));
  EXPECT_EQ(last_refusal().reason, wire::ImageRefusal::not_supported);
  EXPECT_NE(last_refusal().message.find("no depth of field"), std::string::npos) << last_refusal().message;
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

TEST_F(StreamReceiverTest, LostScaleIsReportedOnce) {
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

TEST_F(StreamReceiverTest, StalledStreamsAreReported) {
  link_->deliver(1, LinkEvent::Kind::control, description(42));
  link_->deliver(1, LinkEvent::Kind::pose, frame(42, 1));
  EXPECT_EQ(count_stalls(), 0u);
  receiver_.expect_frames(false);
  now_ns_ += 60'000'000'000;
  EXPECT_EQ(count_stalls(), 0u) << "paused";
  receiver_.expect_frames(true);
  EXPECT_EQ(count_stalls(), 0u) << "the first frame needs a moment";
  now_ns_ += 900'000'000;
  EXPECT_EQ(count_stalls(), 0u);
  now_ns_ += 900'000'000;
  EXPECT_EQ(count_stalls(), 1u);
}

// Parts arrive and no frame is whole: the network is to blame, not the simulator.
TEST_F(StreamReceiverTest, IncompleteFramesAreReported) {
  link_->address = "udp://127.0.0.1:7";
  link_->deliver(1, LinkEvent::Kind::control, description(42, "adapter", {"arm", "hand"}));
  const wire::Affine3x4 pose;
  wire::PoseFrameView part;
  part.header.epoch = 42;
  part.node_count = 2;
  part.poses = {&pose, 1};
  std::vector<std::string> log;
  const auto run = [&](bool is_lossy, int seconds) {
    for (int i = 0; i < 60 * seconds; ++i) {
      ++part.header.sequence;
      for (part.first_node = 0; part.first_node < (is_lossy ? 1u : 2u); ++part.first_node)
        link_->deliver(1, LinkEvent::Kind::pose, wire::encode(part));
      now_ns_ += kSecondNs / 60;
      receiver_.poll();
      for (std::string& line : receiver_.take_log_messages()) log.push_back(std::move(line));
    }
  };
  run(false, 3);
  EXPECT_EQ(count_of(log, "incomplete"), 0u);
  run(true, 10);
  EXPECT_EQ(count_of(log, "warning: stream \"adapter\": frames come incomplete (60 of 60 a second): "), 1u);
  EXPECT_EQ(count_of(log, "udp://127.0.0.1:7; use tcp:// or tls://"), 1u);
  EXPECT_EQ(count_of(log, "stalled"), 0u);
  run(false, 5);
  EXPECT_EQ(count_of(log, "stream \"adapter\": its frames are whole again"), 1u);
}

// The renderer itself was busy, such as with shaders of its first image, while the simulator waited for it.
TEST_F(StreamReceiverTest, BusyRendererReportsNoStall) {
  link_->deliver(1, LinkEvent::Kind::control, description(42));
  link_->deliver(1, LinkEvent::Kind::pose, frame(42, 1));
  EXPECT_EQ(count_stalls(), 0u);
  now_ns_ += 12'000'000'000;
  EXPECT_EQ(count_stalls(), 0u);
  now_ns_ += 900'000'000;
  EXPECT_EQ(count_stalls(), 0u) << "the simulator got its image a moment ago";
  now_ns_ += 900'000'000;
  EXPECT_EQ(count_stalls(), 1u) << "it does stall";
}

// Images are slow: who waits for one does not stall.
TEST_F(StreamReceiverTest, StreamsThatWaitForImagesDoNotStall) {
  struct Handler final : ImageRequestHandler {
    void on_image_request(state::RequesterId, const wire::ImageRequest&,
                          const std::shared_ptr<PeerBudget>&) override {}
    void on_requester_ended(state::RequesterId) override {}
    bool owes_image(state::RequesterId, int64_t) const override { return is_owing; }
    bool is_owing = true;
  } handler;
  receiver_.images().set_handler(&handler);
  link_->deliver(1, LinkEvent::Kind::control, description(42));
  link_->deliver(1, LinkEvent::Kind::pose, frame(42, 1));
  std::vector<std::string> log;
  const auto wait = [&](int tenths) {
    for (int i = 0; i < tenths; ++i) {
      now_ns_ += 100'000'000;
      receiver_.poll();
      for (std::string& line : receiver_.take_log_messages()) log.push_back(std::move(line));
    }
  };
  wait(100);
  EXPECT_EQ(count_of(log, "stalled"), 0u);
  EXPECT_EQ(count_of(log, "warning: images for stream \"adapter\" take several seconds"), 1u);
  handler.is_owing = false;
  wait(10);
  EXPECT_EQ(count_of(log, "stream \"adapter\" stalled"), 1u) << "it got its image and sends nothing";
  receiver_.images().set_handler(nullptr);
}

TEST_F(StreamReceiverTest, ZeroPosesAreReported) {
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

TEST_F(StreamReceiverTest, SceneScaleIsNotReported) {
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

TEST_F(StreamReceiverTest, BadConnectionsHideNothing) {
  for (PeerId peer = 1; peer <= 80; ++peer)
    link_->deliver(peer, LinkEvent::Kind::control, wire::Bytes(100, std::byte{0x5a}));
  for (uint64_t epoch = 1; epoch <= 1000; ++epoch)
    link_->deliver(81, LinkEvent::Kind::control, description(epoch));
  link_->deliver(82, LinkEvent::Kind::control, description(2000, "honest"));
  receiver_.poll();
  const std::vector<std::string> log = receiver_.take_log_messages();
  // Each bad peer is logged once, the one that describes itself anew ten times a second.
  EXPECT_EQ(count_of(log, "warning: dropped a message from test://listener peer "), 80u);
  EXPECT_EQ(count_of(log, "stream \"adapter\""), 10u + 1u) << "and once as the driver of the arm";
  EXPECT_EQ(count_of(log,
                     "warning: stream \"honest\" with 1 node accepted; another stream drives \"arm\": "
                     "stream \"adapter\""),
            1u);
  EXPECT_EQ(log.size(), 91u);
}

// Whoever mistypes all names sees names that exist: with the first frame, since a stream may add nodes
// before.
TEST_F(StreamReceiverTest, MotionlessStreamIsWarned) {
  receiver_.set_scene(&scene_);
  link_->deliver(1, LinkEvent::Kind::control, description(1, "lost", {"base"}));
  link_->deliver(2, LinkEvent::Kind::control, description(2, "half", {"base", "arm"}));
  receiver_.poll();
  const std::vector<std::string> described = receiver_.take_log_messages();
  ASSERT_EQ(described.size(), 2u);
  EXPECT_EQ(described[0], "stream \"lost\" with 1 node accepted; no scene node is called \"base\"");
  EXPECT_EQ(described[1], "stream \"half\" with 2 nodes accepted; no scene node is called \"base\"");
  for (uint64_t sequence = 1; sequence <= 2; ++sequence) {
    link_->deliver(1, LinkEvent::Kind::pose, frame(1, sequence));
    receiver_.poll();
  }
  const std::vector<std::string> log = receiver_.take_log_messages();
  const std::string text =
      " moves nothing: the scene has no node of its 1 name, such as \"base\"; the scene has \"arm\"";
  EXPECT_EQ(count_of(log, "warning: stream \"lost\"" + text), 1u);
  EXPECT_EQ(count_of(log, "moves nothing"), 1u);
  const auto statuses = answers<wire::Status>(1);
  ASSERT_EQ(statuses.size(), 1u);
  EXPECT_EQ(statuses[0].message, "this stream" + text);
}

// A name that several nodes have, and one with a part of the path: the paths that it may mean.
TEST_F(StreamReceiverTest, AmbiguousNamesGetPaths) {
  scene::Scene scene;
  for (const char* path : {"env0/cart", "env0/cart/pole", "env1/cart/pole", "env2/cart/pole", "flagpole"}) {
    scene::Node& node = scene.nodes.emplace_back();
    node.path = path;
    node.name = node.path.substr(node.path.rfind('/') + 1);
  }
  state::PoseState poses(scene);
  StreamReceiver receiver(poses, false);
  auto listener = std::make_unique<ScriptedListener>();
  link_ = listener.get();
  receiver.add(std::move(listener));
  receiver.set_scene(&scene);
  link_->deliver(1, LinkEvent::Kind::control,
                 description(1, "cart", {"pole", "env1/pole", "cart/env1", "nope"}));
  const std::vector<wire::Affine3x4> rest(4);
  wire::PoseFrameView view;
  view.header.epoch = view.header.sequence = 1;
  view.node_count = 4;
  view.poses = rest;
  link_->deliver(1, LinkEvent::Kind::pose, wire::encode(view));
  receiver.poll();
  const auto statuses = answers<wire::Status>(1);
  ASSERT_EQ(statuses.size(), 1u);
  EXPECT_EQ(
      statuses[0].message,
      "this stream moves nothing: the scene has no node of its 4 names, such as \"pole\", \"env1/pole\", "
      "\"cart/env1\", \"nope\"; it has names that no node has alone; write paths: \"pole\" is "
      "\"env0/cart/pole\" or \"env1/cart/pole\" or 1 others, \"env1/pole\" is \"env1/cart/pole\"");
}

TEST_F(StreamReceiverTest, StreamHearsOfEditsWithoutEffect) {
  link_->deliver(1, LinkEvent::Kind::control, description(7, "painter"));
  receiver_.poll();
  const state::StreamId id = receiver_.report().front().id;
  receiver_.report_ineffective_edit(id, "no scene node is called \"nope\"");
  receiver_.report_ineffective_edit(id + 1, "of another stream");
  receiver_.report_ineffective_edit(id, "the node \"arm\" has no mesh to be coloured");
  const auto statuses = answers<wire::Status>(1);
  ASSERT_EQ(statuses.size(), 2u);
  EXPECT_EQ(statuses[0].message, "this stream has an edit without effect: no scene node is called \"nope\"");
  EXPECT_EQ(statuses[1].message,
            "this stream has an edit without effect: the node \"arm\" has no mesh to be coloured");
}

TEST_F(StreamReceiverTest, FrameShowsWithItsEdits) {
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

TEST_F(StreamReceiverTest, FrameIsAcknowledgedOnce) {
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

TEST_F(StreamReceiverTest, UnreadableMessageIsAnswered) {
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

TEST_F(StreamReceiverTest, HostileLensesAreRefused) {
  link_->deliver(1, LinkEvent::Kind::control, description(7, "hostile", {"leg"}));
  link_->deliver(2, LinkEvent::Kind::control, description(8));
  receiver_.poll();
  uint64_t version = 0;
  for (const auto& [f_number, focus_m] :
       {std::pair{NAN, 2.0f}, {2.0f, -INFINITY}, {1e-30f, 2.0f}, {0.0f, 1.0f}})
    link_->deliver(1, LinkEvent::Kind::control,
                   wire::encode(wire::SceneEdit{7, ++version, "arm", wire::Property::camera,
                                                wire::Camera{1, 0.1f, 0, 0, f_number, focus_m}}));
  link_->deliver(2, LinkEvent::Kind::control,
                 wire::encode(wire::SceneEdit{8, 1, "arm", wire::Property::camera,
                                              wire::Camera{1, 0.1f, 0, 0, 2.8f, 2}}));
  link_->deliver(2, LinkEvent::Kind::pose, frame(8, 1));
  EXPECT_TRUE(receiver_.poll());
  EXPECT_EQ(receiver_.rejected_messages(), 4u);
  EXPECT_EQ(driver(), 8u);
  const auto changes = poses_.take_scene_changes();
  ASSERT_EQ(changes.size(), 1u) << "of the other stream";
  ASSERT_EQ(changes[0].edits.size(), 1u);
  EXPECT_EQ(std::get<wire::Camera>(changes[0].edits[0].value).f_number, 2.8f);
}

TEST_F(StreamReceiverTest, UnreadableMessagesShareAnswer) {
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
TEST_F(StreamReceiverTest, RemoteStreamIsInterpolated) {
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

TEST(StaleOverlay, WorstStreamIsMarked) {
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
