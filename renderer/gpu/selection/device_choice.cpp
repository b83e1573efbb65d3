#include "renderer/gpu/selection/device_choice.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <span>

#include "base/text.h"
#include "base/words.h"
#include "renderer/gpu/device/driver_files.h"
#include "renderer/gpu/selection/cuda_filter.h"
#include "renderer/gpu/selection/device_request.h"
#include "renderer/gpu/selection/driver_names.h"

namespace fire3dv::gpu {
namespace {

std::string listing(const std::vector<DeviceReport>& reports) {
  std::string text;
  for (const DeviceReport& report : reports)
    text += "\n  " + describe(report) + "; " + describe_identity(report);
  return text;
}

// Where an unusable device's driver is of an old Mesa: how to update it. Starts with a separator.
std::string mesa_update(std::span<const DeviceReport> reports) {
  for (const DeviceReport& report : reports) {
    const std::string version = mesa_version(report.driver);
    int major = 0;
    std::from_chars(version.data(), version.data() + version.size(), major);
    if (report.usable() || major == 0 || major >= kGoodMesa) continue;
    return "\nMesa " + version + " is too old, " + std::to_string(kGoodMesa) +
           " works. On Debian 12: sudo apt install -t bookworm-backports mesa-vulkan-drivers "
           "(docs/install.md "
           "says how to add backports). Elsewhere: sudo apt-get update && sudo apt-get install "
           "mesa-vulkan-drivers. Where FIRE-3DV is from a wheel: install the file fire3dv_cpu-*.whl, too";
  }
  return "";
}

// Preference among device types; a lower value is better.
int rank(DeviceType type) {
  switch (type) {
    case DeviceType::discrete:
      return 0;
    case DeviceType::integrated:
      return 1;
    case DeviceType::virtual_gpu:
      return 2;
    case DeviceType::other:
      return 3;
    case DeviceType::software:
      return 4;
  }
  return 5;
}

}  // namespace

std::vector<uint32_t> graphics_vendors_present(const std::filesystem::path& pci_devices) {
  auto read_hex = [](const std::filesystem::path& file) {
    uint32_t value = 0;
    std::ifstream(file) >> std::hex >> value;
    return value;
  };
  std::vector<uint32_t> vendors;
  std::error_code ignored;  // without /sys the list stays empty
  for (const auto& entry : std::filesystem::directory_iterator(pci_devices, ignored)) {
    const uint32_t base_class = read_hex(entry.path() / "class") >> 16;
    const uint32_t vendor = read_hex(entry.path() / "vendor");
    constexpr uint32_t kDisplayController = 0x03;
    if (base_class == kDisplayController && vendor_name(vendor)) vendors.push_back(vendor);
  }
  std::sort(vendors.begin(), vendors.end());
  vendors.erase(std::unique(vendors.begin(), vendors.end()), vendors.end());
  return vendors;
}

HostFacts host_facts() {
  HostFacts host;
  host.vendors_present = graphics_vendors_present();
  if (const char* const visible = std::getenv("CUDA_VISIBLE_DEVICES")) host.cuda_visible_devices = visible;
  host.cuda_devices = [] { return read_cuda_devices(); };
  return host;
}

Result<DeviceChoice> choose_device(const std::vector<DeviceReport>& reports, std::string_view wanted,
                                   const HostFacts& host) {
  if (reports.empty()) {
    return Error{"no Vulkan device found: " +
                 driver_advice([](const char* name) { return std::getenv(name); })};
  }

  std::vector<const DeviceReport*> candidates;
  DeviceChoice choice;
  if (!wanted.empty()) {
    const std::string option = "--device " + std::string(wanted) + ": ";
    Result<DeviceRequest> request = parse_device_request(wanted);
    if (!request) return Error{option + request.error().message};
    if (request->kind == DeviceRequest::Kind::cuda) {
      Result<std::string> uuid = uuid_of_cuda_device(request->number, host);
      if (!uuid) return Error{option + uuid.error().message};
      request->kind = DeviceRequest::Kind::uuid;
      request->text = *uuid;
      if (!has_uuid(reports, *uuid))
        return Error{option + "CUDA's device " + std::to_string(request->number) + " has uuid:" + *uuid +
                     ", and no Vulkan driver serves it (in a container: NVIDIA_DRIVER_CAPABILITIES=all); "
                     "there are:" +
                     listing(reports)};
    }
    for (const DeviceReport& report : reports) {
      if (matches(*request, report)) candidates.push_back(&report);
    }
    if (candidates.empty()) return Error{option + "there is no such device; there are:" + listing(reports)};
    const bool any_usable =
        std::any_of(candidates.begin(), candidates.end(), [](auto* r) { return r->usable(); });
    if (!any_usable) {
      return Error{option + candidates[0]->name + " cannot be used, it lacks: " +
                   joined(candidates[0]->missing) + mesa_update({candidates[0], 1})};
    }
  } else {
    const CudaFilter cuda = filter_by_cuda(reports, host);
    if (!cuda.note.empty()) choice.notes.push_back(cuda.note);
    // In CUDA's order, before all others of their type.
    for (const uint32_t index : cuda.indices) candidates.push_back(&reports[index]);
    for (const DeviceReport& report : reports) {
      if (!cuda.hides(report)) candidates.push_back(&report);
    }
  }

  const DeviceReport* best = nullptr;
  for (const DeviceReport* candidate : candidates) {
    if (candidate->usable() && (!best || rank(candidate->type) < rank(best->type))) best = candidate;
  }
  if (!best)
    return Error{"no Vulkan device can be used; there are:" + listing(reports) + mesa_update(reports)};

  choice.index = best->index;
  if (best->type == DeviceType::software) {
    choice.notes.push_back(best->name + " is a software device: it draws on the CPU");
    for (uint32_t vendor : host.vendors_present) {
      const bool served =
          std::any_of(reports.begin(), reports.end(), [&](auto& r) { return r.vendor_id == vendor; });
      if (wanted.empty() && !served) {
        choice.notes.push_back(
            std::string("there is a GPU by ") + vendor_name(vendor) +
            ", but no Vulkan driver serves it: install its driver, or check its permissions");
      }
    }
  }
  if (wanted.empty()) {
    for (const DeviceReport& report : reports) {
      if (!report.usable() && rank(report.type) < rank(best->type)) {
        choice.notes.push_back(report.name + " was not taken: it lacks " + joined(report.missing));
      }
    }
  }
  return choice;
}

Result<std::vector<DeviceChoice>> choose_devices(const std::vector<DeviceReport>& reports,
                                                 std::string_view wanted, const HostFacts& host) {
  std::vector<DeviceChoice> choices;
  if (wanted == "all") {
    Result<DeviceChoice> best = choose_device(reports, "", host);
    if (!best) return best.error();
    choices.push_back(std::move(*best));
    const DeviceType type = reports[choices[0].index].type;
    const CudaFilter cuda = filter_by_cuda(reports, host);
    for (const DeviceReport& report : reports) {
      if (report.usable() && report.type == type && report.index != choices[0].index && !cuda.hides(report))
        choices.push_back({report.index, {}});
    }
    return choices;
  }
  for (size_t begin = 0; begin <= wanted.size();) {
    const size_t end = std::min(wanted.find(',', begin), wanted.size());
    const std::string_view one = wanted.substr(begin, end - begin);
    if (one.empty())
      return Error{"--devices " + std::string(wanted) +
                   ": name devices by index, part of the name, cuda:N, uuid: or pci:, separated by commas, "
                   "such as 0,1, or all"};
    Result<DeviceChoice> choice = choose_device(reports, one, {{}, {}, host.cuda_devices});
    if (!choice) return Error{"--devices " + std::string(wanted) + ": " + choice.error().message};
    choices.push_back(std::move(*choice));
    begin = end + 1;
  }
  return choices;
}

}  // namespace fire3dv::gpu
