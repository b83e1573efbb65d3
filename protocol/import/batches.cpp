#include "protocol/import/batches.h"

#include <algorithm>
#include <utility>

#include "base/plural.h"
#include "base/text.h"

namespace fire3dv::imported {
namespace {

constexpr size_t kMaxReasons = 50;
constexpr int64_t kMaxTimeNs = int64_t{1} << 62;  // 2116; recordings hold no later time
// 1 day. Where all stamps are later, the clock does not begin at 0: a stamp of 0 is none.
constexpr int64_t kMaxSimulatorStartNs = 86'400'000'000'000;

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

Result<void> BatchReader::rewind() {
  times_.resize(source_->topics().size());
  return source_->rewind(topics_);
}

bool BatchReader::choose_clocks() {
  is_without_stamps_ = std::none_of(times_.begin(), times_.end(), [](const TopicTimes& times) {
    return times.has_stamps() && !times.is_static;
  });
  bool has_changed = false;
  for (TopicTimes& times : times_) {
    Clock clock = Clock::stamps;
    if (is_without_stamps_ || (times.has_zero && !times.has_stamps() && !times.is_static))
      clock = Clock::log_times;
    else if (times.has_zero && !times.is_static && times.first_stamp_ns > kMaxSimulatorStartNs)
      clock = Clock::stamps_but_zero;
    has_changed = has_changed || clock != times.clock;
    times.clock = clock;
  }
  return has_changed;
}

std::vector<std::string> BatchReader::clock_notes() const {
  if (!is_without_stamps_) return {};
  return {"the messages have no stamps: log times count"};
}

std::vector<std::string> BatchReader::clock_warnings() const {
  std::vector<std::string> sentences;
  if (is_without_stamps_) return sentences;
  for (size_t i = 0; i < times_.size(); ++i)
    if (times_[i].clock == Clock::log_times)
      sentences.push_back("the messages of topic " + quote(source_->topics()[i].name) +
                          " have no stamps: their log times count");
  return sentences;
}

std::optional<int64_t> BatchReader::time_of(int64_t stamp_ns, const SourceMessage& raw, Faults& faults,
                                            const std::string& what, const std::string& detail) {
  TopicTimes& times = times_[raw.topic];
  times.is_static = batch_.is_static;
  if (stamp_ns == 0)
    times.has_zero = true;
  else if (stamp_ns > 0)
    times.first_stamp_ns = std::min(times.first_stamp_ns, stamp_ns);
  if (stamp_ns == 0 && times.clock == Clock::stamps_but_zero) {
    faults.add(batch_, what, "it has no stamp, but others of its topic have one", detail);
    return std::nullopt;
  }
  if (times.clock == Clock::log_times)
    stamp_ns = static_cast<int64_t>(std::min<uint64_t>(raw.log_time_ns, kMaxTimeNs));
  if (stamp_ns < 0 || stamp_ns >= kMaxTimeNs - kTimeOffsetNs) {
    faults.add(batch_, what, "its time is before 1970 or after 2116", detail);
    return std::nullopt;
  }
  return stamp_ns + kTimeOffsetNs;
}

void BatchReader::read_transforms(const SourceMessage& raw, Faults& faults) {
  if (Result<void> decoded = decode(*batch_.topic, raw.message, batch_.transforms); !decoded) {
    batch_.transforms.clear();
    faults.add(batch_, "message", decoded.error().message, "");
    return;
  }
  std::erase_if(batch_.transforms, [&](TransformSample& sample) {
    const std::optional<int64_t> time =
        time_of(sample.stamp_ns, raw, faults, "transform", "frame " + quote(sample.child));
    if (time) sample.stamp_ns = *time;
    return !time;
  });
}

void BatchReader::read_joints(const SourceMessage& raw, Faults& faults) {
  JointState state;
  if (Result<void> decoded = decode(*batch_.topic, raw.message, state); !decoded) {
    faults.add(batch_, "message", decoded.error().message, "");
    return;
  }
  const std::optional<int64_t> time = time_of(state.stamp_ns, raw, faults, "message", "");
  if (!time || state.positions.empty()) return;
  state.stamp_ns = *time;
  batch_.joints = std::move(state);
}

Result<const Batch*> BatchReader::next(Faults& faults) {
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
  if (content_of(topic) == Content::transforms)
    read_transforms(raw, faults);
  else
    read_joints(raw, faults);
  return &batch_;
}

}  // namespace fire3dv::imported
