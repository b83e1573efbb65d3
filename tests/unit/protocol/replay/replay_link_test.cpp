// Test of the replay link: messages that a renderer receives from a recording, and timeline control.
#include "protocol/replay/replay_link.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <thread>

#include "protocol/wire/decode.h"
#include "tests/unit/protocol/record/record_files.h"

namespace fire3dv::record_test {
namespace {

using replay::ReplayLink;
using replay::ReplayOptions;
using transport::LinkEvent;

struct Said {
  transport::PeerId peer = 0;
  std::string kind;  // description, frame, edit, goodbye, note
  uint64_t epoch = 0, sequence = 0;
  uint32_t flags = 0;
  float first_x = 0;
  std::string text;
};

// Messages of one poll, decoded.
std::vector<Said> poll(ReplayLink& link) {
  std::vector<Said> result;
  wire::Decoder decoder;
  link.poll([&](const LinkEvent& event) {
    if (event.kind == LinkEvent::Kind::note) {
      result.push_back({0, "note", 0, 0, 0, 0, std::string(event.text)});
      return;
    }
    const auto decoded = decoder.decode(event.message);
    ASSERT_TRUE(decoded.ok());
    if (const auto* description = std::get_if<wire::StreamDescription>(&*decoded))
      result.push_back({event.peer, "description", description->epoch, 0, 0, 0, description->adapter_name});
    if (const auto* frame = std::get_if<wire::PoseFrameView>(&*decoded))
      result.push_back({event.peer,
                        "frame",
                        frame->header.epoch,
                        frame->header.sequence,
                        frame->header.flags,
                        frame->poses[0].m[3],
                        {}});
    if (const auto* edit = std::get_if<wire::SceneEdit>(&*decoded))
      result.push_back({event.peer, "edit", edit->epoch, edit->version, 0, 0, edit->node});
    if (const auto* goodbye = std::get_if<wire::Goodbye>(&*decoded))
      result.push_back({event.peer, "goodbye", goodbye->epoch, 0, 0, 0, {}});
  });
  return result;
}

std::vector<Said> of_kind(const std::vector<Said>& said, const std::string& kind) {
  std::vector<Said> result;
  std::ranges::copy_if(said, std::back_inserter(result), [&](const Said& each) { return each.kind == kind; });
  return result;
}

std::vector<uint64_t> sequences(const std::vector<Said>& said) {
  std::vector<uint64_t> result;
  for (const Said& each : of_kind(said, "frame")) result.push_back(each.sequence);
  return result;
}

std::vector<Said> poll_to_the_end(ReplayLink& link) {
  std::vector<Said> result;
  while (!link.timeline().at_end) std::ranges::copy(poll(link), std::back_inserter(result));
  return result;
}

ReplayOptions each_frame() {
  ReplayOptions options;
  options.each_frame = true;
  return options;
}

std::unique_ptr<ReplayLink> open(const Bytes& file, const ReplayOptions& options) {
  auto link = ReplayLink::open(source_of(file), options);
  EXPECT_TRUE(link.ok()) << (link.ok() ? "" : link.error().message);
  return std::move(*link);
}

// Frame s at s ms; an edit before every eighth frame.
Bytes forty_frames() {
  return small_recording(record::Compression::zstd);
}

uint64_t at_ms(uint64_t ms) {
  return kBegun_ns + ms * kMs;
}

TEST(ReplayLink, FramesComeOnceWithState) {
  const auto link = open(forty_frames(), each_frame());
  for (uint64_t s = 1; s <= 40; ++s) {
    const std::vector<Said> said = poll(*link);
    ASSERT_EQ(sequences(said), std::vector<uint64_t>{s});
    EXPECT_EQ(of_kind(said, "description").size(), s == 1 ? 1u : 0u);
    EXPECT_EQ(of_kind(said, "edit").size(), s % 8 == 1 ? 1u : 0u);
    const Said frame = of_kind(said, "frame")[0];
    EXPECT_EQ(frame.epoch, 7u) << "a run that is not cut is the one that was recorded";
    EXPECT_EQ(frame.flags, 0u);
    EXPECT_EQ(frame.first_x, static_cast<float>(s * 10));
    EXPECT_EQ(link->timeline().sim_time_ns, static_cast<int64_t>(s * kMs));
  }
  EXPECT_TRUE(of_kind(poll(*link), "goodbye").empty()) << "the last picture stays";
  EXPECT_TRUE(link->timeline().at_end);
  EXPECT_EQ(link->timeline().frames, 40u);
}

TEST(ReplayLink, StreamsEndOnRequest) {
  ReplayOptions options = each_frame();
  options.end_streams = true;
  const auto link = open(forty_frames(), options);
  const std::vector<Said> said = poll_to_the_end(*link);
  EXPECT_EQ(sequences(said).size(), 40u);
  EXPECT_EQ(said.back().kind, "goodbye");
  EXPECT_EQ(of_kind(said, "goodbye").size(), 1u);
}

TEST(ReplayLink, SeekShowsNewestFrame) {
  const auto link = open(forty_frames(), each_frame());
  link->pause();
  std::vector<uint64_t> epochs;
  for (const uint64_t ms : {25u, 3u, 40u, 24u}) {
    link->seek(at_ms(ms) + kMs / 2);
    const std::vector<Said> said = poll(*link);
    const std::vector<Said> frames = of_kind(said, "frame"), described = of_kind(said, "description");
    ASSERT_EQ(frames.size(), 1u) << ms;
    ASSERT_EQ(described.size(), 1u);
    EXPECT_EQ(frames[0].first_x, static_cast<float>(ms * 10));
    EXPECT_EQ(frames[0].flags, wire::kFrameDiscontinuity);
    EXPECT_EQ(frames[0].epoch, described[0].epoch);
    EXPECT_EQ(std::ranges::count(epochs, frames[0].epoch), 0) << "each seek is a run of its own";
    epochs.push_back(frames[0].epoch);
    // The newest edit of each of three nodes at that time, in the order of versions.
    const std::vector<Said> edits = of_kind(said, "edit");
    EXPECT_TRUE(std::ranges::is_sorted(edits, {}, &Said::sequence));
    std::map<std::string, uint64_t> newest, expected;
    for (const Said& each : edits) newest[each.text] = each.sequence;
    for (uint64_t version = 1; version <= ms; version += 8)
      expected["link_" + std::to_string(version % 3)] = version;
    EXPECT_EQ(newest, expected) << ms;
    EXPECT_TRUE(poll(*link).empty()) << "paused";
    EXPECT_EQ(link->timeline().position_ns, at_ms(ms) + kMs / 2);
  }
  link->play();
  EXPECT_EQ(sequences(poll(*link)), std::vector<uint64_t>{25}) << "and on from there";
}

TEST(ReplayLink, SeekBackEndsLaterStreams) {
  MemoryLog memory;
  ASSERT_TRUE(memory.take(description(7), 0));
  ASSERT_TRUE(memory.take(frame(7, 1), 1));
  ASSERT_TRUE(memory.take(description(8, "crane"), 1000, 2));
  ASSERT_TRUE(memory.take(frame(8, 1), 1001, 2));
  ASSERT_TRUE(memory.take(frame(7, 2), 1002));
  ASSERT_TRUE(memory.log.finish().ok());
  const auto link = open(*memory.files[0], each_frame());
  poll_to_the_end(*link);
  link->seek(at_ms(500));
  const std::vector<Said> said = poll(*link);
  EXPECT_EQ(of_kind(said, "goodbye").size(), 2u);
  ASSERT_EQ(of_kind(said, "description").size(), 1u);
  EXPECT_EQ(of_kind(said, "description")[0].text, "arm");
  EXPECT_EQ(of_kind(said, "frame")[0].first_x, 10.f) << "half a second back: it is slower than most";
}

TEST(ReplayLink, StepsPlayOneFrameEach) {
  ReplayOptions options;
  options.speed = 1e-6;  // effectively paused
  const auto link = open(forty_frames(), options);
  link->seek(at_ms(10));
  EXPECT_EQ(sequences(poll(*link)), std::vector<uint64_t>{10});
  for (const uint64_t next : {11u, 12u}) {
    link->step();
    EXPECT_EQ(sequences(poll(*link)), std::vector<uint64_t>{next});
    EXPECT_TRUE(poll(*link).empty());
    EXPECT_EQ(link->timeline().position_ns, at_ms(next));
    EXPECT_FALSE(link->timeline().playing);
  }
  link->seek(at_ms(1000));
  EXPECT_EQ(sequences(poll(*link)), std::vector<uint64_t>{40});
  link->step();
  poll(*link);
  EXPECT_TRUE(link->timeline().at_end);
  link->play();
  EXPECT_FALSE(link->timeline().at_end) << "from the beginning";
  EXPECT_EQ(link->timeline().start_ns, at_ms(0));
}

TEST(ReplayLink, StepsBackShowFrameBefore) {
  ReplayOptions options;
  options.speed = 1e-6;  // effectively paused
  const auto link = open(forty_frames(), options);
  link->seek(at_ms(10));
  EXPECT_EQ(sequences(poll(*link)), std::vector<uint64_t>{10});
  for (const uint64_t before : {9u, 8u, 7u}) {
    link->step_back();
    EXPECT_EQ(sequences(poll(*link)), std::vector<uint64_t>{before});
    EXPECT_EQ(link->timeline().position_ns, at_ms(before));
    EXPECT_FALSE(link->timeline().playing);
  }
  link->step();
  EXPECT_EQ(sequences(poll(*link)), std::vector<uint64_t>{8});
  link->seek(at_ms(1000));  // between frames: back to the one before the shown one, which is the last
  poll(*link);
  link->step_back();
  EXPECT_EQ(sequences(poll(*link)), std::vector<uint64_t>{39});
  for (int i = 0; i < 45; ++i) link->step_back();
  const std::vector<uint64_t> shown = sequences(poll(*link));
  EXPECT_EQ(shown.empty() ? 0 : shown.back(), 1u) << "the first frame stays";
  link->step();
  EXPECT_EQ(sequences(poll(*link)), std::vector<uint64_t>{2});
}

TEST(ReplayLink, SpeedAndPauseMovePosition) {
  ReplayOptions options;
  options.speed = 0;
  const auto link = open(forty_frames(), options);
  link->pause();
  EXPECT_TRUE(of_kind(poll(*link), "frame").empty());
  link->set_speed(-3);
  EXPECT_EQ(link->timeline().speed, 1);
  link->set_speed(1e9);
  link->play();
  while (!link->timeline().at_end) poll(*link);
  EXPECT_EQ(link->timeline().position_ns, link->timeline().end_ns);
  EXPECT_EQ(link->timeline().frames, 40u);
}

TEST(ReplayLink, PacedFramesAreNotEarly) {
  const auto link = open(forty_frames(), {});
  poll(*link);
  const auto begun = std::chrono::steady_clock::now();
  std::vector<uint64_t> came;
  while (!link->timeline().at_end) {
    link->wait(std::chrono::milliseconds(5));
    for (const uint64_t sequence : sequences(poll(*link))) {
      came.push_back(sequence);
      const auto since = std::chrono::steady_clock::now() - begun;
      EXPECT_GE(since + std::chrono::milliseconds(1),
                std::chrono::milliseconds(sequence) - std::chrono::milliseconds(1));
    }
  }
  EXPECT_EQ(came.size(), 40u);
}

TEST(ReplayLink, LoopIsNewRun) {
  ReplayOptions options = each_frame();
  options.loop = true;
  options.start_s = 0.0101;
  options.end_s = 0.0202;
  const auto link = open(forty_frames(), options);
  std::vector<Said> said;
  while (sequences(said).size() < 30) std::ranges::copy(poll(*link), std::back_inserter(said));
  const std::vector<Said> frames = of_kind(said, "frame");
  EXPECT_EQ(frames[0].sequence, 10u) << "what is shown when it begins";
  EXPECT_EQ(frames[0].flags, wire::kFrameDiscontinuity);
  EXPECT_EQ(frames[10].sequence, 20u);
  EXPECT_EQ(frames[11].sequence, 10u);
  EXPECT_EQ(frames[10].epoch, 7u);
  EXPECT_NE(frames[11].epoch, 7u);
  EXPECT_NE(frames[22].epoch, frames[11].epoch);
}

// For any number of messages: progress must not depend on the interval of time checks.
TEST(ReplayLink, FastLoopIsOneRoundPerPoll) {
  for (uint64_t frames = 1; frames <= 32; ++frames) {
    MemoryLog memory;
    ASSERT_TRUE(memory.take(description(7), 0));
    for (uint64_t s = 1; s <= frames; ++s) ASSERT_TRUE(memory.take(frame(7, s), s));
    ASSERT_TRUE(memory.log.finish().ok());
    ReplayOptions options;
    options.loop = true;
    options.speed = 0;
    const auto link = open(*memory.files[0], options);
    std::vector<uint64_t> epochs;
    while (epochs.size() < 3) {
      const std::vector<Said> said = poll(*link);
      ASSERT_LE(sequences(said).size(), frames);
      for (const Said& each : of_kind(said, "description")) epochs.push_back(each.epoch);
    }
    EXPECT_NE(epochs[1], epochs[2]);
  }
}

// Source whose reads each exceed the time of a poll.
class SlowSource final : public record::Source {
 public:
  explicit SlowSource(Bytes bytes) : memory_(std::move(bytes)) {}
  uint64_t size() const override { return memory_.size(); }
  const std::string& name() const override { return memory_.name(); }
  Result<void> read(uint64_t offset, std::span<std::byte> to) override {
    if (is_slow) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return memory_.read(offset, to);
  }
  static inline bool is_slow = false;

