// Checks of the system around the renderer: rights, shared memory, folders, display, limits, ports.
#include <algorithm>
#include <cstdio>

#include "base/words.h"
#include "renderer/doctor/check.h"
#include "renderer/doctor/lines.h"

namespace fire3dv::doctor {
namespace {

std::string mebibytes(uint64_t bytes) {
  return std::to_string(bytes >> 20) + " MiB";
}

std::vector<Finding> check_experiments(const Facts& facts) {
  if (facts.experiments_fault.empty()) return {};
  const bool needs_files = facts.experiments_fault.find("Too many open files") != std::string::npos;
  return {{Level::error, "drivers and devices cannot be tried: " + facts.experiments_fault,
           needs_files ? kMoreFiles : "ulimit -u 1024"}};
}

Finding inaccessible(const Facts& facts, const NodeFacts& node) {
  const std::string path = shell_word(node.path), text = "this user may not read and write " + node.path;
  const bool has_group = !node.group.empty() && node.group != "root" && node.group != "nogroup";
  if (facts.container)
    return {Level::warning, text,
            "docker run --device " + path + " --group-add " + std::to_string(node.gid) + " IMAGE"};
  if (!node.group_may()) {
    char mode[8];
    std::snprintf(mode, sizeof mode, "%04o", node.mode & 0777);
    return {Level::warning, text + ": its mode is " + mode,
            "sudo chmod " + std::string(has_group ? "g+rw " : "a+rw ") + path};
  }
  if (!has_group) return {Level::warning, text, "sudo chmod a+rw " + path};
  return {Level::warning, text + ", which the group " + node.group + " may",
          "sudo usermod -aG " + shell_word(node.group) + " $USER  # then log in again"};
}

std::vector<Finding> check_nodes(const Facts& facts) {
  std::vector<Finding> findings;
  for (const std::vector<NodeFacts>& nodes : {facts.render_nodes, facts.nvidia_nodes}) {
    for (const NodeFacts& node : nodes) {
      if (node.accessible) continue;
      findings.push_back(inaccessible(facts, node));
    }
  }
  const bool needs_node = std::any_of(facts.gpu_vendors.begin(), facts.gpu_vendors.end(),
                                      [](const std::string& v) { return v != "NVIDIA"; });
  if (needs_node && facts.render_nodes.empty())
    findings.push_back({Level::warning, "there is a GPU, but no device node /dev/dri/renderD*",
                        facts.container ? "docker run --device /dev/dri IMAGE" : "ls -l /dev/dri"});
  if (findings.empty() && !facts.render_nodes.empty())
    findings.push_back({Level::ok, "the GPU's device nodes in /dev/dri can be opened", ""});
  return findings;
}

std::vector<Finding> check_shared_memory(const Facts& facts) {
  const std::string mount = facts.container ? "docker run --shm-size=1g IMAGE"
                                            : "sudo mount -t tmpfs -o size=1g,mode=1777 tmpfs /dev/shm";
  const std::string effect = ": streams over shm:// fail, tcp:// works";
  if (facts.shared_memory == Facts::SharedMemory::missing)
    return {{Level::warning, "/dev/shm is missing" + effect,
             facts.container ? mount : "sudo mkdir -p /dev/shm && " + mount}};
  if (facts.shared_memory == Facts::SharedMemory::read_only)
    return {{Level::warning, "/dev/shm is mounted read-only" + effect,
             facts.container ? mount : "sudo mount -o remount,rw /dev/shm"}};
  if (facts.shared_memory == Facts::SharedMemory::not_writable)
    return {{Level::warning, "/dev/shm cannot be written" + effect,
             facts.container ? mount : "sudo chmod 1777 /dev/shm"}};
  // Docker's default of 64 MiB holds seven images of 1920x1080, and nothing else.
  constexpr uint64_t kEnough = uint64_t{256} << 20, kLittle = uint64_t{32} << 20;
  const std::string remount = facts.container ? mount : "sudo mount -o remount,size=1g /dev/shm";
  if (facts.shared_memory_bytes < kEnough)
    return {{Level::warning,
             "/dev/shm has only " + mebibytes(facts.shared_memory_bytes) +
                 ": images over shm:// fill it, one of 1920x1080 takes 8 MiB",
             remount}};
  if (facts.shared_memory_free_bytes < kLittle)
    return {{Level::warning,
             "/dev/shm is almost full: " + mebibytes(facts.shared_memory_free_bytes) + " are free",
             "ls -lS /dev/shm | head"}};
  return {{Level::ok, "/dev/shm has " + mebibytes(facts.shared_memory_free_bytes) + " free", ""}};
}

std::vector<Finding> check_home(const Facts& facts) {
  if (!facts.variable("HOME").empty()) return {};
  return {{Level::note, "HOME is not set: there are no stored settings, recent files and recovery files",
           "export HOME=/tmp/fire3dv-home"}};
}

std::vector<Finding> check_cache(const Facts& facts) {
  const std::string effect = ": each start compiles its pipelines again, which takes seconds";
  if (facts.cache_folder.empty())
    return {{Level::warning, "nothing names a folder for caches" + effect,
             "export XDG_CACHE_HOME=/var/tmp/fire3dv-cache"}};
  if (!facts.cache_fault.empty())
    return {{Level::warning,
             "the cache " + facts.cache_folder + " cannot be written (" + facts.cache_fault + ")" + effect,
             "export XDG_CACHE_HOME=/var/tmp/fire3dv-cache"}};
  return {{Level::ok, "caches are stored in " + facts.cache_folder, ""}};
}

std::vector<Finding> check_display(const Facts& facts) {
  if (facts.display.empty())
    return {{Level::note, "there is no display for a window (neither DISPLAY nor WAYLAND_DISPLAY is set)",
             "fire3dv --headless --out images FILE"}};
  if (!facts.display_fault.empty())
    return {
        {Level::warning,
         "the display " + facts.display + " cannot be reached, so no window opens: " + facts.display_fault,
         "fire3dv --headless --out images FILE"}};
  return {{Level::ok, "the display " + facts.display + " answers", ""}};
}

std::vector<Finding> check_open_files(const Facts& facts) {
  if (facts.has_few_files())
    return {{Level::warning,
             "this process may open only " + std::to_string(facts.open_files_limit) +
                 " files: drivers, links and 64 peers need " + std::to_string(Facts::kOpenFiles),
             kMoreFiles}};
  return {{Level::ok, "this process may open " + std::to_string(facts.open_files_limit) + " files", ""}};
}

std::vector<Finding> check_locked_memory(const Facts& facts) {
  constexpr uint64_t kEnough = uint64_t{64} << 10;
  if (facts.locked_memory_bytes >= kEnough) return {};
  return {{Level::note,
           "this process may lock only " + std::to_string(facts.locked_memory_bytes >> 10) +
               " KiB of memory: FIRE-3DV locks none, but GPU drivers may",
           "ulimit -l 65536"}};
}

std::vector<Finding> check_address_space(const Facts& facts) {
  constexpr uint64_t kEnough = uint64_t{16} << 30;
  if (facts.address_space_bytes >= kEnough) return {};
  return {{Level::warning,
           "this process may use only " + mebibytes(facts.address_space_bytes) +
               " of address space (ulimit -v): drivers reserve several GiB, and may crash",
           "ulimit -v unlimited"}};
}

std::vector<Finding> check_ports(const Facts& facts) {
  std::vector<Finding> findings;
  for (const PortFacts& port : facts.ports) {
    if (port.fault.empty()) {
      findings.push_back({Level::ok, port.option + " can be opened", ""});
    } else {
      findings.push_back(
          {Level::error, port.option + " cannot be opened: " + port.fault, port.in_use ? "ss -lntup" : ""});
    }
  }
  return findings;
}

constexpr Check kSystemChecks[] = {
    {"experiments", check_experiments},
    {"device-nodes", check_nodes},
    {"shared-memory", check_shared_memory},
    {"home", check_home},
    {"cache", check_cache},
    {"display", check_display},
    {"open-files", check_open_files},
    {"locked-memory", check_locked_memory},
    {"address-space", check_address_space},
    {"ports", check_ports},
};

}  // namespace

std::span<const Check> system_checks() {
  return kSystemChecks;
}

}  // namespace fire3dv::doctor
