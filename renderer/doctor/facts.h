// Facts about a machine that the checks of `fire3dv doctor` read: plain values, so that tests need no such
// machine. gather.h fills them in.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "renderer/doctor/loader_rules.h"

namespace fire3dv::doctor {

// Outcome of an experiment in a child process.
enum class Outcome {
  not_tried,
  passed,
  failed,   // with an error
  crashed,  // ended by a signal
  hung,     // did not end within the time limit, and was killed
};
struct Trial {
  Outcome outcome = Outcome::not_tried;
  std::string detail;  // the error, the signal's name, or the time limit

  bool passed() const { return outcome == Outcome::passed; }
  bool went_wrong() const { return !passed() && outcome != Outcome::not_tried; }
  bool ended_badly() const { return outcome == Outcome::hung || outcome == Outcome::crashed; }
};

// The Vulkan loader, libvulkan.so.1.
struct LoaderFacts {
  std::string fault;          // why it cannot be used; empty: it can
  std::string file;           // empty: unknown
  uint32_t version = 0;       // as VK_MAKE_API_VERSION
  std::string override_file;  // the first one in a folder of LD_LIBRARY_PATH; empty: none

  // Of a version constant of loader_rules.h. True for an unknown loader.
  bool reads(uint32_t since) const { return version == 0 || version >= since; }
};

// Manifest of a Vulkan driver (JSON) that the loader reads.
struct ManifestFacts {
  std::string file;
  std::string variable;   // environment variable that names it; empty: found in a folder of the system
  std::string library;    // its library_path
  std::string fault;      // why the manifest itself cannot be read; empty: it can
  Trial load;             // dlopen of the library; detail: the text of dlerror()
  Trial listing;          // of its devices alone; tried where the listing of all of them breaks
  std::string hidden_by;  // environment variable that filters it out; empty: none
};

struct LayerFacts {
  std::string name;  // VK_LAYER_...
  std::string file;
  std::string variable, value;  // of the environment, that switch it off
  Trial listing;  // of the devices with this implicit layer alone; tried where their listing with all breaks
};

// Vulkan device, as fire3dv --list-devices numbers them.
struct DeviceFacts {
  uint32_t index = 0;
  std::string name;
  std::string driver;                // name and version
  std::string type;                  // "discrete GPU", ..., "software"
  std::string uuid;                  // 8-4-4-4-12 hexadecimal digits
  std::string pci_address;           // DDDD:BB:DD.F; empty: none
  uint32_t vendor_id = 0;            // PCI
  std::vector<std::string> missing;  // required features that it lacks
  bool ray_query = false;
  bool ray_tracing_pipeline = false;
  Trial read_back;                 // 64x64 pixels, cleared and copied to the CPU
  Trial read_back_without_layers;  // tried where that goes wrong, and there are implicit layers
  Trial ray;                       // one ray against one triangle; not tried: the device claims no ray query

  bool usable() const { return missing.empty(); }
  bool software() const { return type == "software"; }
};

struct CudaDeviceFacts {
  uint32_t index = 0;      // after CUDA_VISIBLE_DEVICES
  std::string name, uuid;  // in the forms of DeviceFacts
  bool mig = false;        // an instance of MIG: a part of a GPU
};

// A device node that this user should be able to read and write.
struct NodeFacts {
  std::string path;
  std::string group;  // name of its group; empty: unknown
  bool accessible = false;
  uint32_t mode = 0660;  // permission bits
  uint32_t gid = 0;      // number of its group

  bool group_may() const { return (mode & 0060) == 0060; }
};

struct PortFacts {
  std::string option;  // "--listen tcp://127.0.0.1:5000"
  std::string fault;   // why it cannot be opened; empty: it can
  bool in_use = false;
};

struct Facts {
  std::map<std::string, std::string> environment;  // the variables that are set

  // Why no child process can be started; then nothing of drivers and devices is known. Empty: it can.
  std::string experiments_fault;
  LoaderFacts loader;
  std::vector<ManifestFacts> manifests;
  std::vector<LayerFacts> implicit_layers;  // active ones
  Trial listing;                            // of the devices by all drivers
  // The same with implicit layers, where those are the fault: then all else was tried without them.
  Trial layered_listing;
  std::vector<DeviceFacts> devices;
  std::optional<uint32_t> chosen;  // index of the device that fire3dv takes by itself

  std::vector<std::string> gpu_vendors;  // of the machine's GPUs by PCI: "AMD", "Intel", "NVIDIA"
  std::vector<NodeFacts> render_nodes;   // /dev/dri/renderD*
  std::vector<NodeFacts> nvidia_nodes;   // /dev/nvidia0, ..., /dev/nvidiactl
  std::string nvidia_driver;             // version of the kernel's driver; empty: none
  Trial cuda;                            // libcuda loads and lists devices, if any; not tried: there is none
  std::vector<CudaDeviceFacts> cuda_devices;
  bool container = false;
  bool wsl = false;    // Windows Subsystem for Linux
  std::string system;  // "Debian GNU/Linux 12 (bookworm)"; empty: unknown

  enum class SharedMemory { missing, read_only, not_writable, writable };
  SharedMemory shared_memory = SharedMemory::writable;
  uint64_t shared_memory_bytes = 0;  // size of /dev/shm
  uint64_t shared_memory_free_bytes = 0;

  std::string cache_folder;  // empty: nothing names one
  std::string cache_fault;   // why it cannot be written; empty: it can
  std::string display;       // value of WAYLAND_DISPLAY or DISPLAY; empty: none
  std::string display_fault;
  std::string display_host;  // of an X11 display that is reached over TCP; empty: a socket of this machine
  uint16_t display_port = 0;

  uint64_t open_files_limit = 0;     // soft limits
  uint64_t locked_memory_bytes = 0;  // UINT64_MAX: unlimited
  uint64_t address_space_bytes = UINT64_MAX;
  std::vector<PortFacts> ports;

  // Drivers, links and 64 peers need these.
  static constexpr uint64_t kOpenFiles = 256;
  bool has_few_files() const { return open_files_limit < kOpenFiles; }
  // The environment variable that replaces the drivers of the system; empty: none.
  std::string replacing_variable() const {
    if (loader.reads(kReadsDriverFiles) && !variable("VK_DRIVER_FILES").empty()) return "VK_DRIVER_FILES";
    return variable("VK_ICD_FILENAMES").empty() ? "" : "VK_ICD_FILENAMES";
  }
  bool replaces_drivers() const { return !replacing_variable().empty(); }
  // The variable that this loader reads, for lines to type.
  std::string drivers_variable() const {
    return loader.reads(kReadsDriverFiles) ? "VK_DRIVER_FILES" : "VK_ICD_FILENAMES";
  }
  // Value of an environment variable; empty: not set.
  std::string variable(const std::string& name) const {
    const auto found = environment.find(name);
    return found == environment.end() ? "" : found->second;
  }
};

}  // namespace fire3dv::doctor
