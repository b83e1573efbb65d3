// Monitor of incomplete frames of one stream: compares frames whose first part arrived with frames that
// became whole, in windows of two seconds, and reports a change with hysteresis. No I/O; the caller passes
// the time.
#pragma once

#include <algorithm>
#include <cstdint>

namespace fire3dv::app {

class FrameLossMonitor {
 public:
  enum class Change {
    none,
    lossy,  // many frames come incomplete
    whole,  // nearly all are whole again
  };

  // opened, completed: counters of stream::FrameAssembler. Frames of one message are not counted there: they
  // are whole or absent.
  Change update(uint64_t opened, uint64_t completed, int64_t now_ns) {
    if (since_ns_ == 0 || opened < opened_ || completed < completed_) {  // first call, or a new run
      begin(opened, completed, now_ns);
      return Change::none;
    }
    if (now_ns - since_ns_ < kWindowNs) return Change::none;
    const uint64_t begun = opened - opened_;
    const uint64_t missing = begun - std::min(begun, completed - completed_);
    const double seconds = static_cast<double>(now_ns - since_ns_) * 1e-9;
    begin(opened, completed, now_ns);
    if (!is_lossy_ && missing >= kLeastMissing && missing * 4 > begun) {
      is_lossy_ = true;
      missing_per_s_ = static_cast<double>(missing) / seconds;
      begun_per_s_ = static_cast<double>(begun) / seconds;
      return Change::lossy;
    }
    if (!is_lossy_ || missing * 20 > begun) return Change::none;
    is_lossy_ = false;
    return begun != 0 ? Change::whole : Change::none;  // nothing arrives: the stream has stalled
  }

  bool is_lossy() const { return is_lossy_; }
  // Of the window that was reported as lossy.
  double missing_per_s() const { return missing_per_s_; }
  double begun_per_s() const { return begun_per_s_; }

 private:
  static constexpr int64_t kWindowNs = 2'000'000'000;
  static constexpr uint64_t kLeastMissing = 10;

  void begin(uint64_t opened, uint64_t completed, int64_t now_ns) {
    opened_ = opened;
    completed_ = completed;
    since_ns_ = now_ns;
  }

  uint64_t opened_ = 0, completed_ = 0;
  int64_t since_ns_ = 0;
  bool is_lossy_ = false;
  double missing_per_s_ = 0, begun_per_s_ = 0;
};

}  // namespace fire3dv::app
