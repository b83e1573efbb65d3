#include "renderer/gpu/selection/cuda_filter.h"

#include <algorithm>

#include "base/text.h"
#include "renderer/gpu/selection/driver_names.h"

namespace fire3dv::gpu {
namespace {

bool is_nvidia_gpu(const DeviceReport& report) {
  return report.vendor_id == kNvidia && report.type != DeviceType::software;
}

std::string without_dashes(std::string uuid) {
  uuid.erase(std::remove(uuid.begin(), uuid.end(), '-'), uuid.end());
  return uuid;
}

std::string visible_text(const HostFacts& host) {
  return host.cuda_visible_devices ? "CUDA_VISIBLE_DEVICES=" + printable_text(*host.cuda_visible_devices, 120)
                                   : "";
}

void add_named(const std::vector<DeviceReport>& reports, const std::string& uuid_beginning,
               std::vector<uint32_t>& indices) {
  for (const DeviceReport& report : reports) {
    if (is_nvidia_gpu(report) && without_dashes(report.uuid).starts_with(uuid_beginning) &&
        std::find(indices.begin(), indices.end(), report.index) == indices.end())
      indices.push_back(report.index);
  }
}

}  // namespace

bool has_uuid(const std::vector<DeviceReport>& reports, std::string_view uuid) {
  return std::any_of(reports.begin(), reports.end(), [&](const auto& report) { return report.uuid == uuid; });
}

Result<std::string> uuid_of_cuda_device(uint32_t ordinal, const HostFacts& host) {
  const CudaDevices cuda = host.cuda_devices ? host.cuda_devices() : CudaDevices{{}, "there is no CUDA"};
  if (!cuda.failure.empty())
    return Error{cuda.failure + ": name the device by its index, name, uuid: or pci: (see --list-devices)"};
  const std::string visible = visible_text(host);
  if (ordinal >= cuda.devices.size()) {
    std::string text =
        "CUDA has " + (cuda.devices.empty() ? std::string("no device") : "these devices alone:");
    for (size_t i = 0; i < cuda.devices.size(); ++i)
      text +=
          "\n  cuda:" + std::to_string(i) + ": " + cuda.devices[i].name + ", uuid:" + cuda.devices[i].uuid;
    return Error{text + (visible.empty() ? "" : (cuda.devices.empty() ? " (" : "\n(") + visible + ")")};
  }
  const CudaDevice& device = cuda.devices[ordinal];
  if (device.is_mig)
    return Error{device.name +
                 " is a MIG instance, on which NVIDIA's driver offers no Vulkan: use a GPU "
                 "without MIG (sudo nvidia-smi -mig 0)"};
  return device.uuid;
}

bool CudaFilter::hides(const DeviceReport& report) const {
  return is_active && is_nvidia_gpu(report) &&
         std::find(indices.begin(), indices.end(), report.index) == indices.end();
}

CudaFilter filter_by_cuda(const std::vector<DeviceReport>& reports, const HostFacts& host) {
  CudaFilter filter;
  if (!host.cuda_visible_devices) return filter;
  if (std::count_if(reports.begin(), reports.end(), is_nvidia_gpu) < 2) return filter;
  const std::string without_effect = " has no effect on the choice of a device: ";
  const CudaVisible first = parse_cuda_visible(*host.cuda_visible_devices);
  switch (first.kind) {
    case CudaVisible::Kind::none:
      filter.note = visible_text(host) + without_effect + "it names none";
      return filter;
    case CudaVisible::Kind::mig:
      filter.note = visible_text(host) + without_effect + "a MIG instance has no Vulkan";
      return filter;
    case CudaVisible::Kind::uuid:
      for (std::string_view rest = *host.cuda_visible_devices; !rest.empty();) {
        const CudaVisible entry = parse_cuda_visible(rest);
        if (entry.kind != CudaVisible::Kind::uuid) break;
        add_named(reports, entry.uuid, filter.indices);
        const size_t comma = rest.find(',');
        rest = comma == std::string_view::npos ? std::string_view() : rest.substr(comma + 1);
      }
      break;
    case CudaVisible::Kind::ordinal:
      const CudaDevices cuda = host.cuda_devices ? host.cuda_devices() : CudaDevices{{}, "there is no CUDA"};
      if (!cuda.failure.empty()) {
        filter.note = visible_text(host) + without_effect + cuda.failure;
        return filter;
      }
      for (const CudaDevice& device : cuda.devices) {
        if (!device.is_mig) add_named(reports, without_dashes(device.uuid), filter.indices);
      }
      break;
  }
  if (filter.indices.empty()) {
    filter.note = visible_text(host) + without_effect + "no Vulkan driver serves what it names";
    return filter;
  }
  filter.is_active = true;
  filter.note = visible_text(host) + " chooses device " + std::to_string(filter.indices[0]) +
                (filter.indices.size() > 1 ? " first" : "") + "; --device chooses another";
  return filter;
}

}  // namespace fire3dv::gpu
