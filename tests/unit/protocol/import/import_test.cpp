// Test of the import: times, interpolation, silence and parents, by messages in memory and the recording's
// poses.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "protocol/import/import.h"
#include "protocol/import/survey.h"
#include "protocol/record/playback.h"
#include "protocol/wire/decode.h"

namespace fire3dv::imported {
namespace {

constexpr uint64_t kMs = 1'000'000;

// Messages in JSON, in memory.
class Made final : public MessageSource {
 public:
  const std::string& name() const override { return name_; }
  const std::vector<Topic>& topics() const override { return topics_; }
  Result<void> rewind(const std::vector<size_t>&) override {
    at_ = 0;
    return {};
  }
  Result<std::optional<SourceMessage>> next() override {
    if (at_ == messages_.size()) return std::optional<SourceMessage>();
    const auto& [topic, log_ms, text] = messages_[at_++];
    return std::optional(
        SourceMessage{topic, log_ms * kMs, at_, std::as_bytes(std::span(text.data(), text.size()))});
  }
  double progress() const override { return 0; }
  std::vector<std::string> take_warnings() override { return {}; }

  // A translation along x.
  void add(uint64_t stamp_ms, const std::string& parent, const std::string& child, double x,
           size_t topic = 0) {
    char text[400];
    std::snprintf(text, sizeof text,
                  R"({"timestamp":{"sec":%llu,"nsec":%llu},"parent_frame_id":"%s","child_frame_id":"%s",)"
                  R"("translation":{"x":%.9g,"y":0,"z":0},"rotation":{"x":0,"y":0,"z":0,"w":1}})",
                  static_cast<unsigned long long>(stamp_ms / 1000),
                  static_cast<unsigned long long>(stamp_ms % 1000 * kMs), parent.c_str(), child.c_str(), x);
    add_text(text, topic);
  }
  void add_text(const std::string& text, size_t topic = 0) {
    messages_.push_back({topic, log_ms_ += 1, text});
  }

  uint64_t log_ms_ = 100'000;

