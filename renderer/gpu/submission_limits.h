// Time limits of submissions. Vulkan cannot end a submission that runs. So shaders and draws of content test
// a word of their image, and this class sets it at the limit: the rest of the content is not drawn, the
// submission soon ends, and its image is dropped.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "renderer/gpu/device/device.h"

namespace fire3dv::gpu {

class SubmissionLimits {
 public:
  explicit SubmissionLimits(Device& device) : device_(device) {}
  ~SubmissionLimits();
  SubmissionLimits(const SubmissionLimits&) = delete;
  SubmissionLimits& operator=(const SubmissionLimits&) = delete;

  // What a submission that reaches its limit is blamed on: the content that it shows, as all submissions
  // behind it, which end as well; or its own image.
  enum class Cause : uint8_t { content, image };
  // Of later submissions; nullopt (default): they run to their end.
  void set(std::optional<int64_t> limit_ns, Cause cause = Cause::content) {
    limit_ns_ = limit_ns;
    cause_ = cause;
  }
  bool are_set() const { return limit_ns_.has_value(); }

  // A submission was made. words: in mapped memory that stays until its timeline value is completed; not 0
  // ends its draws.
  void submitted(uint64_t value, std::span<uint64_t* const> words);
  // Ends a submission that nobody waits for any more, with or without a limit. words: as of submitted().
  void end(uint64_t value, std::span<uint64_t* const> words);
  // The memory of the words of this submission, which is done, is about to be used again.
  void release(uint64_t value);
  // True if the submission has reached its limit: its image lacks content.
  bool has_ended_early(uint64_t value) const;
  // Run time of the last submission that reached its limit because of its content; once.
  std::optional<int64_t> take_ended_early();

 private:
  struct Running {
    uint64_t value = 0;
    int64_t limit_ns = 0;
    Cause cause = Cause::content;
    std::vector<uint64_t*> words;
  };
  void watch(const std::stop_token& stop);
  void end_now(int64_t ran_ns);         // requires mutex_
  void note_early_end(uint64_t value);  // requires mutex_

  Device& device_;
  std::optional<int64_t> limit_ns_;
  Cause cause_ = Cause::content;
  uint64_t pipelines_ = 0;  // pipelines_begun() of the last submission

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<Running> running_;      // oldest first
  std::deque<uint64_t> early_ends_;  // of the last submissions
  std::optional<int64_t> ended_ns_;
  std::jthread thread_;  // from the first limited submission on; last: it uses the members above
};

}  // namespace fire3dv::gpu
