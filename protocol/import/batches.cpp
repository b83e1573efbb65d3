#include "protocol/import/batches.h"

#include <algorithm>
#include <utility>

#include "base/plural.h"
#include "base/text.h"

namespace fire3dv::imported {
namespace {

constexpr size_t kMaxReasons = 50;
constexpr int64_t kMaxTimeNs = int64_t{1} << 62;  // 2116; recordings hold no later time

}  // namespace

void Faults::add(const Batch& batch, const std::string& what, const std::string& reason,
                 const std::string& detail) {
  const std::string key =
      what + (batch.topic ? " of topic " + quote(batch.topic->name) : std::string()) + "\n" + reason;
  const auto known = seen_.find(key);
  if (known == seen_.end() && seen_.size() >= kMaxReasons) {
    ++others_;
    return;
  }
  Seen& seen = seen_[key];
  if (++seen.count == 1)
    seen.first = "message " + std::to_string(batch.number) + (detail.empty() ? "" : ", " + detail);
}

std::vector<std::string> Faults::sentences() const {
  std::vector<std::string> sentences;
  for (const auto& [key, seen] : seen_) {
    const size_t end = key.find('\n'), noun = key.find(' ');
    sentences.push_back(counted(seen.count, key.substr(0, std::min(noun, end))) +
                        (noun < end ? key.substr(noun, end - noun) : std::string()) +
                        (seen.count == 1 ? " is left out: " : " are left out: ") + key.substr(end + 1) +
                        (seen.count == 1 ? " (" : " (first: ") + seen.first + ")");
  }
  if (others_ != 0) sentences.push_back(counted(others_, "value") + " more are left out, for other reasons");
  return sentences;
}

Result<BatchReader> BatchReader::open(MessageSource& source) {
  BatchReader reader(source);
  for (size_t i = 0; i < source.topics().size(); ++i) {
    if (content_of(source.topics()[i]) == Content::other) continue;
    if (Result<void> can = check_encoding(source.topics()[i]); can)
      reader.topics_.push_back(i);
    else
      reader.unreadable_.push_back(can.error().message);
  }
  if (!reader.topics_.empty()) return reader;
  if (!reader.unreadable_.empty()) return Error{quote(source.name()) + ": " + reader.unreadable_.front()};
  return Error{
      quote(source.name()) +
      " has no transforms and no joint states: record /tf, /tf_static and /joint_states of ROS 2, or "
      "foxglove.FrameTransform"};
}

Result<void> BatchReader::rewind(bool uses_log_times) {
  uses_log_times_ = uses_log_times;
  return source_->rewind(topics_);
}

std::optional<int64_t> BatchReader::time_of(int64_t stamp_ns, uint64_t log_time_ns) const {
  if (uses_log_times_) stamp_ns = static_cast<int64_t>(std::min<uint64_t>(log_time_ns, kMaxTimeNs));
  if (stamp_ns < 0 || stamp_ns >= kMaxTimeNs - kTimeOffsetNs) return std::nullopt;
  return stamp_ns + kTimeOffsetNs;
}

Result<const Batch*> BatchReader::next(Faults& faults) {
  constexpr const char* kNoTime = "its time is before 1970 or after 2116";
  while (true) {
    Result<std::optional<SourceMessage>> message = source_->next();
    if (!message) return message.error();
    if (!*message) return nullptr;
    const SourceMessage& raw = **message;
    const Topic& topic = source_->topics()[raw.topic];
    batch_.topic = &topic;
    batch_.number = raw.number;
    batch_.is_static = topic.name.ends_with("tf_static");
    batch_.transforms.clear();
    batch_.joints.reset();
    if (content_of(topic) == Content::transforms) {
      if (Result<void> decoded = decode(topic, raw.message, batch_.transforms); !decoded) {
        faults.add(batch_, "message", decoded.error().message, "");
        continue;
      }
      std::erase_if(batch_.transforms, [&](TransformSample& sample) {
        const std::optional<int64_t> time = time_of(sample.stamp_ns, raw.log_time_ns);
        if (time)
          sample.stamp_ns = *time;
        else
          faults.add(batch_, "transform", kNoTime, "frame " + quote(sample.child));
        return !time;
      });
      if (batch_.transforms.empty()) continue;
    } else {
      JointState state;
      if (Result<void> decoded = decode(topic, raw.message, state); !decoded) {
        faults.add(batch_, "message", decoded.error().message, "");
        continue;
      }
      const std::optional<int64_t> time = time_of(state.stamp_ns, raw.log_time_ns);
      if (!time) faults.add(batch_, "message", kNoTime, "");
      if (!time || state.positions.empty()) continue;
      state.stamp_ns = *time;
      batch_.joints = std::move(state);
    }
    return &batch_;
  }
}

}  // namespace fire3dv::imported
