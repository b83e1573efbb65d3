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

  // Begins at the first message. uses_log_times: instead of the stamps of headers, for recordings without
  // them.
  Result<void> rewind(bool uses_log_times);
  // Next message with values; nullptr at the end. Valid until the next call. faults: of messages that cannot
  // be decoded and of times before 1970 or after 2116.
  Result<const Batch*> next(Faults& faults);

  MessageSource& source() { return *source_; }
  // Topics of these contents that have no decoder, one sentence each.
  const std::vector<std::string>& unreadable() const { return unreadable_; }

 private:
  explicit BatchReader(MessageSource& source) : source_(&source) {}
  std::optional<int64_t> time_of(int64_t stamp_ns, uint64_t log_time_ns) const;

  MessageSource* source_;
  std::vector<size_t> topics_;
  std::vector<std::string> unreadable_;
  bool uses_log_times_ = false;
  Batch batch_;
};

}  // namespace fire3dv::imported
