// Vulkan device of a benchmark run.
#pragma once

#include <memory>

#include "renderer/gpu/device/device.h"
#include "tools/lab/bench/frames/frame_options.h"

namespace fire3dv::bench {

struct OpenDevice {
  std::unique_ptr<gpu::Instance> instance;
  std::unique_ptr<gpu::Device> device;

  // Returns an error when validation was on and has reported a problem.
  Result<void> finish();
};

Result<OpenDevice> open_device(const DrawOptions& options);

}  // namespace fire3dv::bench
