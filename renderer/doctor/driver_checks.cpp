// Checks of what lies before the first device: the Vulkan loader, driver manifests, layers, containers, WSL.
#include <algorithm>
#include <array>
#include <string_view>

#include "base/text.h"
#include "renderer/doctor/check.h"
#include "renderer/doctor/driver_manifests.h"

namespace fire3dv::doctor {
namespace {

constexpr const char* kInstallMesa =
    "sudo apt-get install mesa-vulkan-drivers  # where fire3dv is from a wheel: install the file "
    "fire3dv_cpu-*.whl, too (docs/install.md)";
constexpr const char* kMoreFiles = "ulimit -n 1024";
constexpr const char* kContainerLine =
    "docker run --runtime=nvidia --gpus all -e NVIDIA_DRIVER_CAPABILITIES=all IMAGE";

bool contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

std::string version_text(uint32_t version) {
  return std::to_string(version >> 22 & 0x7F) + "." + std::to_string(version >> 12 & 0x3FF) + "." +
         std::to_string(version & 0xFFF);
}

constexpr uint32_t make_version(uint32_t major, uint32_t minor, uint32_t patch) {
  return major << 22 | minor << 12 | patch;
}

std::vector<Finding> check_loader(const Facts& facts) {
  const LoaderFacts& loader = facts.loader;
  if (!loader.fault.empty() && !loader.override_file.empty())
    return {{Level::error,
             "there is no usable Vulkan loader: " + loader.fault + "; LD_LIBRARY_PATH leads to " +
                 quote(loader.override_file),
             "unset LD_LIBRARY_PATH"}};
  if (!loader.fault.empty())
    return {{Level::error, "there is no usable Vulkan loader: " + loader.fault,
             "sudo apt-get install --reinstall libvulkan1 mesa-vulkan-drivers"}};
  if (loader.version < make_version(1, 3, 0))
    return {{Level::error, "the Vulkan loader " + version_text(loader.version) + " is older than 1.3",
             "sudo apt-get install libvulkan1"}};
  return {{Level::ok,
           "Vulkan loader " + version_text(loader.version) + (loader.file.empty() ? "" : ", " + loader.file),
           ""}};
}

// Variables that replace or filter the drivers of the system.
std::vector<Finding> check_driver_variables(const Facts& facts) {
  std::vector<Finding> findings;
  for (const char* name :
       {"VK_DRIVER_FILES", "VK_ICD_FILENAMES"}) {  // the second has no effect beside the first
    // Loaders of 1.3 take an empty variable for a list of no drivers.
    if (facts.environment.contains(name) && facts.variable(name).empty() && facts.loader.fault.empty() &&
        facts.devices.empty())
      findings.push_back(
          {Level::error,
           std::string("the environment variable ") + name + " is set, but empty, which can hide all drivers",
           "unset VK_DRIVER_FILES VK_ICD_FILENAMES"});
    if (facts.variable(name).empty()) continue;
    const bool any = std::any_of(facts.manifests.begin(), facts.manifests.end(),
                                 [&](const ManifestFacts& m) { return m.variable == name; });
    for (const ManifestFacts& manifest : facts.manifests) {
      if (manifest.variable != name || manifest.fault.empty()) continue;
      findings.push_back({Level::error,
                          "the environment variable " + manifest.variable + " names " + quote(manifest.file) +
                              ": " + manifest.fault,
                          "unset VK_DRIVER_FILES VK_ICD_FILENAMES"});
    }
    if (!any)
      findings.push_back({Level::error,
                          std::string("the environment variable ") + name +
                              " names no driver manifest: " + quote(facts.variable(name)),
                          "unset VK_DRIVER_FILES VK_ICD_FILENAMES"});
    if (findings.empty())
      findings.push_back({Level::note,
                          std::string("the environment variable ") + name + " leaves only the drivers of " +
                              quote(facts.variable(name)),
                          "unset VK_DRIVER_FILES VK_ICD_FILENAMES"});
    break;
  }
  const std::string added = facts.variable("VK_ADD_DRIVER_FILES");
  if (!added.empty() && facts.loader.fault.empty() && facts.loader.version < make_version(1, 3, 234))
    findings.push_back({Level::warning,
                        "the Vulkan loader " + version_text(facts.loader.version) +
                            " ignores the environment variable VK_ADD_DRIVER_FILES; 1.3.234 reads it",
                        "export VK_DRIVER_FILES=" + added});
  for (const char* name : {"VK_LOADER_DRIVERS_SELECT", "VK_LOADER_DRIVERS_DISABLE"}) {
    if (!facts.variable(name).empty())
      findings.push_back(
          {Level::note,
           std::string("the environment variable ") + name + " hides drivers: " + quote(facts.variable(name)),
           std::string("unset ") + name});
  }
  return findings;
}

bool is_of_nvidia(const ManifestFacts& manifest) {
  return contains(manifest.library, "libGLX_nvidia") || contains(manifest.library, "libEGL_nvidia");
}

// The library that a text of dlerror() misses, if it is another one than `library`.
std::string missing_library(const std::string& error, const std::string& library) {
  const size_t end = error.find(": cannot open shared object file");
  if (end == std::string::npos) return "";
  const std::string name = error.substr(0, end);
  return name == library ? "" : name;
}

std::string package_of(const std::string& library) {
  constexpr std::array<std::pair<std::string_view, const char*>, 6> kPackages{{
      {"libXext.so.6", "libxext6"},
      {"libX11.so.6", "libx11-6"},
      {"libX11-xcb.so.1", "libx11-xcb1"},
      {"libxcb.so.1", "libxcb1"},
      {"libEGL.so.1", "libegl1"},
      {"libGLdispatch.so.0", "libglvnd0"},
  }};
  for (const auto& [name, package] : kPackages) {
    if (library == name) return package;
  }
  return "";
}

std::string install_line(const ManifestFacts& manifest, const Facts& facts) {
  if (contains(manifest.load.detail, "Too many open files")) return kMoreFiles;
  // libegl1 depends on libglvnd0, and libxext6 on libx11-6.
  if (contains(manifest.load.detail, "no vkCreateInstance without "))
    return std::string("sudo apt-get install libegl1") +
           (contains(manifest.load.detail, "libX") ? " libxext6" : "");
  const std::string missing = missing_library(manifest.load.detail, manifest.library);
  const std::string package = package_of(missing);
  if (!package.empty()) return "sudo apt-get install " + package;
  if (is_of_nvidia(manifest) && facts.container) return kContainerLine;
  if (contains(manifest.library, "/")) return "ldd " + library_to_load(manifest);
  if (manifest.library.starts_with("libvulkan_"))
    return "sudo apt-get install --reinstall mesa-vulkan-drivers";
  return "ldconfig -p | grep " + manifest.library;
}

std::vector<Finding> check_manifests(const Facts& facts) {
  if (!facts.loader.fault.empty()) return {};
  if (facts.manifests.empty())
    return {{Level::error, "there is no Vulkan driver: no manifest (icd.d/*.json) was found", kInstallMesa}};
  std::vector<Finding> findings;
  std::string loaded;
  for (const ManifestFacts& manifest : facts.manifests) {
    const std::string title = manifest.file + " (" + manifest.library + ")";
    // An unreadable file of VK_DRIVER_FILES is a finding of driver-variables.
    if (!manifest.fault.empty()) {
      if (manifest.variable.empty() || manifest.variable == "VK_ADD_DRIVER_FILES")
        findings.push_back(
            {Level::warning, "the driver manifest " + manifest.file + " is broken: " + manifest.fault, ""});
    } else if (manifest.load.passed()) {
      loaded += (loaded.empty() ? "" : ", ") + manifest.file +
                (manifest.variable.empty() ? "" : " (by " + manifest.variable + ")");
    } else if (contains(manifest.load.detail, "wrong ELF class")) {
      findings.push_back({Level::note, "the driver of " + title + " is for 32-bit programs", ""});
    } else if (manifest.load.went_wrong()) {
      findings.push_back({Level::warning,
                          "the driver of " + manifest.file + " cannot be loaded: loading " +
                              manifest.library + " " + describe(manifest.load),
                          install_line(manifest, facts)});
    }
  }
  if (loaded.empty()) {
    for (Finding& finding : findings) {
      if (finding.level == Level::warning) finding.level = Level::error;
    }
  } else {
    findings.insert(findings.begin(), {Level::ok, "driver libraries that load: " + loaded, ""});
  }
  return findings;
}

std::vector<Finding> check_layers(const Facts& facts) {
  if (facts.implicit_layers.empty()) return {};
  // Mesa installs this one with its drivers; it only orders the devices.
  constexpr std::string_view kHarmless = "VK_LAYER_MESA_device_select";
  std::string names;
  bool harmless = true;
  for (const LayerFacts& layer : facts.implicit_layers) {
    names += (names.empty() ? "" : ", ") + layer.name;
    harmless = harmless && layer.name == kHarmless;
  }
  if (harmless) return {{Level::ok, "the only implicit Vulkan layer is Mesa's, which orders devices", ""}};
  return {{Level::note, "implicit Vulkan layers are active, and may change or break images: " + names,
           "export VK_LOADER_LAYERS_DISABLE='~implicit~'"}};
}

constexpr uint32_t kNvidia = 0x10de;

std::string nvidia_major(const Facts& facts) {
  return facts.nvidia_driver.substr(0, facts.nvidia_driver.find('.'));
}

// CUDA or its device nodes are there, and no Vulkan device of NVIDIA.
std::vector<Finding> check_nvidia(const Facts& facts) {
  const bool has_gpu = !facts.nvidia_nodes.empty() || facts.cuda.passed();
  const bool draws = std::any_of(facts.devices.begin(), facts.devices.end(),
                                 [](const DeviceFacts& d) { return d.vendor_id == kNvidia; });
  if (!has_gpu || facts.wsl || facts.replaces_drivers()) return {};
  if (draws) return {{Level::ok, "NVIDIA's GPU is there for Vulkan, too", ""}};
  const std::string seen = facts.cuda.passed() ? "CUDA works" : "NVIDIA's device nodes are there";
  const auto manifest = std::find_if(facts.manifests.begin(), facts.manifests.end(), is_of_nvidia);
  if (manifest == facts.manifests.end()) {
    const std::string capabilities = facts.variable("NVIDIA_DRIVER_CAPABILITIES");
    if (facts.container)
      return {{Level::error,
               seen + ", but the container has no Vulkan driver of NVIDIA: NVIDIA_DRIVER_CAPABILITIES is " +
                   (capabilities.empty() ? "not set" : quote(capabilities)) + ", and needs \"graphics\"",
               kContainerLine}};
    const std::string major = nvidia_major(facts);
    const bool ubuntu = contains(facts.system, "Ubuntu");
    return {{Level::error, seen + ", but no manifest of NVIDIA's Vulkan driver is installed",
             ubuntu ? "sudo apt-get install libnvidia-gl-" + (major.empty() ? "NNN" : major) +
                          "  # with -server for server drivers"
                    : "sudo apt-get install nvidia-vulkan-icd"}};
  }
  if (manifest->load.went_wrong()) {
    return {{Level::error,
             seen + ", but NVIDIA's Vulkan driver cannot be loaded: " + manifest->library + " " +
                 describe(manifest->load),
             install_line(*manifest, facts)}};
  }
  // Seen on a server: the driver loads its X11 and OpenGL libraries itself, and is silent about missing ones.
  return {{Level::error,
           seen +
               ", and NVIDIA's Vulkan driver loads, but lists no device: libraries that it loads itself are "
               "missing, or libnvidia-glvkspirv is",
           "sudo apt-get install libgl1 libegl1 libxext6"}};
}

std::vector<Finding> check_wsl(const Facts& facts) {
  if (!facts.wsl) return {};
  return {
      {Level::warning,
       "this is WSL 2: its GPU driver (Mesa's dzn) is not a conformant Vulkan implementation, and FIRE-3DV "
       "was not tried with it; the software driver draws, and Mesa's device-select layer can crash",
       "export NODEVICE_SELECT=1 VK_LOADER_DRIVERS_SELECT='*lvp*'"}};
}

constexpr Check kDriverChecks[] = {
    {"loader", check_loader},
    {"driver-variables", check_driver_variables},
    {"driver-manifests", check_manifests},
    {"implicit-layers", check_layers},
    {"nvidia-without-vulkan", check_nvidia},
    {"wsl", check_wsl},
};

}  // namespace

std::span<const Check> driver_checks() {
  return kDriverChecks;
}

}  // namespace fire3dv::doctor
