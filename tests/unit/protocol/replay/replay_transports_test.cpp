// Test of damaged recordings over every link: repeated, overlapping, crossing and missing parts. A renderer
// shows complete frames of one simulation step only.
#include <gtest/gtest.h>
#include <unistd.h>

#include <optional>
#include <set>

#include "protocol/replay/stream_player.h"
#include "renderer/state/frame_receiver.h"
#include "tests/unit/protocol/record/record_files.h"
#include "tests/unit/protocol/transport/network_namespace.h"
#include "tests/unit/protocol/transport/secure_fixture.h"

namespace fire3dv::record_test {
namespace {

constexpr uint32_t kNodes = 60;
constexpr uint64_t kEpoch = 7;
constexpr uint64_t kLastSequence = 9;

// Poses [first, first + count) of frame `sequence`: all hold the number of the frame.
Bytes part(uint64_t sequence, uint32_t first, uint32_t count) {
  std::vector<wire::Affine3x4> poses(count);
  for (wire::Affine3x4& pose : poses) pose.m[3] = static_cast<float>(sequence);
  wire::PoseFrameView view;
  view.header = {kEpoch, sequence, static_cast<int64_t>(sequence * kMs), 1000 + sequence * kMs, 0, 0};
  view.node_count = kNodes;
  view.first_node = first;
  view.poses = poses;
  return wire::encode(view);
}

// Each damaged frame follows a whole one, whose poses would fill the gaps.
std::vector<Bytes> damaged_frames() {
  return {
      part(1, 0, kNodes),  // whole
      part(2, 0, 30),
      part(2, 0, 30),  // repeated, the rest is missing
      part(3, 0, 40),
      part(3, 10, 20),  // overlapping, the rest is missing
      part(4, 0, 20),
      part(4, 40, 20),  // the middle is missing
      part(5, 0, 40),
      part(5, 20, 40),  // overlapping and whole
      part(6, 0, 30),
      part(7, 0, 30),
      part(6, 30, 30),
      part(7, 30, 30),  // crossing and whole
      part(8, 30, 30),
      part(8, 30, 30),                 // the start is missing
      part(kLastSequence, 0, kNodes),  // whole
  };
}

const std::set<uint64_t> kWhole{1, 5, 6, 7, 9};

class ReplayLinks : public testing::TestWithParam<const char*> {
 protected:
  struct Ends {
    std::string uri;
    transport::ListenerOptions listener;
    transport::PublisherOptions publisher;
  };
  Ends ends() {
    const std::string kind = GetParam();
    if (kind == "shm") return {transport::test::unique_shm_uri("parts"), {}, {}};
    if (kind == "tls") return {"tls://127.0.0.1:0", secured_.tls_listener(), secured_.tls_publisher()};
    if (kind == "sealed")
      return {"udp://127.0.0.1:0", secured_.keyed_listener('1'), secured_.keyed_publisher('1')};
    if (kind == "group") {
      transport::ListenerOptions insecure;
      insecure.insecure = true;
      return {"udp://239.255.77.4:" + std::to_string(20'000 + ::getpid() % 10'000) +
                  "?interface=" + transport::test::OwnNetwork::interface(),
              insecure,
              {}};
    }
    return {kind + "://127.0.0.1:0", {}, {}};
  }

 private:
  transport::test::Secured secured_;
};

TEST_P(ReplayLinks, IncompleteFrameIsNotShown) {
  const Ends ends = this->ends();
  transport::test::Listener listener(ends.uri, ends.listener);
  ASSERT_TRUE(listener.link);
  replay::StreamPlayer player(
      transport::test::open_publisher_or_fail(
          std::string(GetParam()) == "group" ? ends.uri : listener.link->uri(), ends.publisher),
      false);

  std::optional<state::FrameReceiver> receiver;
  wire::Decoder decoder;
  std::set<uint64_t> shown;
  size_t seen = 0;
  const auto show_events = [&] {
    for (; seen < listener.events.size(); ++seen) {
      const transport::test::Event& event = listener.events[seen];
      if (event.kind != transport::test::Kind::pose && event.kind != transport::test::Kind::control) continue;
      const auto decoded = decoder.decode(transport::test::bytes_of(event.text));
      if (!decoded) continue;
      if (const auto* description = std::get_if<wire::StreamDescription>(&*decoded)) {
        if (!receiver) receiver.emplace(description->epoch, description->node_names.size());
      }
      const auto* frame = std::get_if<wire::PoseFrameView>(&*decoded);
      if (frame == nullptr || !receiver || !receiver->push(*frame)) continue;
      shown.insert(receiver->header.sequence);
      for (uint32_t node = 0; node < kNodes; ++node)
        EXPECT_EQ(receiver->poses[node].m[3], static_cast<float>(receiver->header.sequence)) << node;
    }
  };

  EXPECT_TRUE(player.play({Played::Kind::description, 0, 0, 0, description(kEpoch, "arm", kNodes)}).ok());
  ASSERT_TRUE(listener.poll_until([&] {
    show_events();
    return receiver.has_value();
  }));
  for (const Bytes& message : damaged_frames()) {
    EXPECT_TRUE(player.play({Played::Kind::pose, 0, 0, 0, message}).ok());
    // Each frame is read before the next is published: links keep the newest frame only.
    const uint64_t published = player.counts().frames;
    ASSERT_TRUE(listener.poll_until([&] {
      show_events();
      return shown.size() >= published;
    }));
  }
  EXPECT_EQ(shown, kWhole);
  player.end();
  EXPECT_EQ(player.counts().frames, kWhole.size());
  EXPECT_EQ(player.counts().incomplete, 4u);
  EXPECT_EQ(player.counts().skipped, 3u) << "two repeated parts, one inside of another";
}

INSTANTIATE_TEST_SUITE_P(Links, ReplayLinks, testing::Values("shm", "tcp", "tls", "udp", "sealed", "group"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace fire3dv::record_test
