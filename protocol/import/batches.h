// Transforms and joint states of a recording, message by message, with one time base and the faults that were
// left out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "protocol/import/files/message_source.h"
#include "protocol/import/messages/messages.h"

namespace fire3dv::imported {

// Values of one message. Times are nanoseconds of the recording's clock, counted from 1: 0 is no time.
struct Batch {
  const Topic* topic = nullptr;
  uint64_t number = 0;     // of the topic's messages, from 1
  bool is_static = false;  // valid at all times, as on /tf_static
  std::vector<TransformSample> transforms;
  std::optional<JointState> joints;
};
constexpr int64_t kTimeOffsetNs = 1;  // batch time = stamp + offset

// Counts of what was left out, by topic and reason.
class Faults {
 public:
  // what: noun, such as "transform". detail: of the first one, such as its frame; may be empty.
  void add(const Batch& batch, const std::string& what, const std::string& reason, const std::string& detail);
  // One sentence for each topic and reason.
  std::vector<std::string> sentences() const;

 private:
  struct Seen {
    uint64_t count = 0;
    std::string first;
  };
  std::map<std::string, Seen> seen_;  // by topic, noun and reason
  uint64_t others_ = 0;               // beyond the limit on reasons
};

class BatchReader {
 public:
  // source: borrowed. Fails for a recording without transforms and joint states that can be read.
  static Result<BatchReader> open(MessageSource& source);

  // Begins at the first message.
  Result<void> rewind();
  // Next message, without values if nothing of it can be used; nullptr at the end. Valid until the next call.
  // faults: of messages that cannot be decoded, and of times that are missing, before 1970 or after 2116.
  Result<const Batch*> next(Faults& faults);

  // After a reading: a topic without stamps gets the log times from the next rewind() on, and so do static
  // transforms if no other topic has stamps. Returns true if another reading gives other times.
  bool choose_clocks();
  // Sentences on topics with log times: for all topics, or beside topics with stamps.
  std::vector<std::string> clock_notes() const, clock_warnings() const;

  MessageSource& source() { return *source_; }
  // Topics of these contents that have no decoder, one sentence each.
  const std::vector<std::string>& unreadable() const { return unreadable_; }

 private:
  explicit BatchReader(MessageSource& source) : source_(&source) {}
  // Nothing for a time that cannot be used, which becomes a fault. what: noun, such as "transform".
  std::optional<int64_t> time_of(int64_t stamp_ns, const SourceMessage& raw, Faults& faults,
                                 const std::string& what, const std::string& detail);
  void read_transforms(const SourceMessage& raw, Faults& faults);
  void read_joints(const SourceMessage& raw, Faults& faults);

  enum class Clock : uint8_t { stamps, stamps_but_zero, log_times };
  struct TopicTimes {
    bool is_static = false, has_zero = false;
    int64_t first_stamp_ns = INT64_MAX;  // without zeros
    Clock clock = Clock::stamps;
    bool has_stamps() const { return first_stamp_ns != INT64_MAX; }
  };

  MessageSource* source_;
  std::vector<size_t> topics_;
  std::vector<std::string> unreadable_;
  std::vector<TopicTimes> times_;  // of each topic of the source
  bool is_without_stamps_ = false;
  Batch batch_;
};

}  // namespace fire3dv::imported
