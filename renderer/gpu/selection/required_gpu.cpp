#include "renderer/gpu/selection/required_gpu.h"

#include <algorithm>
#include <memory>
#include <string>

#include "renderer/gpu/device/vk.h"

namespace fire3dv::gpu {

Result<void> check_required_gpu(const std::vector<DeviceReport>& reports, std::string_view device,
                                std::string_view devices, const HostFacts& host) {
  const bool has_gpu = std::any_of(reports.begin(), reports.end(), [](const DeviceReport& report) {
    return report.usable() && report.type != DeviceType::software;
  });
  if (!has_gpu) {
    Result<DeviceChoice> best = choose_device(reports, "", host);
    if (!best) return Error{"--require-gpu: " + best.error().message};
    std::string text = "--require-gpu: no GPU can draw here";
    for (const std::string& note : best->notes) text += "; " + note;
    return Error{text + "; fire3dv --list-devices lists the devices"};
  }
  std::vector<DeviceChoice> choices;
  if (devices.empty()) {
    Result<DeviceChoice> choice = choose_device(reports, device, host);
    if (choice) choices.push_back(std::move(*choice));
  } else if (Result<std::vector<DeviceChoice>> several = choose_devices(reports, devices, host)) {
    choices = std::move(*several);
  }
  for (const DeviceChoice& choice : choices) {
    if (reports[choice.index].type != DeviceType::software) continue;
    return Error{"--require-gpu: " + reports[choice.index].name +
                 " was requested, which is a software device: request a GPU"};
  }
  return {};
}

Result<void> check_required_gpu(std::string_view device, std::string_view devices) {
  Result<std::unique_ptr<Instance>> instance = Instance::create({});
  if (!instance) return Error{"--require-gpu: " + instance.error().message};
  return check_required_gpu(report_devices((*instance)->handle()), device, devices, host_facts());
}

}  // namespace fire3dv::gpu
