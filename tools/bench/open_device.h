// The device that is measured on.
#pragma once

#include <memory>

#include "renderer/gpu/device.h"
#include "tools/bench/frame_options.h"

namespace fire3dv::bench {

struct OpenDevice {
  std::unique_ptr<gpu::Instance> instance;
  std::unique_ptr<gpu::Device> device;

  // An error where validation was on and has found something.
  Result<void> finish();
};

Result<OpenDevice> open_device(const DrawOptions& options);

}  // namespace fire3dv::bench
