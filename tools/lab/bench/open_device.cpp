#include "tools/lab/bench/open_device.h"

#include <cstdio>

namespace fire3dv::bench {

Result<OpenDevice> open_device(const DrawOptions& options) {
  gpu::InstanceOptions instance_options;
  instance_options.validation = options.validation;
  Result<std::unique_ptr<gpu::Instance>> instance = gpu::Instance::create(instance_options);
  if (!instance) return instance.error();
  OpenDevice open;
  open.instance = std::move(*instance);
  const std::vector<gpu::DeviceReport> reports = gpu::report_devices(open.instance->handle());
  const Result<gpu::DeviceChoice> choice =
      gpu::choose_device(reports, options.device, gpu::graphics_vendors_present());
  if (!choice) return choice.error();
  for (const std::string& note : choice->notes)
    std::fprintf(stderr, "fire3dv-bench: device: %s\n", note.c_str());
  std::fprintf(stderr, "fire3dv-bench: device %s\n", gpu::describe(reports[choice->index]).c_str());
  Result<std::unique_ptr<gpu::Device>> device =
      gpu::Device::create(*open.instance, choice->index, false, async_compute(options));
  if (!device) return device.error();
  open.device = std::move(*device);
  return open;
}

Result<void> OpenDevice::finish() {
  device.reset();
  if (const uint64_t messages = instance->validation_messages())
    return Error{std::to_string(messages) + " validation messages"};
  return {};
}

}  // namespace fire3dv::bench
