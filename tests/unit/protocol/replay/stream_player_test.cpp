// Test of the stream player: recorded streams on links, verbatim or with current times, in the link's message
// form, paced.
#include <gtest/gtest.h>

#include "protocol/replay/replay_clock.h"
#include "protocol/replay/stream_player.h"
#include "tests/unit/protocol/record/record_files.h"

namespace fire3dv::record_test {
namespace {

class FakeLink final : public transport::PublisherLink {
 public:
  explicit FakeLink(size_t max_bytes, bool partial) : max_bytes_(max_bytes), partial_(partial) {}
  size_t max_pose_message_bytes() const override { return max_bytes_; }
  Result<void> set_description(std::span<const std::byte> message) override { return put(message); }
  Result<void> put_state(uint64_t key, transport::SharedBytes message) override {
    keys.push_back(key);
    return put(*message);
  }
  bool publish(const wire::MessagePieces& message, bool) noexcept override {
    Bytes whole(message.head.begin(), message.head.end());
    whole.insert(whole.end(), message.body.begin(), message.body.end());
    sent.push_back(std::move(whole));
    return true;
  }
  bool takes_partial_frames() const override { return partial_; }
  bool publish_partial(const wire::MessagePieces& partial,
                       std::span<const wire::MessagePieces>) noexcept override {
    return publish(partial, true);
  }
  void send_control(std::span<const std::byte> message) noexcept override { (void)put(message); }
  bool poll(std::vector<std::byte>&) override { return false; }
  transport::LinkStats stats() const override { return {}; }

  std::vector<Bytes> sent;
  std::vector<uint64_t> keys;

