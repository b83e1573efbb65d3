#include "renderer/gpu/device/device_choice.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "base/text.h"
#include "renderer/gpu/device/device_features.h"
#include "renderer/gpu/device/driver_files.h"
#include "renderer/gpu/device/queues.h"

namespace fire3dv::gpu {
namespace {

constexpr uint32_t kMaxThreads = 256;  // threads of a workgroup in the shaders

DeviceType device_type(const VkPhysicalDeviceProperties& properties) {
  switch (properties.deviceType) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return DeviceType::discrete;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return DeviceType::integrated;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return DeviceType::virtual_gpu;
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return DeviceType::software;
    default:
      return DeviceType::other;
  }
}

std::string join(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

std::string listing(const std::vector<DeviceReport>& reports) {
  std::string text;
  for (const DeviceReport& report : reports)
    text += "\n  " + describe(report) + "; " + describe_identity(report);
  return text;
}

// Vendors of GPUs that can have a Vulkan driver. Display controllers of virtual machines and server consoles
// have none.
const char* vendor_name(uint32_t vendor_id) {
  switch (vendor_id) {
    case 0x10de:
      return "NVIDIA";
    case 0x1002:
      return "AMD";
    case 0x8086:
      return "Intel";
    default:
      return nullptr;
  }
}

constexpr const char* kVulkan13 = "Vulkan 1.3";
constexpr int kGoodMesa = 25;  // major version whose software driver has all that is required

// "22.3" of "llvmpipe Mesa 22.3.6 (LLVM 15.0.6)"; empty: another driver.
std::string mesa_version(const std::string& driver) {
  constexpr std::string_view kMesa = "Mesa ";
  const size_t at = driver.find(kMesa);
  if (at == std::string::npos) return "";
  const std::string rest = driver.substr(at + kMesa.size());
  const size_t minor = rest.find('.');
  if (minor == std::string::npos) return "";
  return rest.substr(0, rest.find_first_not_of("0123456789", minor + 1));
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
           "mesa-vulkan-drivers";
  }
  return "";
}

std::string pci_address_text(const VkPhysicalDevicePCIBusInfoPropertiesEXT& pci) {
  char text[40];
  std::snprintf(text, sizeof text, "%04x:%02x:%02x.%x", pci.pciDomain, pci.pciBus, pci.pciDevice,
                pci.pciFunction);
  return text;
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

const char* type_name(DeviceType type) {
  switch (type) {
    case DeviceType::discrete:
      return "discrete GPU";
    case DeviceType::integrated:
      return "integrated GPU";
    case DeviceType::virtual_gpu:
      return "virtual GPU";
    case DeviceType::software:
      return "software";
    case DeviceType::other:
      return "other";
  }
  return "other";
}

std::string uuid_text(std::span<const uint8_t, VK_UUID_SIZE> uuid) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (size_t i = 0; i < uuid.size(); ++i) {
    if (i == 4 || i == 6 || i == 8 || i == 10) text += '-';
    text += kDigits[uuid[i] >> 4];
    text += kDigits[uuid[i] & 15];
  }
  return text;
}

DeviceReport report_device(VkPhysicalDevice device, uint32_t index) {
  VkPhysicalDevicePCIBusInfoPropertiesEXT pci{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PCI_BUS_INFO_PROPERTIES_EXT};
  VkPhysicalDeviceIDProperties id{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES};
  VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES, &id};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &driver};
  const bool has_pci = has_extension(device_extensions(device), VK_EXT_PCI_BUS_INFO_EXTENSION_NAME);
  if (has_pci) id.pNext = &pci;
  vkGetPhysicalDeviceProperties2(device, &properties);

  DeviceReport report;
  report.index = index;
  report.name = properties.properties.deviceName;
  report.driver = std::string(driver.driverName) + " " + driver.driverInfo;
  report.type = device_type(properties.properties);
  report.api_version = properties.properties.apiVersion;
  report.vendor_id = properties.properties.vendorID;
  report.uuid = uuid_text(id.deviceUUID);
  if (has_pci) report.pci_address = pci_address_text(pci);
  const VkSampleCountFlags samples = properties.properties.limits.framebufferColorSampleCounts &
                                     properties.properties.limits.framebufferDepthSampleCounts;
  for (uint32_t count : {2u, 4u, 8u, 16u}) {
    if (samples & count) report.max_samples = count;
  }
  if (report.api_version < VK_API_VERSION_1_3) {
    report.missing.push_back(kVulkan13);
    return report;  // an older driver does not know the feature structures below
  }

  DeviceFeatures features;
  vkGetPhysicalDeviceFeatures2(device, features.query_chain(device));
  report.missing = features.missing_required();
  const VkPhysicalDeviceLimits& limits = properties.properties.limits;
  if (std::min(limits.maxComputeWorkGroupInvocations, limits.maxComputeWorkGroupSize[0]) < kMaxThreads)
    report.missing.push_back("workgroups of " + std::to_string(kMaxThreads) + " threads");
  report.ray_query = features.has_ray_query();
  report.ray_tracing_pipeline = features.has_ray_tracing_pipeline();
  report.int64_atomics = features.vulkan12.shaderBufferInt64Atomics;
  // llvmpipe has the feature, but filters isotropically where shaders pass derivatives.
  report.anisotropy =
      features.core.features.samplerAnisotropy && driver.driverID != VK_DRIVER_ID_MESA_LLVMPIPE;
  report.multisample_storage = features.core.features.shaderStorageImageMultisample;
  report.visible_coverage = features.has_visible_coverage();
  report.dual_source_blend = features.core.features.dualSrcBlend;
  report.sorted_fragments = features.has_sorted_fragments();

  uint32_t family_count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(device, &family_count, nullptr);
  std::vector<VkQueueFamilyProperties> families(family_count);
  vkGetPhysicalDeviceQueueFamilyProperties(device, &family_count, families.data());
  const std::optional<QueueChoice> queues = choose_queues(families, AsyncCompute::automatic);
  if (!queues) report.missing.push_back("a queue for graphics and compute");
  report.async_compute = queues && queues->async != AsyncQueue::none;
  return report;
}

