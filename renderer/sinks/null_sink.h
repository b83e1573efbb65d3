// Sink that drops all frames. For benchmarks, and for runs that only show a window.
#pragma once

#include <cstdint>

#include "renderer/sinks/frame.h"

namespace fire3dv::sinks {

class NullSink final : public FrameSink {
 public:
  Result<void> take(FrameImage&&) override {
    ++frames_taken_;
    return {};
  }
  Result<void> finish() override { return {}; }
  uint64_t frames_taken() const { return frames_taken_; }

 private:
  uint64_t frames_taken_ = 0;
};

}  // namespace fire3dv::sinks