 private:
  Result<void> put(std::span<const std::byte> message) {
    sent.emplace_back(message.begin(), message.end());
    return {};
  }
  size_t max_bytes_;
  bool partial_;
};

struct OnLink {
  OnLink(size_t max_bytes, bool partial, bool verbatim) {
    auto made = std::make_unique<FakeLink>(max_bytes, partial);
    link = made.get();
    player = std::make_unique<replay::StreamPlayer>(std::move(made), verbatim);
  }
  void play(const Bytes& message, Played::Kind kind = Played::Kind::pose, uint64_t key = 0) {
    EXPECT_TRUE(player->play({kind, 0, 0, key, message}).ok());
  }
  wire::PoseFrameView frame_at(size_t i) {
    auto decoded = decoder.decode(link->sent.at(i));
    EXPECT_TRUE(decoded.ok());
    return std::get<wire::PoseFrameView>(*decoded);
  }
  FakeLink* link;
  std::unique_ptr<replay::StreamPlayer> player;
  wire::Decoder decoder;
};

TEST(StreamPlayer, VerbatimIsWhatWasRecorded) {
  OnLink on(1 << 20, true, true);
  const std::vector<Bytes> messages{description(7), edit(7, 1, "link_0", false), frame(7, 1), frame(7, 2)};
  on.play(messages[0], Played::Kind::description);
  on.play(messages[1], Played::Kind::edit, 5);
  on.play(messages[2]);
  on.play(messages[3]);
  EXPECT_EQ(on.link->sent, messages);
  EXPECT_EQ(on.link->keys, std::vector<uint64_t>{5});
  on.play(frame(7, 1));  // stale
  EXPECT_EQ(on.player->counts().skipped, 1u);
}

TEST(StreamPlayer, TimesAreRebasedAlone) {
  OnLink on(1 << 20, true, false);
  on.play(description(7), Played::Kind::description);
  on.play(frame(7, 3));
  const wire::PoseFrameView sent = on.frame_at(1);
  EXPECT_EQ(sent.header.epoch, 7u);
  EXPECT_EQ(sent.header.sequence, 3u);
  EXPECT_EQ(sent.header.sim_time_ns, static_cast<int64_t>(3 * kMs));
  EXPECT_EQ(sent.header.flags, 0u);
  EXPECT_EQ(sent.poses[1].m[3], 31.f);
  EXPECT_NE(sent.header.publish_time_ns, 1000 + 3 * kMs);
  wire::Decoder decoder;
  const auto told = decoder.decode(on.link->sent[0]);
  ASSERT_TRUE(told.ok());
  EXPECT_NE(std::get<wire::StreamDescription>(*told).clock.boot_id, "boot");
}

TEST(StreamPlayer, EditsPerLinkAreBounded) {
  OnLink on(1 << 20, true, true);
  on.play(description(7), Played::Kind::description);
  const Bytes one = edit(7, 1, "link_0", false);
  for (uint64_t key = 0; key < 65'546; ++key) on.play(one, Played::Kind::edit, key);
  EXPECT_EQ(on.link->keys.size(), 65'536u);
  EXPECT_EQ(on.player->counts().dropped_edits, 10u);
  on.play(one, Played::Kind::edit, 5);  // an existing edit is replaced
  EXPECT_EQ(on.link->keys.size(), 65'537u);
  on.play(description(8), Played::Kind::description);
  on.play(edit(8, 1, "link_0", false), Played::Kind::edit, 70'000);
  EXPECT_EQ(on.link->keys.size(), 65'538u);
}

TEST(StreamPlayer, LoopIsMarkedDiscontinuity) {
  OnLink on(1 << 20, true, true);
  for (int pass = 0; pass < 2; ++pass) {
    if (pass != 0) on.player->jump(true);
    on.play(description(7), Played::Kind::description);
    on.play(edit(7, 1, "link_0", false), Played::Kind::edit, 1);
    on.play(frame(7, 1));
    on.play(frame(7, 2));
  }
  ASSERT_EQ(on.link->sent.size(), 8u);
  const uint64_t epoch = on.frame_at(6).header.epoch;
  EXPECT_NE(epoch, 7u);
  EXPECT_EQ(on.frame_at(6).header.flags, wire::kFrameDiscontinuity);
  EXPECT_EQ(on.frame_at(7).header.epoch, epoch);
  EXPECT_EQ(on.frame_at(7).header.flags, 0u);
  wire::Decoder decoder;
  const auto edited = decoder.decode(on.link->sent[5]);
  ASSERT_TRUE(edited.ok());
  EXPECT_EQ(std::get<wire::SceneEdit>(*edited).epoch, epoch);
}

TEST(StreamPlayer, FramesFitTheLink) {
  constexpr uint32_t kNodes = 50;
  const Bytes whole = frame(7, 1, kNodes);
  OnLink datagrams(1148, true, true);
  datagrams.play(description(7, "arm", kNodes), Played::Kind::description);
  datagrams.play(whole);
  ASSERT_EQ(datagrams.link->sent.size(), 4u);  // the description, and three parts of at most 21
  // The recorded parts on a link that takes whole frames.
  OnLink memory(1 << 20, false, true);
  memory.play(description(7, "arm", kNodes), Played::Kind::description);
  for (size_t i = 1; i < datagrams.link->sent.size(); ++i) {
    EXPECT_LE(datagrams.link->sent[i].size(), 1148u);
    memory.play(datagrams.link->sent[i]);
  }
  ASSERT_EQ(memory.link->sent.size(), 2u);
  const wire::PoseFrameView together = memory.frame_at(1);
  ASSERT_EQ(together.poses.size(), kNodes);
  EXPECT_EQ(together.poses[49].m[3], 59.f);
  // A frame with a missing part is not played.
  const Bytes first_part = datagrams.link->sent[1];
  OnLink lost(1 << 20, false, true);
  lost.play(description(7, "arm", kNodes), Played::Kind::description);
  lost.play(first_part);
  lost.play(frame(7, 2, kNodes));
  EXPECT_EQ(lost.player->counts().incomplete, 1u);
  EXPECT_EQ(lost.player->counts().frames, 1u);
}

wire::PoseFrameView part_view(uint64_t sequence, uint32_t first, std::span<const wire::Affine3x4> poses) {
  wire::PoseFrameView view;
  view.header = {7, sequence, 0, 0, 0, 0};
  view.node_count = 6;
  view.first_node = first;
  view.poses = poses;
  return view;
}

TEST(StreamPlayer, ForeignPartsAreDropped) {
  const std::vector<wire::Affine3x4> poses(3);
  OnLink on(1 << 20, false, true);
  on.play(description(7, "arm", 6), Played::Kind::description);
  on.play(wire::encode(part_view(1, 0, poses)));
  wire::PoseFrameView other_time = part_view(1, 3, poses);
  other_time.header.sim_time_ns = 5;
  on.play(wire::encode(other_time));
  EXPECT_EQ(on.link->sent.size(), 1u) << "the description";
  EXPECT_EQ(on.player->counts().skipped, 1u);
  on.play(wire::encode(part_view(1, 3, poses)));
  EXPECT_EQ(on.player->counts().frames, 1u);
}

TEST(StreamPlayer, NewestWholeFrameIsGathered) {
  std::vector<wire::Affine3x4> poses(6);
  OnLink on(1 << 20, false, true);
  on.play(description(7, "arm", 6), Played::Kind::description);
  on.player->begin_assembly();
  EXPECT_FALSE(on.player->publish_assembled());
  on.player->begin_assembly();
  on.play(wire::encode(part_view(1, 0, poses)));
  poses[0].m[3] = 8;
  on.play(wire::encode(part_view(2, 0, std::span(poses).first(3))));
  EXPECT_TRUE(on.player->publish_assembled());
  const wire::PoseFrameView sent = on.frame_at(1);
  EXPECT_EQ(sent.header.sequence, 1u);
  EXPECT_EQ(sent.poses[0].m[3], wire::Affine3x4{}.m[3]) << "of the frame that is not whole";
}

TEST(StreamPlayer, PartialsExtendWholeFrames) {
  const std::vector<uint32_t> indices{1};
  std::vector<wire::Affine3x4> poses(1);
  poses[0].m[3] = 99;
  wire::PoseFrameView view;
  view.header = {7, 2, 0, 0, 0, 0};
  view.node_count = 3;
  view.poses = poses;
  view.node_indices = indices;
  const Bytes partial = wire::encode(view);
  for (const bool takes_partial : {true, false}) {
    OnLink on(1 << 20, takes_partial, true);
    on.play(description(7), Played::Kind::description);
    on.play(partial);  // no frame to build on
    EXPECT_EQ(on.player->counts().skipped, 1u);
    on.play(frame(7, 1));
    on.play(partial);
    ASSERT_EQ(on.link->sent.size(), 3u);
    if (takes_partial) {
      EXPECT_EQ(on.link->sent[2], partial);
    } else {
      const wire::PoseFrameView whole = on.frame_at(2);
      ASSERT_EQ(whole.poses.size(), 3u);
      EXPECT_EQ(whole.poses[0].m[3], 10.f);
      EXPECT_EQ(whole.poses[1].m[3], 99.f);
    }
  }
}

TEST(StreamPlayer, PartialNeedsCompleteFrame) {
  const std::vector<uint32_t> indices{1};
  const std::vector<wire::Affine3x4> poses(6);
  OnLink on(1 << 20, false, true);
  on.play(description(7, "arm", 6), Played::Kind::description);
  on.play(wire::encode(part_view(1, 0, poses)));
  on.play(wire::encode(part_view(2, 0, std::span(poses).first(3))));
  wire::PoseFrameView partial = part_view(3, 0, std::span(poses).first(1));
  partial.node_indices = indices;
  on.play(wire::encode(partial));
  EXPECT_EQ(on.player->counts().frames, 1u);
  EXPECT_EQ(on.player->counts().skipped, 1u);
  on.play(wire::encode(part_view(4, 0, poses)));
  EXPECT_EQ(on.player->counts().frames, 2u);
  EXPECT_EQ(on.player->counts().incomplete, 1u);
}

TEST(Pacer, LongWaitNamesItsEnd) {
  const std::string text = replay::long_wait_text(3'600'000'000'000, 3'603'000'000'000);
  EXPECT_NE(text.find("3600.0 s"), std::string::npos) << text;
  EXPECT_NE(text.find("--start 3603.0"), std::string::npos) << text;
}

TEST(Pacer, FollowsLogTimes) {
  replay::Pacer pacer(2);
  EXPECT_EQ(pacer.wait_ns(1000, 50), 0);
  EXPECT_EQ(pacer.wait_ns(3000, 50), 1000);
  EXPECT_EQ(pacer.wait_ns(3000, 1050), 0);
  EXPECT_EQ(pacer.wait_ns(3000, 9999), 0);  // no wait for late frames
  EXPECT_EQ(pacer.wait_ns(500, 50), 0);
  pacer.restart();
  EXPECT_EQ(pacer.wait_ns(9000, 100), 0);
  EXPECT_GT(pacer.wait_ns(UINT64_MAX, 100), int64_t{1} << 40);
  EXPECT_EQ(replay::Pacer(0).wait_ns(9000, 100), 0);
}

}  // namespace
}  // namespace fire3dv::record_test