std::vector<DeviceReport> report_devices(VkInstance instance) {
  uint32_t count = 0;
  vkEnumeratePhysicalDevices(instance, &count, nullptr);
  std::vector<VkPhysicalDevice> devices(count);
  vkEnumeratePhysicalDevices(instance, &count, devices.data());
  std::vector<DeviceReport> reports;
  for (uint32_t i = 0; i < count; ++i) reports.push_back(report_device(devices[i], i));
  return reports;
}

std::string describe(const DeviceReport& report) {
  std::string text = std::to_string(report.index) + ": " + report.name + " (" + type_name(report.type) +
                     ", " + report.driver + ", Vulkan " +
                     std::to_string(VK_API_VERSION_MAJOR(report.api_version)) + "." +
                     std::to_string(VK_API_VERSION_MINOR(report.api_version)) + ")";
  if (!report.usable()) return text + "; cannot be used, lacks: " + join(report.missing);
  std::vector<std::string> gives, lacks;
  (report.ray_query ? gives : lacks).push_back("ray query");
  (report.ray_tracing_pipeline ? gives : lacks).push_back("ray-tracing pipeline");
  (report.int64_atomics ? gives : lacks).push_back("64-bit buffer atomics");
  (report.async_compute ? gives : lacks).push_back("async compute queue");
  gives.push_back("up to " + std::to_string(report.max_samples) + " samples");
  text += "; gives: " + join(gives);
  if (!lacks.empty()) text += "; lacks: " + join(lacks);
  return text;
}

std::string describe_identity(const DeviceReport& report) {
  return "uuid:" + report.uuid + (report.pci_address.empty() ? "" : " pci:" + report.pci_address);
}

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

Result<DeviceChoice> choose_device(const std::vector<DeviceReport>& reports, std::string_view wanted,
                                   const std::vector<uint32_t>& vendors_present) {
  if (reports.empty()) {
    return Error{
        "no Vulkan device found: install your GPU's Vulkan driver, or mesa-vulkan-drivers for the CPU" +
        describe_driver_files([](const char* name) { return std::getenv(name); })};
  }

  std::vector<const DeviceReport*> candidates;
  if (!wanted.empty()) {
    uint32_t index = 0;
    const auto [end, parsed] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), index);
    const bool is_index = parsed == std::errc() && end == wanted.data() + wanted.size();
    for (const DeviceReport& report : reports) {
      const bool match =
          is_index ? report.index == index
                   : lower_case(report.name).find(lower_case(std::string(wanted))) != std::string::npos;
      if (match) candidates.push_back(&report);
    }
    if (candidates.empty()) {
      return Error{"--device " + std::string(wanted) +
                   ": there is no such device; there are:" + listing(reports)};
    }
    const bool any_usable =
        std::any_of(candidates.begin(), candidates.end(), [](auto* r) { return r->usable(); });
    if (!any_usable) {
      return Error{"--device " + std::string(wanted) + ": " + candidates[0]->name +
                   " cannot be used, it lacks: " + join(candidates[0]->missing) +
                   mesa_update({candidates[0], 1})};
    }
  } else {
    for (const DeviceReport& report : reports) candidates.push_back(&report);
  }

  const DeviceReport* best = nullptr;
  for (const DeviceReport* candidate : candidates) {
    if (candidate->usable() && (!best || rank(candidate->type) < rank(best->type))) best = candidate;
  }
  if (!best)
    return Error{"no Vulkan device can be used; there are:" + listing(reports) + mesa_update(reports)};

  DeviceChoice choice;
  choice.index = best->index;
  if (best->type == DeviceType::software) {
    choice.notes.push_back(best->name + " is a software device: it draws on the CPU");
    for (uint32_t vendor : vendors_present) {
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
        choice.notes.push_back(report.name + " was not taken: it lacks " + join(report.missing));
      }
    }
  }
  return choice;
}

Result<std::vector<DeviceChoice>> choose_devices(const std::vector<DeviceReport>& reports,
                                                 std::string_view wanted,
                                                 const std::vector<uint32_t>& vendors_present) {
  std::vector<DeviceChoice> choices;
  if (wanted == "all") {
    Result<DeviceChoice> best = choose_device(reports, "", vendors_present);
    if (!best) return best.error();
    choices.push_back(std::move(*best));
    const DeviceType type = reports[choices[0].index].type;
    for (const DeviceReport& report : reports) {
      if (report.usable() && report.type == type && report.index != choices[0].index)
        choices.push_back({report.index, {}});
    }
    return choices;
  }
  for (size_t begin = 0; begin <= wanted.size();) {
    const size_t end = std::min(wanted.find(',', begin), wanted.size());
    const std::string_view one = wanted.substr(begin, end - begin);
    if (one.empty())
      return Error{"--devices " + std::string(wanted) +
                   ": name devices by index or part of the name, separated by commas, such as 0,1, or all"};
    Result<DeviceChoice> choice = choose_device(reports, one);
    if (!choice) return Error{"--devices " + std::string(wanted) + ": " + choice.error().message};
    choices.push_back(std::move(*choice));
    begin = end + 1;
  }
  return choices;
}

}  // namespace fire3dv::gpu
