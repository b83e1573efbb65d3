// Sink that drops all frames. For benchmarks, and for runs that only show a window.
#pragma once

#include <cstdint>

#include "renderer/sinks/frame.h"

namespace fire3dv::sinks {

class NullSink final : public FrameSink {
 public:
  Result<void> consume(FrameImage&&) override {
    ++frames_consumed_;
    return {};
  }
  Result<void> finish() override { return {}; }
  uint64_t frames_consumed() const { return frames_consumed_; }

 private:
  uint64_t frames_consumed_ = 0;
};

}  // namespace fire3dv::sinks
