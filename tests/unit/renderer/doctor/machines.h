// Made-up machines for the tests of the doctor's checks.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/doctor/check.h"

namespace fire3dv::doctor {

// A workstation on which all checks are ok: an NVIDIA GPU and lavapipe, with a display.
inline Facts good_machine() {
  Facts facts;
  facts.environment = {{"HOME", "/home/ada"}, {"DISPLAY", ":0"}};
  facts.loader = {"", "/usr/lib/libvulkan.so.1", 1u << 22 | 3u << 12 | 239u};
  facts.manifests = {
      {"/usr/share/vulkan/icd.d/nvidia_icd.json", "", "libGLX_nvidia.so.0", "", {Outcome::passed, ""}},
      {"/usr/share/vulkan/icd.d/lvp_icd.json", "", "libvulkan_lvp.so", "", {Outcome::passed, ""}}};
  facts.listing = {Outcome::passed, ""};
  DeviceFacts gpu;
  gpu.name = "Big GPU";
  gpu.driver = "NVIDIA 580.65.06";
  gpu.type = "discrete GPU";
  gpu.uuid = "01020304-0506-0708-090a-0b0c0d0e0f10";
  gpu.pci_address = "0000:3b:00.0";
  gpu.vendor_id = 0x10de;
  gpu.ray_query = true;
  gpu.read_back = gpu.ray = {Outcome::passed, ""};
  DeviceFacts software = gpu;
  software.index = 1;
  software.name = "llvmpipe";
  software.driver = "llvmpipe Mesa 25.0.7 (LLVM 19.1.7)";
  software.type = "software";
  software.uuid = "6d657361-0000-0000-0000-000000000000";
  software.pci_address = "";
  software.vendor_id = 0x10005;
  facts.devices = {gpu, software};
  facts.chosen = 0;
  facts.gpu_vendors = {"NVIDIA"};
  facts.nvidia_nodes = {{"/dev/nvidia0", "video", true}, {"/dev/nvidiactl", "video", true}};
  facts.nvidia_driver = "580.65.06";
  facts.cuda = {Outcome::passed, ""};
  facts.cuda_devices = {{0, "Big GPU", gpu.uuid, false}};
  facts.system = "Debian GNU/Linux 13 (trixie)";
  facts.shared_memory_bytes = facts.shared_memory_free_bytes = uint64_t{8} << 30;
  facts.cache_folder = "/home/ada/.cache/fire3dv";
  facts.display = ":0";
  facts.open_files_limit = 1024;
  facts.locked_memory_bytes = uint64_t{8} << 20;
  return facts;
}

// The same without its GPU.
inline Facts software_machine() {
  Facts facts = good_machine();
  facts.devices.erase(facts.devices.begin());
  facts.devices[0].index = 0;
  facts.manifests.erase(facts.manifests.begin());
  facts.gpu_vendors.clear();
  facts.nvidia_nodes.clear();
  facts.nvidia_driver.clear();
  facts.cuda = {};
  facts.cuda_devices.clear();
  return facts;
}

// The first finding of a check that is not ok; a level of ok: there is none.
inline Finding fault(const Facts& facts, std::string_view id) {
  for (const CheckedFinding& found : run_checks(facts)) {
    if (found.id == id && found.finding.level != Level::ok) return found.finding;
  }
  return {};
}

// Ids of all findings of this level.
inline std::vector<std::string> ids(const Facts& facts, Level level) {
  std::vector<std::string> found;
  for (const CheckedFinding& each : run_checks(facts)) {
    if (each.finding.level == level) found.push_back(each.id);
  }
  return found;
}

inline bool mentions(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

}  // namespace fire3dv::doctor