 private:
  std::string name_ = "made.mcap";
  std::vector<Topic> topics_{{"/poses", "foxglove.FrameTransform", "json"},
                             {"/others", "foxglove.FrameTransform", "json"}};
  struct Message {
    size_t topic;
    uint64_t log_ms;
    std::string text;
  };
  std::vector<Message> messages_;
  size_t at_ = 0;
};

// x of each node at each time in milliseconds.
using Xs = std::map<int64_t, std::vector<float>>;

struct Imported {
  Result<ImportReport> report;
  Xs xs;
};

Imported import_nodes(Made& made, const std::vector<std::string>& nodes, const std::string& fixed = "") {
  ImportOptions options;
  options.fixed_frame = fixed;
  options.find_node = [&](std::string_view name) -> std::optional<SceneNode> {
    const auto found = std::find(nodes.begin(), nodes.end(), name);
    if (found == nodes.end()) return std::nullopt;
    SceneNode node;
    node.index = static_cast<uint32_t>(found - nodes.begin());
    node.name = std::string(name);
    return node;
  };
  wire::Bytes bytes;
  Imported result{import_states(made, options, std::make_unique<record::MemorySink>(bytes)), {}};
  if (!result.report) return result;
  auto playback = record::Playback::open(std::make_unique<record::MemorySource>(std::move(bytes)));
  EXPECT_TRUE(playback.ok());
  wire::Decoder decoder;
  std::vector<size_t> order;
  record::Played played;
  playback->rewind();
  while (playback->next(played) == record::Playback::Step::played) {
    auto message = decoder.decode(played.message);
    EXPECT_TRUE(message.ok());
    if (const auto* description = std::get_if<wire::StreamDescription>(&*message))
      for (const std::string& name : nodes)
        order.push_back(static_cast<size_t>(
            std::find(description->node_names.begin(), description->node_names.end(), name) -
            description->node_names.begin()));
    const auto* frame = std::get_if<wire::PoseFrameView>(&*message);
    if (!frame) continue;
    std::vector<float>& xs = result.xs[frame->header.sim_time_ns / static_cast<int64_t>(kMs)];
    for (const size_t node : order) xs.push_back(node < frame->poses.size() ? frame->poses[node].m[3] : NAN);
  }
  return result;
}

TEST(Import, FramesOfOneTimeAreInterpolated) {
  Made made;
  made.add(1000, "map", "a", 0);
  made.add(1000, "a", "b", 10);
  made.add(1100, "map", "a", 1);
  made.add(1200, "map", "a", 2);
  made.add(1300, "map", "a", 3);
  made.add(1200, "a", "b", 12);  // 100 ms late
  const Imported result = import_nodes(made, {"a", "b"});
  ASSERT_TRUE(result.report.ok());
  EXPECT_EQ(result.xs, (Xs{{1000, {0, 10}}, {1100, {1, 12}}, {1200, {2, 14}}, {1300, {3, 15}}}));
  EXPECT_EQ(result.report->frames, 4u);
  EXPECT_EQ(result.report->fixed_frame, "map");
}

TEST(Import, BeforeTheFirstAndAfterTheLast) {
  Made made;
  made.add(1000, "map", "a", 0);
  made.add(1100, "map", "a", 1);
  made.add(1100, "map", "late", 5);
  made.add(1150, "map", "late", 6);
  made.add(1200, "map", "a", 2);
  made.add(900, "map", "single", 9);  // one transform makes no time
  const Imported result = import_nodes(made, {"a", "late", "single"});
  ASSERT_TRUE(result.report.ok());
  EXPECT_EQ(result.xs, (Xs{{1000, {0, 5, 9}}, {1100, {1, 5, 9}}, {1150, {1.5, 6, 9}}, {1200, {2, 6, 9}}}));
}

TEST(Import, FirstTransformLongAfterTheOthers) {
  Made made;
  for (uint64_t i = 0; i < 4; ++i) made.add(1000 * i, "map", "a", static_cast<double>(i));
  made.add(20'000, "map", "a", 4);
  made.add(20'000, "map", "late", 7);
  made.add(20'100, "map", "late", 8);
  EXPECT_EQ(
      import_nodes(made, {"a", "late"}).xs,
      (Xs{{0, {0, 7}}, {1000, {1, 7}}, {2000, {2, 7}}, {3000, {3, 7}}, {20'000, {4, 7}}, {20'100, {4, 8}}}));
}

TEST(Import, SilenceIsHeld) {
  for (const uint64_t gap_ms : {900u, 3000u, 30'000u}) {
    Made made;
    for (uint64_t ms = 0; ms <= gap_ms + 200; ms += 100) {
      made.add(5000 + ms, "map", "clock", 0);
      if (ms == 0) made.add(5000, "map", "a", 1);
      if (ms == gap_ms) made.add(5000 + ms, "map", "a", 2);
    }
    const Imported result = import_nodes(made, {"clock", "a"});
    ASSERT_TRUE(result.report.ok());
    const float expected = gap_ms == 900 ? 1 + 8.0f / 9 : 1;
    EXPECT_NEAR(result.xs.at(static_cast<int64_t>(5000 + gap_ms - 100))[1], expected, 1e-6) << gap_ms;
    EXPECT_EQ(result.xs.at(static_cast<int64_t>(5000 + gap_ms))[1], 2) << gap_ms;
  }
}

TEST(Import, OrderOfMessagesWithinASecondDoesNotMatter) {
  Made in_order, mixed;
  for (uint64_t i = 0; i < 20; ++i) in_order.add(1000 + 10 * i, "map", "a", static_cast<double>(i * i));
  for (uint64_t i = 0; i < 20; ++i) {
    const uint64_t k = i * 7 % 20;
    mixed.add(1000 + 10 * k, "map", "a", static_cast<double>(k * k));
  }
  EXPECT_EQ(import_nodes(in_order, {"a"}).xs, import_nodes(mixed, {"a"}).xs);
  EXPECT_EQ(import_nodes(in_order, {"a"}).xs.size(), 20u);
}

TEST(Import, OtherParentFromATimeOn) {
  Made made;
  for (uint64_t i = 0; i < 4; ++i) {
    made.add(1000 + 100 * i, "map", "hand", static_cast<double>(i));
    made.add(1000 + 100 * i, i < 2 ? "map" : "hand", "cup", 5);
  }
  EXPECT_EQ(import_nodes(made, {"hand", "cup"}).xs,
            (Xs{{1000, {0, 5}}, {1100, {1, 5}}, {1200, {2, 7}}, {1300, {3, 8}}}));
}

TEST(Import, OriginThatAppearsLater) {
  Made made;
  made.add(1000, "start", "a", 1);
  made.add(1100, "late", "a", 2);
  made.add(1200, "late", "a", 3);
  made.add(1200, "late", "b", 4);
  EXPECT_EQ(import_nodes(made, {"a", "b"}, "late").xs, (Xs{{1000, {0, 4}}, {1100, {2, 4}}, {1200, {3, 4}}}));
  Made alone;  // nothing has the origin at first
  alone.add(1000, "start", "a", 1);
  alone.add(1100, "late", "a", 2);
  EXPECT_EQ(import_nodes(alone, {"a"}, "late").xs, (Xs{{1000, {0}}, {1100, {2}}}));
}

TEST(Import, ZeroIsATimeWhereOthersAreStamped) {
  Made made;
  for (uint64_t i = 0; i < 3; ++i) made.add(100 * i, "map", "a", static_cast<double>(i));
  EXPECT_EQ(import_nodes(made, {"a"}).xs, (Xs{{0, {0}}, {100, {1}}, {200, {2}}}));
  Made unstamped;  // log times count
  for (uint64_t i = 0; i < 2; ++i) unstamped.add(0, "map", "a", static_cast<double>(i));
  EXPECT_EQ(import_nodes(unstamped, {"a"}).xs, (Xs{{100'001, {0}}, {100'002, {1}}}));
}

TEST(Import, ATopicWithoutStampsHasLogTimes) {
  Made made;
  for (uint64_t i = 0; i < 3; ++i) {
    made.log_ms_ = 200'000 + 100 * i - 1;
    made.add(200'000 + 100 * i, "map", "a", static_cast<double>(i));
    made.log_ms_ = 200'050 + 100 * i - 1;
    made.add(0, "map", "b", static_cast<double>(10 + i), 1);
  }
  const Imported result = import_nodes(made, {"a", "b"});
  ASSERT_TRUE(result.report.ok());
  EXPECT_EQ(result.xs, (Xs{{200'000, {0, 10}},
                           {200'050, {0.5, 10}},
                           {200'100, {1, 10.5}},
                           {200'150, {1.5, 11}},
                           {200'200, {2, 11.5}},
                           {200'250, {2, 12}}}));
  EXPECT_EQ(
      result.report->warnings,
      (std::vector<std::string>{"the messages of topic \"/others\" have no stamps: their log times count"}));
}

TEST(Import, AMissingStampIsLeftOut) {
  constexpr uint64_t kLateMs = 1'700'000'000'000;
  Made made;
  made.add(kLateMs, "map", "a", 0);
  made.add(0, "map", "a", 5);
  made.add(kLateMs + 100, "map", "a", 1);
  const Imported result = import_nodes(made, {"a"});
  ASSERT_TRUE(result.report.ok());
  EXPECT_EQ(result.xs, (Xs{{kLateMs, {0}}, {kLateMs + 100, {1}}}));
  EXPECT_EQ(result.report->warnings,
            (std::vector<std::string>{"1 transform of topic \"/poses\" is left out: it has no stamp, but "
                                      "others of its topic have one (message 2, frame \"a\")"}));
}

TEST(Import, StopsWithinMessagesThatCannotBeDecoded) {
  Made made;
  for (size_t i = 0; i < 100; ++i) made.add_text("{");
  ImportOptions options;
  size_t calls = 0;
  options.on_progress = [&](double) { return ++calls < 10; };
  wire::Bytes bytes;
  const auto report = import_states(made, options, std::make_unique<record::MemorySink>(bytes));
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().message, "stopped");
  EXPECT_EQ(calls, 10u);
}

TEST(Import, LongNamesOfJointsAreLeftOut) {
  const Topic topic{"/joint_states", "sensor_msgs/msg/JointState", "cdr"};
  Batch batch{.topic = &topic, .number = 1};
  batch.joints = JointState{1, {std::string(255, 'a'), std::string(256, 'b')}, {1, 2}};
  Survey survey;
  ASSERT_TRUE(survey.add(batch).ok());
  EXPECT_EQ(survey.joints(), (std::map<std::string, double>{{std::string(255, 'a'), 1}}));
  ASSERT_EQ(survey.faults().sentences().size(), 1u);
  EXPECT_NE(survey.faults().sentences()[0].find("longer than 255 bytes"), std::string::npos);
}

TEST(Import, FixedFrame) {
  Made made;
  made.add(1000, "map", "a", 1);
  made.add(1000, "a", "b", 2);
  made.add(1100, "map", "a", 3);
  EXPECT_EQ(import_nodes(made, {"b"}, "a").xs.begin()->second, (std::vector<float>{2}));
  EXPECT_EQ(import_nodes(made, {"b"}).xs.begin()->second, (std::vector<float>{3}));
  const Imported none = import_nodes(made, {"b"}, "odom");
  ASSERT_FALSE(none.report.ok());
  EXPECT_EQ(none.report.error().message, "--fixed-frame: \"made.mcap\" has no frame \"odom\"");
}

TEST(Import, LoopOfATime) {
  Made made;  // the newest parents have no loop, those at 1.1 s have one
  made.add(1000, "map", "a", 1);
  made.add(1000, "a", "b", 1);
  made.add(1100, "b", "a", 1);
  made.add(1200, "map", "a", 1);
  made.add(1300, "map", "a", 1);
  const Imported result = import_nodes(made, {"a", "b"});
  ASSERT_FALSE(result.report.ok());
  EXPECT_NE(
      result.report.error().message.find("at 1.100000000 s the parents of frame \"a\" lead back to itself"),
      std::string::npos)
      << result.report.error().message;
}

TEST(Import, NameOfTwoFrames) {
  Made made;
  made.add(1000, "map", "left/tool", 1);
  made.add(1000, "map", "right/tool", 2);
  made.add(1000, "map", "a", 2);
  const Imported result = import_nodes(made, {"tool", "a"});
  ASSERT_TRUE(result.report.ok());
  ASSERT_EQ(result.report->warnings.size(), 1u);
  EXPECT_EQ(
      result.report->warnings[0],
      "several frames end with the name of node \"tool\" and are left out: \"left/tool\", \"right/tool\"; "
      "choose one by --prefix");
}

}  // namespace
}  // namespace fire3dv::imported
