// Checks of Vulkan devices: listing, choice, read-back, rays, and the order of CUDA.
#include <algorithm>
#include <string_view>

#include "base/numbers.h"
#include "base/words.h"
#include "renderer/doctor/check.h"
#include "renderer/doctor/lines.h"
#include "renderer/gpu/selection/driver_names.h"

namespace fire3dv::doctor {
namespace {

std::string title(const DeviceFacts& device) {
  return "device " + std::to_string(device.index) + " (" + device.name + ")";
}

bool any_usable(const Facts& facts) {
  return std::any_of(facts.devices.begin(), facts.devices.end(),
                     [](const DeviceFacts& d) { return d.usable(); });
}

bool is_of_old_mesa(const DeviceFacts& device) {
  const std::string version = gpu::mesa_version(device.driver);
  return parse_number<int>(version.substr(0, version.find('.'))).value_or(gpu::kGoodMesa) < gpu::kGoodMesa;
}

// Drivers that hang or crash when they are loaded or list their devices, and the line that leaves them out.
std::vector<Finding> check_listing(const Facts& facts) {
  std::vector<Finding> findings;
  std::vector<std::string> good;
  for (const ManifestFacts& manifest : facts.manifests) {
    if (manifest.listing.passed()) good.push_back(manifest.file);
  }
  const std::string fix = !good.empty() ? export_line(facts.drivers_variable(), joined(good, ":"))
                          : facts.replaces_drivers() ? kUnsetDrivers
                                                     : kInstallDriver;
  for (const ManifestFacts& manifest : facts.manifests) {
    const Trial& trial = manifest.load.ended_badly() ? manifest.load : manifest.listing;
    if (!trial.ended_badly() || !manifest.hidden_by.empty()) continue;
    findings.push_back({Level::error,
                        "the driver of " + manifest.file + " " + describe(trial) +
                            (manifest.load.passed() ? " when it lists its devices" : " when it is loaded") +
                            ", and fire3dv with it",
                        fix});
  }
  if (findings.empty())
    findings.push_back({Level::error, "listing the Vulkan devices " + describe(facts.listing),
                        "VK_LOADER_DEBUG=error,driver fire3dv --list-devices"});
  return findings;
}

// Nothing lists a device: the reason, where there is one, and a line.
Finding no_device(const Facts& facts) {
  // Without the advice for programs that draw: the line has it.
  const std::string detail = facts.listing.detail.substr(0, facts.listing.detail.find("; "));
  const std::string reason = detail.empty() ? "" : ": " + detail;
  const bool is_replaced = facts.replaces_drivers() || facts.environment.contains("VK_DRIVER_FILES") ||
                           facts.environment.contains("VK_ICD_FILENAMES");
  if (reason.starts_with(": FIRE3DV_DEVICE_MASK"))
    return {Level::error, "no device can be listed" + reason, "unset FIRE3DV_DEVICE_MASK"};
  return {Level::error, "no driver lists a Vulkan device, so nothing can draw" + reason,
          is_replaced             ? kUnsetDrivers
          : facts.has_few_files() ? kMoreFiles
                                  : kInstallDriver};
}

std::vector<Finding> check_devices(const Facts& facts) {
  if (!facts.loader.fault.empty()) return {};
  if (facts.listing.ended_badly()) return check_listing(facts);
  if (facts.devices.empty()) return {no_device(facts)};
  std::vector<Finding> findings;
  if (facts.chosen)
    findings.push_back({Level::ok,
                        "fire3dv takes " + title(facts.devices[*facts.chosen]) + " by itself" +
                            (facts.layered_listing.went_wrong() ? " once implicit layers are off" : ""),
                        ""});
  for (const DeviceFacts& device : facts.devices) {
    if (!device.usable() && !is_of_old_mesa(device))  // that is a finding of old-mesa
      findings.push_back({any_usable(facts) ? Level::note : Level::error,
                          title(device) + " cannot be used, it lacks: " + joined(device.missing), ""});
  }
  return findings;
}

std::vector<Finding> check_mesa(const Facts& facts) {
  for (const DeviceFacts& device : facts.devices) {
    if (!is_of_old_mesa(device)) continue;
    const std::string version = gpu::mesa_version(device.driver);
    const bool debian12 = facts.system.find("bookworm") != std::string::npos;
    const char* const fix = debian12 ? "sudo apt-get install -t bookworm-backports mesa-vulkan-drivers"
                                     : "sudo apt-get update && sudo apt-get install mesa-vulkan-drivers";
    const bool is_chosen = facts.chosen && *facts.chosen == device.index;
    if (!device.usable())
      return {{any_usable(facts) ? Level::note : Level::error,
               "Mesa " + version + " is too old: " + title(device) + " lacks " + joined(device.missing) +
                   "; Mesa 25 works, and docs/install.md says how to add backports",
               fix}};
    if (device.software() && !device.ray_query && is_chosen)
      return {{Level::warning,
               "Mesa " + version +
                   " draws without ray query: shadows come from shadow maps, and path tracing is "
                   "not available; 25 has it",
               fix}};
  }
  return {};
}

std::vector<Finding> check_software(const Facts& facts) {
  if (!facts.chosen || !facts.devices[*facts.chosen].software()) return {};
  const DeviceFacts& device = facts.devices[*facts.chosen];
  const bool has_gpu =
      !facts.gpu_vendors.empty() || !facts.nvidia_nodes.empty() || !facts.cuda_devices.empty();
  if (!has_gpu)
    return {
        {Level::note, device.name + " draws on the CPU: this machine has no GPU that is visible here", ""}};
  const std::string vendor = facts.gpu_vendors.empty() ? "NVIDIA" : joined(facts.gpu_vendors);
  return {{Level::warning,
           device.name + " draws on the CPU although there is a GPU (" + vendor +
               "); --require-gpu makes fire3dv end instead",
           facts.replaces_drivers() ? kUnsetDrivers : "fire3dv --require-gpu FILE"}};
}

// A software device on a busy machine may exceed the time limit without a fault of its driver.
bool may_be_busy(const DeviceFacts& device, const Trial& trial) {
  return device.software() && trial.outcome == Outcome::hung;
}
constexpr const char* kMoreTime = "fire3dv doctor --time-limit 300  # if this machine is busy";

std::vector<Finding> check_read_back(const Facts& facts) {
  std::vector<Finding> findings;
  std::vector<std::string> good;
  for (const DeviceFacts& device : facts.devices) {
    if (device.read_back.passed()) good.push_back(std::to_string(device.index));
    if (!device.read_back.went_wrong()) continue;
    std::string other;
    for (const DeviceFacts& each : facts.devices) {
      if (each.read_back.passed()) other = std::to_string(each.index);
    }
    const bool by_layers = device.read_back_without_layers.passed();
    findings.push_back(
        {Level::error,
         title(device) + " is listed, but opening it, clearing 64x64 pixels and reading them back " +
             describe(device.read_back) + (by_layers ? "; without implicit layers it works" : ""),
         by_layers                               ? layers_off_line(facts.implicit_layers)
         : may_be_busy(device, device.read_back) ? kMoreTime
         : other.empty()                         ? "sudo dmesg | tail"
                                                 : "fire3dv --device " + other + " FILE"});
  }
  if (!good.empty())
    findings.insert(findings.begin(),
                    {Level::ok, "64x64 pixels were drawn and read back on device " + joined(good), ""});
  return findings;
}

std::vector<Finding> check_rays(const Facts& facts) {
  std::vector<Finding> findings;
  std::vector<std::string> good;
  for (const DeviceFacts& device : facts.devices) {
    if (device.ray.passed()) good.push_back(std::to_string(device.index));
    if (device.ray.went_wrong())
      findings.push_back({Level::error,
                          title(device) + " claims ray tracing, but tracing one ray " + describe(device.ray),
                          may_be_busy(device, device.ray) ? kMoreTime : "fire3dv --shadows map FILE"});
  }
  if (!good.empty())
    findings.insert(findings.begin(), {Level::ok, "a ray hit its triangle on device " + joined(good), ""});
  return findings;
}

const DeviceFacts* find_vulkan(const Facts& facts, const CudaDeviceFacts& cuda) {
  for (const DeviceFacts& device : facts.devices) {
    if (!cuda.mig && device.uuid == cuda.uuid) return &device;
  }
  return nullptr;
}

std::vector<Finding> check_cuda_order(const Facts& facts) {
  if (facts.cuda.went_wrong())
    return {
        {Level::note, "--device cuda:N cannot be used, since CUDA " + describe(facts.cuda), "nvidia-smi"}};
  if (!facts.cuda.passed()) return {};
  std::vector<std::string> pairs, without;
  bool same = true;
  for (const CudaDeviceFacts& cuda : facts.cuda_devices) {
    const std::string index = std::to_string(cuda.index);
    const DeviceFacts* const device = find_vulkan(facts, cuda);
    if (!device) {
      without.push_back(index);
      continue;
    }
    same = same && device->index == cuda.index;
    pairs.push_back("cuda:" + index + " is device " + std::to_string(device->index));
  }
  std::vector<Finding> findings;
  if (!pairs.empty())
    findings.push_back(
        same ? Finding{Level::ok, "CUDA and Vulkan number the GPUs alike: " + joined(pairs), ""}
             : Finding{Level::note, "CUDA and Vulkan number the GPUs differently: " + joined(pairs),
                       "fire3dv --device cuda:0 FILE"});
  if (!without.empty() && !facts.devices.empty())
    findings.push_back({Level::note, "no Vulkan device is the same as CUDA's device " + joined(without), ""});
  return findings;
}

std::vector<Finding> check_mig(const Facts& facts) {
  const bool visible = facts.variable("CUDA_VISIBLE_DEVICES").find("MIG-") != std::string::npos ||
                       facts.variable("NVIDIA_VISIBLE_DEVICES").find("MIG-") != std::string::npos;
  const bool divided = std::any_of(facts.cuda_devices.begin(), facts.cuda_devices.end(),
                                   [](const CudaDeviceFacts& d) { return d.mig; });
  if (!visible && !divided) return {};
  return {{Level::warning, "a GPU is divided by MIG, and slices of MIG have no Vulkan: use a GPU without MIG",
           "nvidia-smi --query-gpu=index,mig.mode.current --format=csv"}};
}

constexpr Check kDeviceChecks[] = {
    {"devices", check_devices},
    {"old-mesa", check_mesa},
    {"software-device", check_software},
    {"read-back", check_read_back},
    {"ray-tracing", check_rays},
    {"cuda-order", check_cuda_order},
    {"mig", check_mig},
};

}  // namespace

std::span<const Check> device_checks() {
  return kDeviceChecks;
}

}  // namespace fire3dv::doctor
