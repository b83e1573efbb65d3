// Test of offline frame composition: the state at a time follows the timeline rules and is independent of
// earlier requests.
#include <gtest/gtest.h>

#include <cmath>

#include "renderer/offline/recorded_streams.h"
#include "renderer/offline/timeline.h"
#include "renderer/state/playout.h"
#include "tests/unit/protocol/record/record_files.h"

namespace fire3dv::offline {
namespace {

using record_test::Bytes;
using record_test::kMs;

constexpr int64_t kMsNs = 1'000'000;

wire::Affine3x4 pose_of(uint64_t epoch, uint64_t sequence) {
  const float angle = 0.3f * static_cast<float>(sequence), c = std::cos(angle), s = std::sin(angle);
  wire::Affine3x4 pose;
  pose.m = {c, -s, 0, static_cast<float>(sequence), s, c, 0, static_cast<float>(epoch), 0, 0, 1, 0};
  return pose;
}

struct FrameWords {
  uint64_t epoch, sequence;
  int64_t sim_ms;
  uint64_t scene_version = 0;
  uint32_t flags = 0;
};
Bytes frame_of(const FrameWords& words) {
  const wire::Affine3x4 pose = pose_of(words.epoch, words.sequence);
  wire::PoseFrameView view;
  view.header = {words.epoch,    words.sequence,      words.sim_ms * kMsNs,
                 words.sequence, words.scene_version, words.flags};
  view.node_count = 1;
  view.poses = {&pose, 1};
  return wire::encode(view);
}

Bytes described(uint64_t epoch, const std::string& name = "arm", const std::string& node = "box") {
  wire::StreamDescription description;
  description.epoch = epoch;
  description.adapter_name = name;
  description.node_names = {node};
  return wire::encode(description);
}

Bytes hidden(uint64_t epoch, uint64_t version, bool visible) {
  return wire::encode(
      wire::SceneEdit{epoch, version, "box", wire::Property::visible, wire::Visible{visible}});
}

scene::Scene two_nodes() {
  scene::Scene scene;
  for (const char* name : {"box", "other"}) {
    scene::Node node;
    node.name = node.path = name;
    scene.nodes.push_back(node);
  }
  return scene;
}

// A recording in memory, and the state composed from it.
class ViewerDocument {
 public:
  ViewerDocument()
      : log_([] {
          record::LogOptions options;
          options.writer.chunk_bytes = 400;  // many chunks, and therefore snapshots
          return options;
        }()) {}
  void take(const Bytes& message, uint64_t at_ms, uint64_t peer = 1) {
    ASSERT_TRUE(log_.take(message, at_ms, peer));
  }

  const Timeline& read(const std::string& clock = "") {
    if (!timeline_) {
      EXPECT_TRUE(log_.log.finish().ok());
    }
    auto playback = opened();
    EXPECT_TRUE(playback.ok());
    auto timeline = Timeline::read(*playback, clock, {});
    EXPECT_TRUE(timeline.ok()) << (timeline.ok() ? "" : timeline.error().message);
    timeline_ = std::move(*timeline);
    return *timeline_;
  }
  Result<record::Playback> opened() { return record::Playback::open(record_test::source_of(*log_.files[0])); }

  // State after these times in order, in a form that reveals any difference.
  struct Seen {
    std::vector<wire::Affine3x4> poses;  // of each stream with a frame
    std::vector<state::FrameTag> tags;
    std::vector<std::string> edits;
  };
  Seen at(const std::vector<int64_t>& line_ms) {
    const scene::Scene scene = two_nodes();
    state::PoseState poses(scene);
    auto show = RecordedStreams::open([this] { return opened(); }, *timeline_, poses);
    EXPECT_TRUE(show.ok());
    for (const int64_t ms : line_ms) show->advance(ms * kMsNs);
    Seen seen;
    for (const state::Stream& stream : poses.streams()) {
      if (stream.active && stream.header.sequence != 0) seen.poses.push_back(stream.poses[0]);
    }
    seen.tags = poses.shown();
    for (const state::SceneChanges& changes : poses.take_scene_changes()) {
      for (const wire::SceneEdit& edit : changes.edits)
        seen.edits.push_back(edit.node +
                             (std::get<wire::Visible>(edit.value).visible ? " shown" : " hidden"));
    }
    return seen;
  }

