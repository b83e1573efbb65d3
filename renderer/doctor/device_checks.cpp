// Checks of Vulkan devices: listing, choice, read-back, rays, and the order of CUDA.
#include <algorithm>
#include <string_view>

#include "base/numbers.h"
#include "base/text.h"
#include "renderer/doctor/check.h"

namespace fire3dv::doctor {
namespace {

constexpr const char* kUnset = "unset VK_DRIVER_FILES VK_ICD_FILENAMES";
constexpr const char* kInstallDriver =
    "sudo apt-get install mesa-vulkan-drivers  # where fire3dv is from a wheel: install the file "
    "fire3dv_cpu-*.whl, too (docs/install.md)";

std::string title(const DeviceFacts& device) {
  return "device " + std::to_string(device.index) + " (" + device.name + ")";
}

std::string join(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

bool any_usable(const Facts& facts) {
  return std::any_of(facts.devices.begin(), facts.devices.end(),
                     [](const DeviceFacts& d) { return d.usable(); });
}

// "22.3" of "llvmpipe Mesa 22.3.6 (LLVM 15.0.6)"; empty: another driver.
std::string mesa_version(const std::string& driver) {
  constexpr std::string_view kMesa = "Mesa ";
  const size_t at = driver.find(kMesa);
  if (at == std::string::npos) return "";
  const std::string rest = driver.substr(at + kMesa.size());
  const size_t dot = rest.find('.');
  return dot == std::string::npos ? "" : rest.substr(0, rest.find_first_not_of("0123456789", dot + 1));
}

// Release whose software driver has all that is required; ray query came with it, too.
constexpr int kGoodMesa = 25;

bool is_of_old_mesa(const DeviceFacts& device) {
  const std::string version = mesa_version(device.driver);
  return parse_number<int>(version.substr(0, version.find('.'))).value_or(kGoodMesa) < kGoodMesa;
}

// Drivers that hang or crash when they list their devices, and the line that leaves them out.
std::vector<Finding> check_listing(const Facts& facts) {
  std::vector<Finding> findings;
  std::string good;
  for (const ManifestFacts& manifest : facts.manifests) {
    if (manifest.listing.passed()) good += (good.empty() ? "" : ":") + manifest.file;
  }
  for (const ManifestFacts& manifest : facts.manifests) {
    if (manifest.listing.outcome != Outcome::hung && manifest.listing.outcome != Outcome::crashed) continue;
    findings.push_back(
        {Level::error,
         "the driver of " + manifest.file + " " + describe(manifest.listing) +
             " when it lists its devices, and fire3dv with it",
         good.empty() ? "sudo apt-get install mesa-vulkan-drivers" : "export VK_DRIVER_FILES=" + good});
  }
  if (findings.empty())
    findings.push_back({Level::error, "listing the Vulkan devices " + describe(facts.listing),
                        "VK_LOADER_DEBUG=error,driver fire3dv --list-devices"});
  return findings;
}

std::vector<Finding> check_devices(const Facts& facts) {
  if (!facts.loader.fault.empty()) return {};
  if (facts.listing.outcome == Outcome::hung || facts.listing.outcome == Outcome::crashed)
    return check_listing(facts);
  if (facts.devices.empty())
    return {{Level::error, "no driver lists a Vulkan device, so nothing can draw",
             facts.replaces_drivers() ? kUnset
             : facts.has_few_files()  ? "ulimit -n 1024"
                                      : kInstallDriver}};
  std::vector<Finding> findings;
  if (facts.chosen)
    findings.push_back(
        {Level::ok, "fire3dv takes " + title(facts.devices[*facts.chosen]) + " by itself", ""});
  for (const DeviceFacts& device : facts.devices) {
    if (!device.usable() && !is_of_old_mesa(device))  // that is a finding of old-mesa
      findings.push_back({any_usable(facts) ? Level::note : Level::error,
                          title(device) + " cannot be used, it lacks: " + join(device.missing), ""});
  }
  return findings;
}

std::vector<Finding> check_mesa(const Facts& facts) {
  for (const DeviceFacts& device : facts.devices) {
    if (!is_of_old_mesa(device)) continue;
    const std::string version = mesa_version(device.driver);
    const bool debian12 = facts.system.find("bookworm") != std::string::npos;
    const char* const fix = debian12 ? "sudo apt-get install -t bookworm-backports mesa-vulkan-drivers"
                                     : "sudo apt-get update && sudo apt-get install mesa-vulkan-drivers";
    const bool is_chosen = facts.chosen && *facts.chosen == device.index;
    if (!device.usable())
      return {{any_usable(facts) ? Level::note : Level::error,
               "Mesa " + version + " is too old: " + title(device) + " lacks " + join(device.missing) +
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
  const bool has_gpu = !facts.gpu_vendors.empty() || !facts.nvidia_nodes.empty() || facts.cuda.passed();
  if (!has_gpu)
    return {
        {Level::note, device.name + " draws on the CPU: this machine has no GPU that is visible here", ""}};
  const std::string vendor = facts.gpu_vendors.empty() ? "NVIDIA" : join(facts.gpu_vendors);
  return {{Level::warning,
           device.name + " draws on the CPU although there is a GPU (" + vendor +
               "); --require-gpu makes fire3dv end instead",
           facts.replaces_drivers() ? kUnset : "fire3dv --require-gpu FILE"}};
}

std::vector<Finding> check_read_back(const Facts& facts) {
  std::vector<Finding> findings;
  std::string good;
  for (const DeviceFacts& device : facts.devices) {
    if (device.read_back.passed()) good += (good.empty() ? "" : ", ") + std::to_string(device.index);
    if (!device.read_back.went_wrong()) continue;
    std::string other;
    for (const DeviceFacts& each : facts.devices) {
      if (each.read_back.passed()) other = std::to_string(each.index);
    }
    findings.push_back(
        {Level::error,
         title(device) + " opens, but drawing and reading back 64x64 pixels " + describe(device.read_back),
         other.empty() ? "sudo dmesg | tail" : "fire3dv --device " + other + " FILE"});
  }
  if (!good.empty())
    findings.insert(findings.begin(),
                    {Level::ok, "64x64 pixels were drawn and read back on device " + good, ""});
  return findings;
}

std::vector<Finding> check_rays(const Facts& facts) {
  std::vector<Finding> findings;
  std::string good;
  for (const DeviceFacts& device : facts.devices) {
    if (device.ray.passed()) good += (good.empty() ? "" : ", ") + std::to_string(device.index);
    if (device.ray.went_wrong())
      findings.push_back({Level::error,
                          title(device) + " claims ray tracing, but tracing one ray " + describe(device.ray),
                          "fire3dv --shadows map FILE"});
  }
  if (!good.empty())
    findings.insert(findings.begin(), {Level::ok, "a ray hit its triangle on device " + good, ""});
  return findings;
}

const DeviceFacts* find_vulkan(const Facts& facts, const CudaDeviceFacts& cuda) {
  for (const DeviceFacts& device : facts.devices) {
    if (!cuda.mig && device.uuid == cuda.uuid) return &device;
  }
  return nullptr;
}

std::vector<Finding> check_cuda_order(const Facts& facts) {
  if (!facts.cuda.passed()) return {};
  std::string pairs, without;
  bool same = true;
  for (const CudaDeviceFacts& cuda : facts.cuda_devices) {
    const std::string index = std::to_string(cuda.index);
    const DeviceFacts* const device = find_vulkan(facts, cuda);
    if (!device) {
      without += (without.empty() ? "" : ", ") + index;
      continue;
    }
    same = same && device->index == cuda.index;
    pairs += (pairs.empty() ? "" : ", ") + ("cuda:" + index) + " is device " + std::to_string(device->index);
  }
  std::vector<Finding> findings;
  if (!pairs.empty())
    findings.push_back(same ? Finding{Level::ok, "CUDA and Vulkan number the GPUs alike: " + pairs, ""}
                            : Finding{Level::note, "CUDA and Vulkan number the GPUs differently: " + pairs,
                                      "fire3dv --device cuda:0 FILE"});
  if (!without.empty() && !facts.devices.empty())
    findings.push_back({Level::note, "no Vulkan device is the same as CUDA's device " + without, ""});
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
