// Fuzz target of the import: arbitrary messages of ROS 2 and Foxglove become a recording that can be played,
// whose times rise, or an error.
#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "protocol/import/import.h"
#include "protocol/record/playback.h"
#include "protocol/wire/decode.h"
#include "tests/fuzz/target.h"

namespace fire3dv::fuzz {
namespace {

// Input: for each message its topic (u8), its length (u16, little-endian), and its bytes.
class InputMessages final : public imported::MessageSource {
 public:
  explicit InputMessages(std::span<const uint8_t> input) : input_(input) {}

  const std::string& name() const override { return name_; }
  const std::vector<imported::Topic>& topics() const override { return topics_; }
  Result<void> rewind(const std::vector<size_t>&) override {
    at_ = count_ = 0;
    return {};
  }
  Result<std::optional<imported::SourceMessage>> next() override {
    if (input_.size() - at_ < 3) return std::optional<imported::SourceMessage>();
    const size_t topic = input_[at_] % topics_.size();
    const size_t length = std::min<size_t>(input_[at_ + 1] | input_[at_ + 2] << 8, input_.size() - at_ - 3);
    const auto message = std::as_bytes(input_.subspan(at_ + 3, length));
    at_ += 3 + length;
    ++count_;
    return std::optional(imported::SourceMessage{topic, 1000 * count_, count_, message});
  }
  double progress() const override { return 0; }
  std::vector<std::string> take_warnings() override { return {}; }

 private:
  std::span<const uint8_t> input_;
  size_t at_ = 0;
  uint64_t count_ = 0;
  std::string name_ = "input";
  std::vector<imported::Topic> topics_{{"/tf", "tf2_msgs/msg/TFMessage", "cdr"},
                                       {"/tf_static", "geometry_msgs/msg/TransformStamped", "cdr"},
                                       {"/joint_states", "sensor_msgs/msg/JointState", "cdr"},
                                       {"/protobuf", "foxglove.FrameTransforms", "protobuf"},
                                       {"/json", "foxglove.FrameTransform", "json"}};
};

void append(Input& to, uint8_t topic, const std::string& message) {
  to.insert(to.end(),
            {topic, static_cast<uint8_t>(message.size()), static_cast<uint8_t>(message.size() >> 8)});
  to.insert(to.end(), message.begin(), message.end());
}

void put(std::string& to, uint32_t value) {
  char bytes[4];
  std::memcpy(bytes, &value, 4);
  to.append(bytes, 4);
}

// count: written before it; nothing: one TransformStamped.
std::string cdr_transform(std::optional<uint32_t> count, uint32_t nanoseconds, char child) {
  std::string message("\0\1\0\0", 4);
  if (count) put(message, *count);
  for (const uint32_t value : {uint32_t{1}, nanoseconds, uint32_t{2}}) put(message, value);
  message += std::string("m\0\0\0", 4);
  put(message, 2);
  message += std::string{child, '\0'};
  while ((message.size() - 4) % 8 != 0) message += '\0';
  for (const double number : {1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0})
    message.append(reinterpret_cast<const char*>(&number), sizeof number);
  return message;
}

std::string json_transform(char parent, char child) {
  return std::string(R"({"timestamp":{"sec":1,"nsec":2},"parent_frame_id":")") + parent +
         R"(","child_frame_id":")" + child +
         R"(","translation":{"x":1,"y":0,"z":0},"rotation":{"x":0,"y":0,"z":0,"w":1}})";
}

}  // namespace

std::vector<Input> seeds() {
  Input tf, mixed;
  for (uint32_t i = 0; i < 6; ++i) append(tf, 0, cdr_transform(1, i * 300'000'000, i % 2 == 0 ? 'a' : 'b'));
  append(mixed, 1, cdr_transform(std::nullopt, 5, 'a'));
  append(mixed, 4, json_transform('a', 'b'));
  append(mixed, 3,
         std::string("\x0a\x22\x0a\x04\x08\x01\x10\x05\x12\x01p\x1a\x01"
                     "c\x22\x09\x11\0\0\0\0\0\0\0\x40"
                     "\x2a\x09\x21\0\0\0\0\0\0\xf0\x3f",
                     36));
  append(mixed, 4, json_transform('b', 'c'));
  return {tf, mixed};
}

}  // namespace fire3dv::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace fire3dv;
  fuzz::InputMessages messages({data, size});
  imported::ImportOptions options;
  options.find_node = [](std::string_view name) -> std::optional<imported::SceneNode> {
    if (name.size() != 1) return std::nullopt;
    imported::SceneNode node;
    node.index = static_cast<uint8_t>(name[0]);
    node.name = name;
    return node;
  };
  wire::Bytes recording;
  const auto report =
      imported::import_states(messages, options, std::make_unique<record::MemorySink>(recording));
  if (!report) {
    FIRE3DV_ASSERT(!report.error().message.empty());
    return 0;
  }
  FIRE3DV_ASSERT(report->frames > 0 && !report->nodes.empty() && report->first_ns <= report->last_ns);
  auto playback = record::Playback::open(std::make_unique<record::MemorySource>(std::move(recording)));
  FIRE3DV_ASSERT(playback.ok());
  wire::Decoder decoder;
  record::Played played;
  uint64_t frames = 0;
  int64_t before_ns = -1;
  playback->rewind();
  while (playback->next(played) == record::Playback::Step::played) {
    if (played.kind != record::Played::Kind::pose) continue;
    const auto message = decoder.decode(played.message);
    FIRE3DV_ASSERT(message.ok());
    const auto& frame = std::get<wire::PoseFrameView>(*message);
    FIRE3DV_ASSERT(frame.header.sim_time_ns > before_ns && frame.poses.size() == report->nodes.size());
    before_ns = frame.header.sim_time_ns;
    ++frames;
  }
  FIRE3DV_ASSERT(frames == report->frames && playback->refused() == 0);
  return 0;
}
