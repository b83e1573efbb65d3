#include "renderer/gpu/device/device_report.h"

#include <algorithm>
#include <cstdio>
#include <optional>

#include "renderer/gpu/device/device_features.h"
#include "renderer/gpu/device/queues.h"
#include "renderer/gpu/mask/device_mask.h"

namespace fire3dv::gpu {
namespace {

constexpr uint32_t kMaxThreads = 256;  // threads of a workgroup in the shaders

constexpr const char* kVulkan13 = "Vulkan 1.3";

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

std::string comma_separated(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

bool has_subgroup_operations(VkPhysicalDevice device) {
  VkPhysicalDeviceVulkan11Properties subgroups{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &subgroups, {}};
  vkGetPhysicalDeviceProperties2(device, &properties);
  device_mask().apply(subgroups);
  constexpr VkSubgroupFeatureFlags kNeeded =
      VK_SUBGROUP_FEATURE_BASIC_BIT | VK_SUBGROUP_FEATURE_BALLOT_BIT | VK_SUBGROUP_FEATURE_ARITHMETIC_BIT;
  return (subgroups.subgroupSupportedOperations & kNeeded) == kNeeded &&
         (subgroups.subgroupSupportedStages & VK_SHADER_STAGE_COMPUTE_BIT) != 0;
}

std::string pci_address_text(const VkPhysicalDevicePCIBusInfoPropertiesEXT& pci) {
  char text[40];
  std::snprintf(text, sizeof text, "%04x:%02x:%02x.%x", pci.pciDomain, pci.pciBus, pci.pciDevice,
                pci.pciFunction);
  return text;
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
  const DeviceMask& mask = device_mask();
  mask.apply(properties.properties.limits);

  DeviceReport report;
  report.index = index;
  report.name = properties.properties.deviceName;
  report.driver = std::string(driver.driverName) + " " + driver.driverInfo;
  report.type = device_type(properties.properties);
  if (mask.no_software && report.type == DeviceType::software) report.type = DeviceType::discrete;
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
  features.query(device);
  report.missing = features.missing_required();
  const VkPhysicalDeviceLimits& limits = properties.properties.limits;
  if (std::min(limits.maxComputeWorkGroupInvocations, limits.maxComputeWorkGroupSize[0]) < kMaxThreads)
    report.missing.push_back("workgroups of " + std::to_string(kMaxThreads) + " threads");
  if (!has_subgroup_operations(device))
    report.missing.push_back("subgroup ballot and arithmetic in compute shaders");
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
  mask.apply(families);
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
  if (!device_mask().text.empty()) text += "; masked by FIRE3DV_DEVICE_MASK=" + device_mask().text;
  if (!report.usable()) return text + "; cannot be used, lacks: " + comma_separated(report.missing);
  std::vector<std::string> gives, lacks;
  (report.ray_query ? gives : lacks).push_back("ray query");
  (report.ray_tracing_pipeline ? gives : lacks).push_back("ray-tracing pipeline");
  (report.int64_atomics ? gives : lacks).push_back("64-bit buffer atomics");
  (report.async_compute ? gives : lacks).push_back("async compute queue");
  gives.push_back("up to " + std::to_string(report.max_samples) + " samples");
  text += "; gives: " + comma_separated(gives);
  if (!lacks.empty()) text += "; lacks: " + comma_separated(lacks);
  return text;
}

std::string describe_identity(const DeviceReport& report) {
  return "uuid:" + report.uuid + (report.pci_address.empty() ? "" : " pci:" + report.pci_address);
}

}  // namespace fire3dv::gpu