 private:
  record::MemorySource memory_;
};

TEST(ReplayLink, LateLoopStartIsIncremental) {
  ReplayOptions options;
  options.loop = true;
  options.speed = 0;
  options.start_s = 0.2501;
  options.end_s = 0.2602;
  auto link = ReplayLink::open(std::make_unique<SlowSource>(small_recording(record::Compression::none, 300)),
                               options);
  ASSERT_TRUE(link.ok()) << link.error().message;
  std::vector<Said> said;
  while (sequences(said).size() < 11) std::ranges::copy(poll(**link), std::back_inserter(said));
  EXPECT_EQ(of_kind(said, "frame").back().sequence, 260u);
  SlowSource::is_slow = true;
  said.clear();
  size_t silent = 0;
  while (said.empty()) {
    said = poll(**link);
    silent += said.empty();
  }
  SlowSource::is_slow = false;
  EXPECT_GE(silent, 4u) << "250 messages of before, in pieces";
  ASSERT_FALSE(of_kind(said, "frame").empty());
  const Said first = of_kind(said, "frame")[0];
  EXPECT_EQ(first.sequence, 250u);
  EXPECT_EQ(first.flags, wire::kFrameDiscontinuity);
  EXPECT_EQ(of_kind(said, "description").size(), 1u);
}

TEST(ReplayLink, PartsBecomeWholeFrames) {
  MemoryLog memory;
  ASSERT_TRUE(memory.take(description(7), 0));
  std::vector<wire::Affine3x4> poses(3);
  wire::PoseFrameView view;
  view.node_count = 3;
  const auto take = [&](uint64_t sequence, uint32_t first, uint32_t count, float x) {
    view.header.epoch = 7;
    view.header.sequence = sequence;
    view.header.sim_time_ns = static_cast<int64_t>(sequence * kMs);
    view.first_node = first;
    for (auto& pose : poses) pose.m[3] = x;
    view.poses = std::span(poses).first(count);
    ASSERT_TRUE(memory.take(wire::encode(view), sequence));
  };
  take(1, 0, 2, 1);
  take(1, 2, 1, 1);
  take(2, 0, 2, 2);  // its second part is missing
  take(3, 0, 3, 3);
  const std::vector<uint32_t> one{0};
  view.node_indices = one;
  take(4, 0, 1, 4);
  ASSERT_TRUE(memory.log.finish().ok());
  const record::StreamSeen seen = memory.log.streams().at(0);
  EXPECT_EQ(seen.frames, 4u);
  EXPECT_EQ(seen.parts, 3u);
  EXPECT_EQ(seen.incomplete, 1u);
  EXPECT_EQ(seen.missing, 0u);
  const auto link = open(*memory.files[0], each_frame());
  EXPECT_EQ(sequences(poll_to_the_end(*link)), (std::vector<uint64_t>{1, 3, 4}));
  link->seek(at_ms(4));
  const std::vector<Said> shown = of_kind(poll(*link), "frame");
  ASSERT_EQ(shown.size(), 1u);
  EXPECT_EQ(shown[0].first_x, 4.f);
  link->seek(at_ms(2));
  const std::vector<Said> before = of_kind(poll(*link), "frame");
  ASSERT_EQ(before.size(), 1u);
  EXPECT_EQ(before[0].first_x, 1.f) << "frame 2 was open then, and frame 1 shown";
}

TEST(ReplayLink, StreamsAreChosenByName) {
  MemoryLog memory;
  ASSERT_TRUE(memory.take(description(7), 0));
  ASSERT_TRUE(memory.take(description(8, "crane"), 0, 2));
  for (uint64_t s = 1; s <= 5; ++s) {
    ASSERT_TRUE(memory.take(frame(7, s), s));
    ASSERT_TRUE(memory.take(frame(8, s), s, 2));
  }
  ASSERT_TRUE(memory.log.finish().ok());
  ReplayOptions options = each_frame();
  const std::vector<Said> both = poll_to_the_end(*open(*memory.files[0], options));
  EXPECT_EQ(of_kind(both, "frame").size(), 10u);
  options.streams = {"crane"};
  const std::vector<Said> one = poll_to_the_end(*open(*memory.files[0], options));
  EXPECT_EQ(of_kind(one, "frame").size(), 5u);
  EXPECT_EQ(of_kind(one, "frame")[0].epoch, 8u);
  options.streams = {"boat"};
  const auto none = ReplayLink::open(source_of(*memory.files[0]), options);
  ASSERT_FALSE(none.ok());
  EXPECT_NE(none.error().message.find("it has \"arm\", \"crane\""), std::string::npos)
      << none.error().message;
}

TEST(ReplayLink, UnselectedStreamsKeepTime) {
  MemoryLog memory;
  ASSERT_TRUE(memory.take(description(7), 0));
  ASSERT_TRUE(memory.take(frame(7, 1), 0));
  ASSERT_TRUE(memory.take(wire::encode(wire::Goodbye{7}), 0));
  ASSERT_TRUE(memory.take(description(8, "crane"), 0, 2));
  for (uint64_t s = 1; s <= 100; ++s) ASSERT_TRUE(memory.take(frame(8, s), s * 3'600'000, 2));
  ASSERT_TRUE(memory.log.finish().ok());
  ReplayOptions options;
  options.streams = {"arm"};
  const auto link = open(*memory.files[0], options);
  std::vector<Said> said;
  for (int i = 0; i < 10; ++i) std::ranges::copy(poll(*link), std::back_inserter(said));
  EXPECT_EQ(sequences(said), std::vector<uint64_t>{1});
  EXPECT_FALSE(link->timeline().at_end) << "the other stream goes on for hours";
  link->set_speed(0);
  std::ranges::copy(poll_to_the_end(*link), std::back_inserter(said));
  EXPECT_TRUE(of_kind(said, "goodbye").empty()) << "the last of what was chosen: its picture stays";
}

TEST(ReplayLink, FindsSimulatedTimes) {
  const auto link = open(small_recording(record::Compression::none, 300, 700), each_frame());
  link->pause();
  for (const uint64_t ms : {1u, 17u, 150u, 299u, 300u}) {
    ASSERT_TRUE(link->seek_sim_time(static_cast<int64_t>(ms * kMs - 1)).ok());
    EXPECT_EQ(of_kind(poll(*link), "frame").at(0).first_x, static_cast<float>(ms * 10)) << ms;
  }
  ASSERT_TRUE(link->seek_sim_time(-5).ok());
  EXPECT_EQ(of_kind(poll(*link), "frame").at(0).first_x, 10.f);
  EXPECT_FALSE(link->seek_sim_time(static_cast<int64_t>(301 * kMs)).ok());
  EXPECT_EQ(link->timeline().position_ns, at_ms(1)) << "where it was";
}

TEST(ReplayLink, DamageIsReportedOnce) {
  Bytes file = small_recording(record::Compression::zstd, 300, 1000);
  size_t chunks = 0;
  {
    auto reader = record::Reader::open(source_of(file));
    ASSERT_TRUE(reader.ok());
    chunks = reader->index().chunks.size();
    for (const size_t chunk : {chunks / 2, chunks / 2 + 2})
      file[reader->index().chunks[chunk].offset + 80] ^= std::byte{1};
  }
  const auto link = open(file, each_frame());
  const std::vector<Said> said = poll_to_the_end(*link);
  EXPECT_EQ(of_kind(said, "note").size(), 1u);
  EXPECT_EQ(link->timeline().damaged_chunks, 2u);
  EXPECT_GT(sequences(said).size(), 300 - 300 / chunks * 4);
  EXPECT_LT(sequences(said).size(), 300u);
}

TEST(ReplayLink, PollSkipsBoundedDamage) {
  Bytes file = small_recording(record::Compression::none, 300, 1000);
  size_t chunks = 0;
  {
    auto reader = record::Reader::open(source_of(file));
    ASSERT_TRUE(reader.ok());
    chunks = reader->index().chunks.size();
    for (size_t chunk = 2; chunk < chunks; ++chunk)
      file[reader->index().chunks[chunk].offset + 80] ^= std::byte{1};
  }
  ReplayOptions options;
  options.speed = 0;
  auto link = ReplayLink::open(std::make_unique<SlowSource>(std::move(file)), options);
  ASSERT_TRUE(link.ok()) << link.error().message;
  SlowSource::is_slow = true;
  while ((*link)->timeline().damaged_chunks == 0) poll(**link);
  SlowSource::is_slow = false;
  EXPECT_EQ((*link)->timeline().damaged_chunks, 1u);
  poll_to_the_end(**link);
  EXPECT_EQ((*link)->timeline().damaged_chunks, chunks - 2);
}

TEST(ReplayLink, ABadPartIsRefused) {
  ReplayOptions options;
  options.start_s = 0.03;
  options.end_s = 0.01;
  EXPECT_FALSE(ReplayLink::open(source_of(forty_frames()), options).ok());
  options.start_s = 2;
  options.end_s = 1;
  EXPECT_FALSE(ReplayLink::open(source_of(forty_frames()), options).ok()) << "both are behind its end";
  EXPECT_FALSE(ReplayLink::open(source_of(Bytes(100)), {}).ok());
  EXPECT_FALSE(ReplayLink::open("/nowhere/x.mcap", {}).ok());
}

}  // namespace
}  // namespace fire3dv::record_test
