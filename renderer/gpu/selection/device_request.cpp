#include "renderer/gpu/selection/device_request.h"

#include <charconv>
#include <cstdio>
#include <optional>
#include <system_error>

#include "base/text.h"

namespace fire3dv::gpu {
namespace {

std::optional<uint32_t> parse_number(std::string_view text, int base, size_t max_digits) {
  uint32_t number = 0;
  const auto [end, result] = std::from_chars(text.data(), text.data() + text.size(), number, base);
  if (text.empty() || text.size() > max_digits || result != std::errc() || end != text.data() + text.size())
    return std::nullopt;
  return number;
}

// The form of DeviceReport::uuid; dashes and NVIDIA's "GPU-" are optional.
std::optional<std::string> parse_uuid(std::string text) {
  if (text.starts_with("gpu-")) text.erase(0, 4);
  std::string uuid;
  size_t digits = 0;
  for (const char c : text) {
    if (c == '-') continue;
    if ((c < '0' || c > '9') && (c < 'a' || c > 'f')) return std::nullopt;
    if (digits == 8 || digits == 12 || digits == 16 || digits == 20) uuid += '-';
    uuid += c;
    ++digits;
  }
  if (digits != size_t{2} * VK_UUID_SIZE) return std::nullopt;
  return uuid;
}

// The form of DeviceReport::pci_address. The domain may be left out, or have the eight digits of nvidia-smi.
std::optional<std::string> parse_pci(std::string_view text) {
  const size_t dot = text.rfind('.');
  if (dot == std::string_view::npos) return std::nullopt;
  const size_t device_colon = text.rfind(':', dot);
  if (device_colon == std::string_view::npos) return std::nullopt;
  const std::string_view front = text.substr(0, device_colon);
  const size_t bus_colon = front.rfind(':');
  const bool has_domain = bus_colon != std::string_view::npos;
  const auto domain = has_domain ? parse_number(front.substr(0, bus_colon), 16, 8) : 0u;
  const auto bus = parse_number(has_domain ? front.substr(bus_colon + 1) : front, 16, 2);
  const auto device = parse_number(text.substr(device_colon + 1, dot - device_colon - 1), 16, 2);
  const auto function = parse_number(text.substr(dot + 1), 16, 1);
  if (!domain || !bus || !device || !function || *device > 0x1f || *function > 7) return std::nullopt;
  char address[24];
  std::snprintf(address, sizeof address, "%04x:%02x:%02x.%x", *domain, *bus, *device, *function);
  return address;
}

}  // namespace

Result<DeviceRequest> parse_device_request(std::string_view text) {
  const std::string lower = lower_case(std::string(text));
  const size_t colon = lower.find(':');
  const std::string prefix = colon == std::string::npos ? "" : lower.substr(0, colon);
  const std::string rest = colon == std::string::npos ? "" : lower.substr(colon + 1);
  DeviceRequest request;
  if (prefix == "cuda") {
    const auto ordinal = parse_number(rest, 10, 6);
    if (!ordinal) return Error{"cuda: needs CUDA's number of a device, such as cuda:0"};
    request.kind = DeviceRequest::Kind::cuda;
    request.number = *ordinal;
  } else if (prefix == "uuid") {
    const auto uuid = parse_uuid(rest);
    if (!uuid) return Error{"uuid: needs the 32 hexadecimal digits that --list-devices prints"};
    request.kind = DeviceRequest::Kind::uuid;
    request.text = *uuid;
  } else if (prefix == "pci") {
    const auto address = parse_pci(rest);
    if (!address) return Error{"pci: needs an address such as pci:0000:65:00.0 (see --list-devices)"};
    request.kind = DeviceRequest::Kind::pci;
    request.text = *address;
  } else if (const auto index = parse_number(lower, 10, 10)) {
    request.kind = DeviceRequest::Kind::index;
    request.number = *index;
  } else {
    request.text = lower;
  }
  return request;
}

bool matches(const DeviceRequest& request, const DeviceReport& report) {
  switch (request.kind) {
    case DeviceRequest::Kind::index:
      return report.index == request.number;
    case DeviceRequest::Kind::name:
      return lower_case(report.name).find(request.text) != std::string::npos;
    case DeviceRequest::Kind::uuid:
      return report.uuid == request.text;
    case DeviceRequest::Kind::pci:
      return report.pci_address == request.text;
    case DeviceRequest::Kind::cuda:
      return false;
  }
  return false;
}

}  // namespace fire3dv::gpu
