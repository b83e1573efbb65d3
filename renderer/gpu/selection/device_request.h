// A request of --device: an index, part of a name, or a form with a prefix that is never part of a name:
// cuda:N, uuid:HEX, pci:[DDDD:]BB:DD.F.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/error.h"
#include "renderer/gpu/device/device_report.h"

namespace fire3dv::gpu {

struct DeviceRequest {
  enum class Kind { index, name, uuid, pci, cuda };
  Kind kind = Kind::name;
  uint32_t number = 0;  // index; ordinal of CUDA
  std::string text;     // name in lower case; UUID, PCI address as in DeviceReport
};

// Errors start with what is wrong, without the option's name.
Result<DeviceRequest> parse_device_request(std::string_view text);

// cuda: never true, its UUID must be looked up first.
bool matches(const DeviceRequest& request, const DeviceReport& report);

}  // namespace fire3dv::gpu
