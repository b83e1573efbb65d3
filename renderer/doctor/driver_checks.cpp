// Checks of what lies before the first device: the Vulkan loader, driver manifests, layers, containers, WSL.
#include <algorithm>
#include <array>
#include <string_view>

#include "base/text.h"
#include "base/words.h"
#include "renderer/doctor/check.h"
#include "renderer/doctor/driver_manifests.h"
#include "renderer/doctor/lines.h"
#include "renderer/gpu/selection/driver_names.h"

namespace fire3dv::doctor {
namespace {

constexpr const char* kContainerLine =
    "docker run --runtime=nvidia --gpus all -e NVIDIA_DRIVER_CAPABILITIES=all IMAGE";

bool contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

std::vector<Finding> check_loader(const Facts& facts) {
  const LoaderFacts& loader = facts.loader;
  const bool is_old = loader.version < make_version(1, 3, 0);
  const std::string fault = !loader.fault.empty() ? "there is no usable Vulkan loader: " + loader.fault
                            : is_old
                                ? "the Vulkan loader " + version_text(loader.version) + " is older than 1.3"
                                : "";
  if (!fault.empty() && !loader.override_file.empty())
    return {{Level::error, fault + "; LD_LIBRARY_PATH leads to " + quote(loader.override_file),
             "unset LD_LIBRARY_PATH"}};
  if (!fault.empty())
    return {{Level::error, fault,
             is_old && loader.fault.empty()
                 ? "sudo apt-get install libvulkan1"
                 : "sudo apt-get install --reinstall libvulkan1 mesa-vulkan-drivers"}};
  return {{Level::ok,
           "Vulkan loader " + version_text(loader.version) + (loader.file.empty() ? "" : ", " + loader.file),
           ""}};
}

Finding ignored_variable(const Facts& facts, const std::string& name, uint32_t since,
                         const std::string& fix) {
  return {Level::warning,
          "the Vulkan loader " + version_text(facts.loader.version) + " ignores the environment variable " +
              name + "; " + version_text(since) + " reads it",
          fix};
}

// The variable of old loaders, which names all drivers: for VK_ADD_DRIVER_FILES those of the system, too.
std::string line_of_old_loaders(const Facts& facts, std::string_view name) {
  std::vector<std::string> files{facts.variable(std::string(name))};
  for (const ManifestFacts& manifest : facts.manifests) {
    if (name == "VK_ADD_DRIVER_FILES" && manifest.fault.empty()) files.push_back(manifest.file);
  }
  return export_line("VK_ICD_FILENAMES", joined(files, ":"));
}

// Variables that this loader is too old for.
void add_ignored_variables(const Facts& facts, std::vector<Finding>& findings) {
  for (const char* name : {"VK_DRIVER_FILES", "VK_ADD_DRIVER_FILES"}) {
    if (!facts.loader.reads(kReadsDriverFiles) && !facts.variable(name).empty())
      findings.push_back(ignored_variable(facts, name, kReadsDriverFiles, line_of_old_loaders(facts, name)));
  }
  for (const char* name :
       {"VK_LOADER_DRIVERS_SELECT", "VK_LOADER_DRIVERS_DISABLE", "VK_LOADER_LAYERS_DISABLE"}) {
    if (!facts.loader.reads(kReadsFilters) && !facts.variable(name).empty())
      findings.push_back(ignored_variable(facts, name, kReadsFilters, std::string("unset ") + name));
  }
}

// Variables that filter drivers by the names of their manifests.
void add_filters(const Facts& facts, std::vector<Finding>& findings) {
  for (const char* name : {"VK_LOADER_DRIVERS_SELECT", "VK_LOADER_DRIVERS_DISABLE"}) {
    std::vector<std::string> hidden;
    for (const ManifestFacts& manifest : facts.manifests) {
      if (manifest.hidden_by == name) hidden.push_back(manifest.file);
    }
    if (hidden.empty()) continue;
    const bool all = hidden.size() == facts.manifests.size();
    findings.push_back({all ? Level::error : Level::note,
                        std::string("the environment variable ") + name + " (" + quote(facts.variable(name)) +
                            ") hides " + (all ? "all drivers: " : "drivers: ") + joined(hidden),
                        std::string("unset ") + name});
  }
}

// Variables that replace or filter the drivers of the system.
std::vector<Finding> check_driver_variables(const Facts& facts) {
  std::vector<Finding> findings;
  const std::string name = facts.replacing_variable(), title = "the environment variable " + name;
  bool any = false;
  for (const ManifestFacts& manifest : facts.manifests) {
    if (name.empty() || manifest.variable != name) continue;
    any = true;
    if (!manifest.fault.empty())
      findings.push_back(
          {Level::error, title + " names " + quote(manifest.file) + ": " + manifest.fault, kUnsetDrivers});
  }
  if (!name.empty() && !any)
    findings.push_back(
        {Level::error, title + " names no driver manifest: " + quote(facts.variable(name)), kUnsetDrivers});
  if (!name.empty() && findings.empty())
    findings.push_back(
        {Level::note, title + " leaves only the drivers of " + quote(facts.variable(name)), kUnsetDrivers});
  // Loaders of 1.3 take an empty variable for a list of no drivers.
  for (const char* empty : {"VK_DRIVER_FILES", "VK_ICD_FILENAMES"}) {
    if (name.empty() && facts.environment.contains(empty) && facts.loader.fault.empty() &&
        facts.devices.empty() && !facts.listing.ended_badly())
      findings.push_back({Level::error,
                          std::string("the environment variable ") + empty +
                              " is set, but empty, which can hide all drivers",
                          kUnsetDrivers});
  }
  add_ignored_variables(facts, findings);
  add_filters(facts, findings);
  if (!facts.variable("FIRE3DV_DEVICE_MASK").empty())
    findings.push_back({Level::note,
                        "the environment variable FIRE3DV_DEVICE_MASK hides features of all devices: " +
                            quote(facts.variable("FIRE3DV_DEVICE_MASK")),
                        "unset FIRE3DV_DEVICE_MASK"});
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
  const std::string file = library_to_load(manifest);
  // What waits for other processes, such as a pipe, is no library.
  if (manifest.load.outcome == Outcome::hung)
    return "ls -lL " + shell_word(manifest.file) + " " + shell_word(file);
  if (contains(manifest.library, "/")) return "ldd " + shell_word(file);
  if (manifest.library.starts_with("libvulkan_"))
    return "sudo apt-get install --reinstall mesa-vulkan-drivers";
  return "ldconfig -p | grep -F -- " + shell_word(manifest.library);
}

std::vector<Finding> check_manifests(const Facts& facts) {
  if (!facts.loader.fault.empty()) return {};
  if (facts.manifests.empty())
    return {
        {Level::error, "there is no Vulkan driver: no manifest (icd.d/*.json) was found", kInstallDriver}};
  std::vector<Finding> findings;
  std::vector<std::string> loaded;
  for (const ManifestFacts& manifest : facts.manifests) {
    if (!manifest.hidden_by.empty()) continue;  // a finding of driver-variables
    const std::string title = manifest.file + " (" + manifest.library + ")";
    // An unreadable file of VK_DRIVER_FILES is a finding of driver-variables.
    if (!manifest.fault.empty()) {
      if (manifest.variable.empty() || manifest.variable == "VK_ADD_DRIVER_FILES")
        findings.push_back(
            {Level::warning, "the driver manifest " + manifest.file + " is broken: " + manifest.fault, ""});
    } else if (manifest.load.passed()) {
      loaded.push_back(manifest.file + (manifest.variable.empty() ? "" : " (by " + manifest.variable + ")"));
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
    findings.insert(findings.begin(), {Level::ok, "driver libraries that load: " + joined(loaded), ""});
  }
  return findings;
}

// Implicit layers that break the listing of devices.
std::vector<Finding> check_broken_layers(const Facts& facts) {
  std::vector<Finding> findings;
  std::vector<std::string> names;
  for (const LayerFacts& layer : facts.implicit_layers) {
    names.push_back(layer.name);
    if (layer.listing.went_wrong())
      findings.push_back({Level::error,
                          "listing the Vulkan devices " + describe(layer.listing) +
                              " by the implicit layer " + layer.name + " of " + layer.file +
                              ", and fire3dv with it",
                          layers_off_line({layer})});
  }
  if (findings.empty())
    findings.push_back({Level::error,
                        "listing the Vulkan devices " + describe(facts.layered_listing) +
                            " by implicit layers together, and fire3dv with it: " + joined(names),
                        layers_off_line(facts.implicit_layers)});
  return findings;
}

std::vector<Finding> check_layers(const Facts& facts) {
  if (facts.implicit_layers.empty()) return {};
  if (facts.layered_listing.went_wrong()) return check_broken_layers(facts);
  // Mesa installs this one with its drivers; it only orders the devices.
  constexpr std::string_view kHarmless = "VK_LAYER_MESA_device_select";
  std::vector<std::string> names;
  bool harmless = true;
  for (const LayerFacts& layer : facts.implicit_layers) {
    names.push_back(layer.name);
    harmless = harmless && layer.name == kHarmless;
  }
  if (harmless) return {{Level::ok, "the only implicit Vulkan layer is Mesa's, which orders devices", ""}};
  return {{Level::note, "implicit Vulkan layers are active, and may change or break images: " + joined(names),
           layers_off_line(facts.implicit_layers)}};
}

std::string nvidia_major(const Facts& facts) {
  return facts.nvidia_driver.substr(0, facts.nvidia_driver.find('.'));
}

// CUDA or its device nodes are there, and no Vulkan device of NVIDIA.
std::vector<Finding> check_nvidia(const Facts& facts) {
  const bool has_gpu = !facts.nvidia_nodes.empty() || !facts.cuda_devices.empty();
  const bool draws = std::any_of(facts.devices.begin(), facts.devices.end(),
                                 [](const DeviceFacts& d) { return d.vendor_id == gpu::kNvidia; });
  if (!has_gpu || facts.wsl || facts.replaces_drivers()) return {};
  if (draws) return {{Level::ok, "NVIDIA's GPU is there for Vulkan, too", ""}};
  const std::string seen = !facts.cuda_devices.empty() ? "CUDA works" : "NVIDIA's device nodes are there";
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
  // Otherwise other findings say what is wrong.
  if (!manifest->load.passed() || !manifest->hidden_by.empty() || !facts.loader.fault.empty() ||
      facts.listing.ended_badly())
    return {};
  // Seen on a server: the driver loads its X11 and OpenGL libraries itself, and is silent about missing ones.
  return {{Level::error,
           seen +
               ", and NVIDIA's Vulkan driver loads, but lists no device: libraries that it loads itself are "
               "missing, or libnvidia-glvkspirv is",
           "sudo apt-get install libgl1 libegl1 libxext6"}};
}

std::vector<Finding> check_wsl(const Facts& facts) {
  if (!facts.wsl) return {};
  const auto software =
      std::find_if(facts.manifests.begin(), facts.manifests.end(),
                   [](const ManifestFacts& manifest) { return contains(manifest.library, "vulkan_lvp"); });
  return {
      {Level::warning,
       "this is WSL 2: its GPU driver (Mesa's dzn) is not a conformant Vulkan implementation, and FIRE-3DV "
       "was not tried with it; the software driver draws, and Mesa's device-select layer can crash",
       "export NODEVICE_SELECT=1" + (software == facts.manifests.end()
                                         ? ""
                                         : " " + assignment(facts.drivers_variable(), software->file))}};
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