 private:
  record_test::MemoryLog log_;
  std::optional<Timeline> timeline_;
};

TEST(FrameTimes, RatesAreExact) {
  EXPECT_EQ(*parse_frame_rate("29.97"), (FrameRate{2997, 100}));
  EXPECT_EQ(*parse_frame_rate("30000/1001"), (FrameRate{30000, 1001}));
  EXPECT_EQ(*parse_frame_rate("60/2"), (FrameRate{30, 1}));
  for (const char* wrong : {"", "0", "-30", "nan", "30/0", "1/0.5", "30fps", "1e3", "29.9700", "200000",
                            "1/2000", "99999999999999999999"})
    EXPECT_FALSE(parse_frame_rate(wrong).ok()) << wrong;
  const FrameTimes times{5, {30000, 1001}, 0};
  EXPECT_EQ(times.at_ns(0), 5);
  EXPECT_EQ(times.at_ns(1), 5 + 33366666);
  EXPECT_EQ(times.at_ns(30000), 5 + 1001 * kSecondNs);
  EXPECT_EQ(times.at_ns(99'999'999), 5 + 3336666633300000);
}

TEST(FrameTimes, LastFrameIsAtEnd) {
  EXPECT_EQ(frame_times(0, kSecondNs, {30, 1})->frames, 31u);
  EXPECT_EQ(frame_times(0, kSecondNs - 1, {30, 1})->frames, 30u);
  EXPECT_EQ(frame_times(7, 7, {30, 1})->frames, 1u);
  EXPECT_FALSE(frame_times(0, int64_t{1} << 61, {30, 1}).ok());
  for (const uint64_t frames : {1u, 2u, 7u, 100u, 101u}) {
    for (const uint32_t shards : {1u, 2u, 3u, 8u}) {
      uint64_t next = 0;
      for (uint32_t shard = 1; shard <= shards; ++shard) {
        const Part part = part_of(frames, shard, shards);
        EXPECT_EQ(part.first, next);
        EXPECT_LE(part.frames, frames / shards + 1);
        next += part.frames;
      }
      EXPECT_EQ(next, frames);
    }
  }
}

TEST(FrameTimes, RecordedFramesAreThoseOfThePart) {
  const std::vector<int64_t> recorded_ns{10, 20, 35, 40};
  const FrameTimes times = *recorded_frame_times(20, 39, recorded_ns);
  ASSERT_EQ(times.frames, 2u);
  EXPECT_EQ(times.at_ns(0), 20);
  EXPECT_EQ(times.at_ns(1), 35);
  EXPECT_EQ(recorded_frame_times(21, 34, recorded_ns)->frames, 0u);
}

TEST(RecordedStreams, BetweenFramesIsInterpolated) {
  ViewerDocument show;
  show.take(described(7), 0);
  for (uint64_t i = 1; i <= 30; ++i) show.take(frame_of({7, i, static_cast<int64_t>(10 * i)}), 10 * i);
  const Timeline& line = show.read();
  EXPECT_EQ(line.first_ns(), 10 * kMsNs);
  EXPECT_EQ(line.last_ns(), 300 * kMsNs);
  EXPECT_EQ(line.frames(), 30u);
  EXPECT_TRUE(show.at({9}).tags.empty());  // has not begun
  const auto exact = show.at({120});
  ASSERT_EQ(exact.poses.size(), 1u);
  EXPECT_EQ(exact.poses[0], pose_of(7, 12));
  EXPECT_EQ(exact.tags[0].sequence, 12u);
  EXPECT_EQ(exact.tags[0].sim_time_ns, 120 * kMsNs);
  const auto between = show.at({123});
  EXPECT_EQ(between.poses[0], state::interpolate(pose_of(7, 12), pose_of(7, 13), 3e6 / 10e6));
  EXPECT_EQ(between.tags[0].sequence, 12u);
  EXPECT_EQ(between.tags[0].sim_time_ns, 123 * kMsNs);
  EXPECT_EQ(show.at({4000}).poses[0], pose_of(7, 30));  // the last frame
}

TEST(RecordedStreams, JumpsAndPausesAreHeld) {
  ViewerDocument show;
  show.take(described(7), 0);
  show.take(frame_of({7, 1, 0}), 1);
  show.take(frame_of({7, 2, 100, 0, wire::kFrameDiscontinuity}), 2);
  show.take(frame_of({7, 3, 200}), 3);
  show.take(frame_of({7, 4, 300}), 4);
  for (uint64_t i = 5; i < 60; ++i) show.take(frame_of({7, i, static_cast<int64_t>(5000 + i)}), i);
  show.read();
  EXPECT_EQ(show.at({50}).poses[0], pose_of(7, 1));
  EXPECT_EQ(show.at({50}).tags[0].sim_time_ns, 0);
  EXPECT_EQ(show.at({100}).poses[0], pose_of(7, 2));
  EXPECT_EQ(show.at({150}).poses[0], state::interpolate(pose_of(7, 2), pose_of(7, 3), 0.5));
  EXPECT_EQ(show.at({2000}).poses[0], pose_of(7, 4));  // after a gap of almost five seconds
  EXPECT_EQ(show.at({5005}).poses[0], pose_of(7, 5));
}

// Frames at a regular interval of two seconds are no pause.
TEST(RecordedStreams, ASlowStreamIsJoined) {
  ViewerDocument show;
  show.take(described(7), 0);
  for (uint64_t i = 0; i < 5; ++i) show.take(frame_of({7, i + 1, static_cast<int64_t>(2000 * i)}), i);
  show.read();
  EXPECT_EQ(show.at({3000}).poses[0], state::interpolate(pose_of(7, 2), pose_of(7, 3), 0.5));
}

TEST(RecordedStreams, RunsFollowOneAnother) {
  ViewerDocument show;
  show.take(described(7), 0);
  for (uint64_t i = 0; i <= 10; ++i) show.take(frame_of({7, i + 1, static_cast<int64_t>(10 * i)}), 10 * i);
  show.take(wire::encode(wire::Goodbye{7}), 110);
  show.take(described(8), 9000);
  for (uint64_t i = 0; i <= 10; ++i)
    show.take(frame_of({8, i + 1, static_cast<int64_t>(10 * i)}), 9000 + 10 * i);
  // Time may also go back within a run.
  for (uint64_t i = 0; i <= 3; ++i)
    show.take(frame_of({8, i + 12, static_cast<int64_t>(10 * i), 0, wire::kFrameDiscontinuity}), 9200 + i);
  const Timeline& line = show.read();
  EXPECT_EQ(line.last_ns(), (100 + 10 + 100 + 10 + 30) * kMsNs);
  EXPECT_EQ(show.at({100}).tags[0].epoch, 7u);
  EXPECT_TRUE(show.at({105}).tags.empty());  // after its goodbye: rest pose
  const auto second = show.at({125});
  EXPECT_EQ(second.tags[0].epoch, 8u);
  EXPECT_EQ(second.tags[0].sim_time_ns, 15 * kMsNs);
  EXPECT_EQ(second.poses[0], state::interpolate(pose_of(8, 2), pose_of(8, 3), 0.5));
  EXPECT_EQ(show.at({215}).poses[0], pose_of(8, 11));  // the last frame until the new segment
  EXPECT_EQ(show.at({220}).tags[0].sim_time_ns, 0);
}

TEST(RecordedStreams, SharedClockIsUsed) {
  ViewerDocument show;
  show.take(described(7), 0, 1);
  show.take(described(9, "crane", "other"), 0, 2);
  for (uint64_t i = 1; i <= 20; ++i) {
    show.take(frame_of({7, i, static_cast<int64_t>(10 * i)}), 10 * i + 3, 1);
    if (i % 4 == 0) show.take(frame_of({9, i / 4, static_cast<int64_t>(10 * i)}), 10 * i + 9, 2);
  }
  show.read();
  const auto seen = show.at({100});
  ASSERT_EQ(seen.poses.size(), 2u);
  EXPECT_EQ(seen.poses[1], state::interpolate(pose_of(9, 2), pose_of(9, 3), 0.5));
}

TEST(RecordedStreams, ForeignClockIsAligned) {
  ViewerDocument show;
  show.take(described(9, "crane", "other"), 0, 2);
  show.take(described(7), 0, 1);
  // The crane runs before the arm starts, and its clock is two hours ahead.
  const auto crane = [&](uint64_t i, uint64_t at_ms) {
    show.take(frame_of({9, i, static_cast<int64_t>(7'200'000 + 10 * i)}), at_ms, 2);
  };
  for (uint64_t i = 1; i <= 5; ++i) crane(i, i);
  for (uint64_t i = 1; i <= 20; ++i) {
    show.take(frame_of({7, i, static_cast<int64_t>(10 * i)}), 100 + i, 1);
    crane(5 + i, 100 + i);
  }
  const Timeline& line = show.read("arm");
  EXPECT_EQ(line.guide(), "arm");
  // The crane's fifth frame was current when the arm's first frame came, at 10 ms.
  const auto seen = show.at({60});
  ASSERT_EQ(seen.tags.size(), 2u);
  EXPECT_EQ(seen.tags[0].sim_time_ns, int64_t{7'200'000 + 100} * kMsNs);
  EXPECT_EQ(line.first_ns(), (10 - 40) * kMsNs);
  // The crane is the default guide.
  EXPECT_EQ(show.read().guide(), "crane");
}

TEST(RecordedStreams, EditsPrecedeTheirFrame) {
  ViewerDocument show;
  show.take(described(7), 0);
  show.take(frame_of({7, 1, 10}), 10);
  show.take(hidden(7, 1, false), 11);
  show.take(frame_of({7, 2, 20, 1}), 20);
  show.take(hidden(7, 2, true), 21);
  show.take(wire::encode(wire::Goodbye{7}), 500);
  show.read();
  EXPECT_TRUE(show.at({19}).edits.empty());
  EXPECT_EQ(show.at({20}).edits, std::vector<std::string>{"box hidden"});
  EXPECT_EQ(show.at({20, 21}).edits,
            std::vector<std::string>{});  // the end of the stream withdraws its edits
}

TEST(RecordedStreams, FrameWaitsForItsEdits) {
  ViewerDocument show;
  show.take(described(7), 0);
  show.take(frame_of({7, 1, 10}), 10);
  show.take(frame_of({7, 2, 20, 1}), 20);
  show.take(frame_of({7, 3, 30, 1}), 30);
  show.take(hidden(7, 1, false), 35);
  show.take(frame_of({7, 4, 40, 1}), 40);
  const Timeline& line = show.read();
  EXPECT_LE(line.frames(), 4u);
  EXPECT_EQ(show.at({30}).edits, std::vector<std::string>{"box hidden"});
  EXPECT_EQ(show.at({30}).tags[0].sequence, 3u);
}

// The state at a time is equal from a cold start and after all earlier times.
TEST(RecordedStreams, DependsOnTheMomentAlone) {
  ViewerDocument show;
  show.take(described(9, "crane", "other"), 0, 2);
  show.take(described(7), 5, 1);
  for (uint64_t i = 1; i <= 40; ++i) {
    if (i % 7 == 0) show.take(hidden(7, i, i % 2 == 0), 10 * i, 1);
    show.take(
        frame_of({7, i, static_cast<int64_t>(10 * i), i / 7 * 7, i == 20 ? wire::kFrameDiscontinuity : 0u}),
        10 * i, 1);
    if (i < 30 && i % 3 == 0) show.take(frame_of({9, i, static_cast<int64_t>(10 * i)}), 10 * i, 2);
    if (i == 30) show.take(wire::encode(wire::Goodbye{9}), 300, 2);
  }
  show.take(described(8), 5000, 1);
  for (uint64_t i = 1; i <= 10; ++i)
    show.take(frame_of({8, i, static_cast<int64_t>(10 * i)}), 5000 + 10 * i, 1);
  show.read();
  std::vector<int64_t> before;
  for (int64_t ms = 0; ms <= 540; ms += 9) {
    before.push_back(ms);
    const auto warm = show.at(before), cold = show.at({ms});
    EXPECT_EQ(warm.poses, cold.poses) << ms;
    ASSERT_EQ(warm.tags.size(), cold.tags.size()) << ms;
    for (size_t i = 0; i < warm.tags.size(); ++i) {
      EXPECT_EQ(warm.tags[i].epoch, cold.tags[i].epoch) << ms;
      EXPECT_EQ(warm.tags[i].sequence, cold.tags[i].sequence) << ms;
      EXPECT_EQ(warm.tags[i].sim_time_ns, cold.tags[i].sim_time_ns) << ms;
    }
    EXPECT_EQ(warm.edits, cold.edits) << ms;
  }
}

TEST(RecordedStreams, UncoveredTimesAreSkipped) {
  ViewerDocument show;
  show.take(described(7), 0);
  show.take(frame_of({7, 1, 10}), 10);
  wire::PoseFrameView view;
  const wire::Affine3x4 pose;
  view.header = {7, 2, INT64_MIN, 0, 0, 0};
  view.node_count = 1;
  view.poses = {&pose, 1};
  show.take(wire::encode(view), 20);
  view.header = {7, 3, INT64_MAX, 0, 0, 0};
  show.take(wire::encode(view), 30);
  show.take(frame_of({7, 4, 40}), 40);
  const Timeline& line = show.read();
  EXPECT_EQ(line.unusable(), 2u);
  EXPECT_EQ(line.last_ns(), 40 * kMsNs);
}

// Simulators that run in real time often publish Unix time.
TEST(Timeline, UnixTimesAreLaidOut) {
  constexpr int64_t kNowMs = 1'764'374'400'000;
  ViewerDocument show;
  show.take(described(7), 0);
  for (uint64_t i = 0; i < 4; ++i)
    show.take(frame_of({7, i + 1, kNowMs + 10 * static_cast<int64_t>(i)}), 10 * i);
  const Timeline& line = show.read();
  EXPECT_EQ(line.frames(), 4u);
  EXPECT_EQ(line.unusable(), 0u);
  EXPECT_EQ(line.first_ns(), kNowMs * kMsNs);
  EXPECT_EQ(line.last_ns(), (kNowMs + 30) * kMsNs);
  const auto seen = show.at({kNowMs + 20});
  ASSERT_EQ(seen.poses.size(), 1u);
  EXPECT_EQ(seen.poses[0].m, pose_of(7, 3).m);
}

TEST(Timeline, LongPauseAndReasonsAreTold) {
  constexpr int64_t kHourMs = 3'600'000;
  ViewerDocument show;
  show.take(described(7), 0);
  show.take(frame_of({7, 1, 10}), 10);
  show.take(frame_of({7, 2, INT64_MAX / kMsNs}), 20);
  show.take(frame_of({7, 3, kHourMs}), kHourMs);
  const Timeline& line = show.read();
  EXPECT_EQ(line.longest_pause().from_ns, 10 * kMsNs);
  EXPECT_EQ(line.longest_pause().length_ns, (kHourMs - 10) * kMsNs);
  ASSERT_EQ(line.unusable_notes().size(), 1u);
  EXPECT_EQ(line.unusable_notes()[0],
            "stream \"arm\": 1 pose frame with a simulated time beyond 146 years left out");
}

// Segments before the guide's first frame are laid out one before the other.
TEST(Timeline, DistantTimesAreRefused) {
  constexpr int64_t kFarMs = (int64_t{1} << 60) / kMsNs - 1;
  record_test::MemoryLog log;
  ASSERT_TRUE(log.take(described(7, "arm"), 0, 1));
  for (uint64_t i = 0; i < 5; ++i) {
    ASSERT_TRUE(log.take(frame_of({7, 2 * i + 1, -kFarMs, 0, wire::kFrameDiscontinuity}), 2 * i + 1, 1));
    ASSERT_TRUE(log.take(frame_of({7, 2 * i + 2, kFarMs}), 2 * i + 2, 1));
  }
  ASSERT_TRUE(log.take(described(8, "lathe"), 20, 2));
  ASSERT_TRUE(log.take(frame_of({8, 1, 0}), 21, 2));
  ASSERT_TRUE(log.log.finish().ok());
  auto playback = record::Playback::open(record_test::source_of(*log.files[0]));
  ASSERT_TRUE(playback.ok());
  const auto line = Timeline::read(*playback, "lathe", {});
  ASSERT_FALSE(line.ok());
  EXPECT_NE(line.error().message.find("\"arm\" are too far apart"), std::string::npos)
      << line.error().message;
}

TEST(Timeline, SaysWhatIsMissing) {
  record_test::MemoryLog log;
  ASSERT_TRUE(log.take(described(7), 0));
  ASSERT_TRUE(log.log.finish().ok());
  auto playback = record::Playback::open(record_test::source_of(*log.files[0]));
  ASSERT_TRUE(playback.ok());
  const auto none = Timeline::read(*playback, "", {});
  ASSERT_FALSE(none.ok());
  EXPECT_NE(none.error().message.find("no whole pose frame"), std::string::npos);
  const auto unknown = Timeline::read(*playback, "lathe", {});
  ASSERT_FALSE(unknown.ok());
  EXPECT_NE(unknown.error().message.find("\"arm\""), std::string::npos);
}

}  // namespace
}  // namespace fire3dv::offline
