// Tests of the checks of loader, manifests, variables, layers, containers and WSL.
#include <gtest/gtest.h>

#include <set>

#include "tests/unit/renderer/doctor/machines.h"

namespace fire3dv::doctor {
namespace {

TEST(DoctorChecks, GoodMachinesHaveNoFaults) {
  EXPECT_EQ(exit_status(run_checks(good_machine())), 0);
  EXPECT_TRUE(ids(good_machine(), Level::warning).empty());
  EXPECT_TRUE(ids(good_machine(), Level::note).empty());
  EXPECT_EQ(exit_status(run_checks(software_machine())), 0);
  EXPECT_EQ(ids(software_machine(), Level::note), std::vector<std::string>{"software-device"});
}

TEST(DoctorChecks, IdsAreUnique) {
  std::set<std::string> seen;
  for (const Check& check : all_checks()) EXPECT_TRUE(seen.insert(check.id).second) << check.id;
  EXPECT_GE(seen.size(), 20u);
}

TEST(DoctorChecks, FaultsOfAnEmptyMachineAreNamed) {
  EXPECT_EQ(exit_status(run_checks(Facts{})), 1);
}

TEST(DriverChecks, AMissingLoaderIsTheFirstError) {
  Facts facts = software_machine();
  facts.loader.fault = "libvulkan.so.1: cannot open shared object file";
  facts.manifests.clear();
  facts.devices.clear();
  facts.chosen.reset();
  EXPECT_EQ(ids(facts, Level::error), std::vector<std::string>{"loader"});
  EXPECT_TRUE(mentions(fault(facts, "loader").fix, "apt-get install --reinstall libvulkan1"));
  facts.loader.override_file = "/opt/lib/libvulkan.so.1";
  EXPECT_TRUE(mentions(fault(facts, "loader").text, "LD_LIBRARY_PATH leads to \"/opt/lib/libvulkan.so.1\""));
  EXPECT_EQ(fault(facts, "loader").fix, "unset LD_LIBRARY_PATH");
}

TEST(DriverChecks, WithoutExperimentsThatIsTheOnlyError) {
  Facts facts = good_machine();
  facts.experiments_fault = "no process can be started: Resource temporarily unavailable";
  facts.loader = {};
  facts.manifests.clear();
  facts.devices.clear();
  facts.chosen.reset();
  facts.cuda = {};
  EXPECT_EQ(ids(facts, Level::error), std::vector<std::string>{"experiments"});
  EXPECT_TRUE(mentions(fault(facts, "experiments").fix, "ulimit -u"));
  facts.experiments_fault = "no pipe can be opened: Too many open files";
  EXPECT_TRUE(mentions(fault(facts, "experiments").fix, "ulimit -n"));
}

TEST(DriverChecks, DriversThatLackFilesNeedNoPackage) {
  Facts facts = software_machine();
  facts.open_files_limit = 5;
  facts.manifests[0].load = {Outcome::failed, "lvp.so: cannot open shared object file: Too many open files"};
  facts.devices.clear();
  facts.chosen.reset();
  EXPECT_EQ(fault(facts, "driver-manifests").fix, "ulimit -n 1024");
  EXPECT_EQ(fault(facts, "devices").fix, "ulimit -n 1024");
}

TEST(DriverChecks, AnOldLoaderIsAnError) {
  Facts facts = good_machine();
  facts.loader.version = 1u << 22 | 2u << 12 | 131u;
  EXPECT_TRUE(mentions(fault(facts, "loader").text, "1.2.131 is older than 1.3"));
  EXPECT_EQ(fault(facts, "loader").fix, "sudo apt-get install libvulkan1");
  facts.loader.override_file = "/opt/lib/libvulkan.so.1";
  EXPECT_TRUE(mentions(fault(facts, "loader").text, "LD_LIBRARY_PATH leads to \"/opt/lib/libvulkan.so.1\""));
  EXPECT_EQ(fault(facts, "loader").fix, "unset LD_LIBRARY_PATH");
}

TEST(DriverChecks, NoManifestIsAnError) {
  Facts facts = software_machine();
  facts.manifests.clear();
  EXPECT_EQ(fault(facts, "driver-manifests").level, Level::error);
  EXPECT_TRUE(mentions(fault(facts, "driver-manifests").fix, "mesa-vulkan-drivers"));
  EXPECT_TRUE(mentions(fault(facts, "driver-manifests").fix, "install the file fire3dv_cpu-*.whl, too"));
}

TEST(DriverChecks, ALibraryThatDoesNotLoadIsNamedWithItsReason) {
  Facts facts = good_machine();
  facts.manifests[1].load = {Outcome::failed,
                             "libLLVM-15.so.1: cannot open shared object file: No such file"};
  const Finding one = fault(facts, "driver-manifests");
  EXPECT_EQ(one.level, Level::warning);
  EXPECT_TRUE(mentions(one.text, "lvp_icd.json") && mentions(one.text, "libLLVM-15.so.1")) << one.text;
  EXPECT_TRUE(mentions(one.fix, "--reinstall mesa-vulkan-drivers")) << one.fix;
  facts.manifests[1].library = "../lib/lvp.so";
  EXPECT_EQ(fault(facts, "driver-manifests").fix, "ldd /usr/share/vulkan/icd.d/../lib/lvp.so");
  facts.manifests.erase(facts.manifests.begin());
  EXPECT_EQ(fault(facts, "driver-manifests").level, Level::error);
  facts.manifests[0].load = {Outcome::crashed, "SIGSEGV"};
  EXPECT_TRUE(mentions(fault(facts, "driver-manifests").text, "crashes (SIGSEGV)"));
}

TEST(DriverChecks, DriversOf32BitProgramsAreNoFault) {
  Facts facts = good_machine();
  facts.manifests.push_back({"/usr/share/vulkan/icd.d/lvp_icd.i686.json",
                             "",
                             "/usr/lib/i386-linux-gnu/lvp.so",
                             "",
                             {Outcome::failed, "wrong ELF class: ELFCLASS32"}});
  EXPECT_EQ(fault(facts, "driver-manifests").level, Level::note);
}

TEST(DriverChecks, DriverVariablesThatLeadNowhereAreErrors) {
  Facts facts = software_machine();
  facts.environment["VK_DRIVER_FILES"] = "/nowhere.json";
  facts.manifests = {{"/nowhere.json", "VK_DRIVER_FILES", "", "it does not exist", {}}};
  const Finding missing = fault(facts, "driver-variables");
  EXPECT_EQ(missing.level, Level::error);
  EXPECT_TRUE(mentions(missing.text, "VK_DRIVER_FILES names \"/nowhere.json\": it does not exist"));
  EXPECT_TRUE(mentions(missing.fix, "unset VK_DRIVER_FILES"));
  facts.environment["VK_DRIVER_FILES"] = ":";
  facts.manifests.clear();
  EXPECT_TRUE(mentions(fault(facts, "driver-variables").text, "names no driver manifest"));
  facts.environment["VK_DRIVER_FILES"] = "";
  EXPECT_EQ(fault(facts, "driver-variables").level, Level::ok);
  facts.devices.clear();
  facts.chosen.reset();
  EXPECT_TRUE(mentions(fault(facts, "driver-variables").text, "VK_DRIVER_FILES is set, but empty"));
  facts.environment["VK_DRIVER_FILES"] = "/lvp.json";
  facts.manifests = {{"/lvp.json", "VK_DRIVER_FILES", "lvp.so", "", {Outcome::passed, ""}}};
  EXPECT_EQ(fault(facts, "driver-variables").level, Level::note);
}

TEST(DriverChecks, AnOldLoaderIgnoresAddedDrivers) {
  Facts facts = software_machine();
  facts.environment["VK_ADD_DRIVER_FILES"] = "/wheel/lvp.json";
  facts.loader.version = make_version(1, 3, 204);
  EXPECT_TRUE(
      mentions(fault(facts, "driver-variables").text, "ignores the environment variable VK_ADD_DRIVER"));
  EXPECT_EQ(fault(facts, "driver-variables").fix,
            "export VK_ICD_FILENAMES=/wheel/lvp.json:/usr/share/vulkan/icd.d/lvp_icd.json")
      << "drivers of the system stay";
  facts.environment = {{"VK_DRIVER_FILES", "/my drivers/lvp.json"}};
  EXPECT_FALSE(facts.replaces_drivers());
  EXPECT_EQ(fault(facts, "driver-variables").level, Level::warning);
  EXPECT_TRUE(mentions(fault(facts, "driver-variables").text,
                       "1.3.204 ignores the environment variable VK_DRIVER_FILES"));
  EXPECT_EQ(fault(facts, "driver-variables").fix, "export VK_ICD_FILENAMES='/my drivers/lvp.json'");
  facts.environment = {{"VK_LOADER_DRIVERS_SELECT", "*nvidia*"}};
  EXPECT_TRUE(mentions(fault(facts, "driver-variables").text, "1.3.234 reads it"));
  facts.environment.clear();
  facts.wsl = true;
  EXPECT_EQ(fault(facts, "wsl").fix,
            "export NODEVICE_SELECT=1 VK_ICD_FILENAMES=/usr/share/vulkan/icd.d/lvp_icd.json");
}

TEST(DriverChecks, FiltersOfDriversNameWhatTheyHide) {
  Facts facts = good_machine();
  facts.environment["VK_LOADER_DRIVERS_DISABLE"] = "*nvidia*";
  facts.manifests[0].hidden_by = "VK_LOADER_DRIVERS_DISABLE";
  EXPECT_EQ(fault(facts, "driver-variables").level, Level::note);
  EXPECT_TRUE(mentions(
      fault(facts, "driver-variables").text,
      "VK_LOADER_DRIVERS_DISABLE (\"*nvidia*\") hides drivers: /usr/share/vulkan/icd.d/nvidia_icd.json"));
  facts.manifests[1].hidden_by = "VK_LOADER_DRIVERS_DISABLE";
  EXPECT_EQ(fault(facts, "driver-variables").level, Level::error);
  EXPECT_EQ(fault(facts, "driver-manifests").level, Level::ok);
  facts.manifests[0].hidden_by = facts.manifests[1].hidden_by = "";
  EXPECT_EQ(fault(facts, "driver-variables").level, Level::ok) << "it hides nothing";
}

TEST(DriverChecks, LinesAreQuotedForAShell) {
  Facts facts = software_machine();
  facts.manifests[0].load = {Outcome::failed, "x.so: cannot open shared object file"};
  facts.manifests[0].library = "x;reboot.so";
  EXPECT_EQ(fault(facts, "driver-manifests").fix, "ldconfig -p | grep -F -- 'x;reboot.so'");
  facts.manifests[0].library = "/a b/$(reboot).so";
  EXPECT_EQ(fault(facts, "driver-manifests").fix, "ldd '/a b/$(reboot).so'");
  facts.manifests[0].load = {Outcome::hung, ""};
  EXPECT_EQ(fault(facts, "driver-manifests").fix,
            "ls -lL /usr/share/vulkan/icd.d/lvp_icd.json '/a b/$(reboot).so'");
}

TEST(DriverChecks, ForeignImplicitLayersAreNoted) {
  Facts facts = good_machine();
  facts.implicit_layers = {{"VK_LAYER_MESA_device_select", "/a.json"}};
  EXPECT_EQ(fault(facts, "implicit-layers").level, Level::ok);
  facts.implicit_layers.push_back({"VK_LAYER_NV_optimus", "/b.json"});
  EXPECT_TRUE(mentions(fault(facts, "implicit-layers").text, "VK_LAYER_NV_optimus"));
}

TEST(DriverChecks, LayersThatBreakTheListingAreNamed) {
  Facts facts = good_machine();
  facts.implicit_layers = {{"VK_LAYER_a", "/a.json", "NO_A", "1", {}},
                           {"VK_LAYER_b", "/b.json", "NO_B", "a b", {}}};
  facts.layered_listing = {Outcome::hung, ""};
  EXPECT_TRUE(mentions(fault(facts, "implicit-layers").text, "hangs by implicit layers together"));
  EXPECT_EQ(fault(facts, "implicit-layers").fix, "export NO_A=1 NO_B='a b'");
  facts.implicit_layers[1].listing = {Outcome::hung, ""};
  EXPECT_TRUE(
      mentions(fault(facts, "implicit-layers").text, "hangs by the implicit layer VK_LAYER_b of /b.json"));
  EXPECT_EQ(fault(facts, "implicit-layers").fix, "export NO_B='a b'");
  EXPECT_EQ(ids(facts, Level::error), std::vector<std::string>{"implicit-layers"});
}

Facts cuda_without_vulkan() {
  Facts facts = software_machine();
  facts.nvidia_nodes = good_machine().nvidia_nodes;
  facts.cuda = {Outcome::passed, ""};
  facts.cuda_devices = good_machine().cuda_devices;
  facts.nvidia_driver = "580.65.06";
  return facts;
}

TEST(DriverChecks, CudaWithoutADeviceIsNoGpu) {
  Facts facts = software_machine();
  facts.cuda = {Outcome::passed, ""};
  EXPECT_TRUE(ids(facts, Level::error).empty());
  EXPECT_TRUE(mentions(fault(facts, "software-device").text, "no GPU that is visible"));
}

TEST(DriverChecks, AListingThatBreaksSaysNothingOfNvidiasLibraries) {
  Facts facts = good_machine();
  facts.devices.clear();
  facts.chosen.reset();
  facts.environment["VK_ICD_FILENAMES"] = "";
  for (const Trial& trial : {Trial{Outcome::hung, ""}, Trial{Outcome::crashed, "SIGSEGV"}}) {
    facts.listing = trial;
    EXPECT_EQ(ids(facts, Level::error), std::vector<std::string>{"devices"});
  }
  facts.listing = {Outcome::passed, ""};
  facts.environment.erase("VK_ICD_FILENAMES");
  EXPECT_TRUE(mentions(fault(facts, "nvidia-without-vulkan").text, "loads, but lists no device"));
  facts.manifests[0].hidden_by = "VK_LOADER_DRIVERS_DISABLE";
  facts.environment["VK_LOADER_DRIVERS_DISABLE"] = "*nvidia*";
  EXPECT_EQ(fault(facts, "nvidia-without-vulkan").level, Level::ok);
}

TEST(DriverChecks, AContainerWithCudaAloneGetsItsLine) {
  Facts facts = cuda_without_vulkan();
  facts.container = true;
  facts.environment["NVIDIA_DRIVER_CAPABILITIES"] = "compute,utility";
  const Finding found = fault(facts, "nvidia-without-vulkan");
  EXPECT_EQ(found.level, Level::error);
  EXPECT_TRUE(mentions(found.text, "NVIDIA_DRIVER_CAPABILITIES is \"compute,utility\"")) << found.text;
  EXPECT_TRUE(mentions(found.fix, "-e NVIDIA_DRIVER_CAPABILITIES=all"));
}

TEST(DriverChecks, DriversThatAreReplacedAreNoFaultOfNvidias) {
  Facts facts = cuda_without_vulkan();
  facts.environment["VK_DRIVER_FILES"] = facts.manifests[0].file;
  facts.manifests[0].variable = "VK_DRIVER_FILES";
  EXPECT_TRUE(ids(facts, Level::error).empty());
  EXPECT_TRUE(mentions(fault(facts, "software-device").fix, "unset VK_DRIVER_FILES"));
}

TEST(DriverChecks, AHostWithCudaAloneGetsAPackage) {
  Facts facts = cuda_without_vulkan();
  EXPECT_TRUE(mentions(fault(facts, "nvidia-without-vulkan").fix, "nvidia-vulkan-icd"));
  facts.system = "Ubuntu 24.04.1 LTS";
  EXPECT_TRUE(mentions(fault(facts, "nvidia-without-vulkan").fix, "libnvidia-gl-580"));
}

TEST(DriverChecks, ALibraryThatNvidiasDriverMissesGetsItsPackage) {
  Facts facts = cuda_without_vulkan();
  facts.container = true;
  facts.manifests.push_back(
      {"/etc/vulkan/icd.d/nvidia_icd.json",
       "",
       "libGLX_nvidia.so.0",
       "",
       {Outcome::failed, "libXext.so.6: cannot open shared object file: No such file"}});
  EXPECT_EQ(fault(facts, "nvidia-without-vulkan").fix, "sudo apt-get install libxext6");
  facts.manifests.back().load.detail = "it has no vkCreateInstance without libEGL.so.1, libGLdispatch.so.0";
  EXPECT_EQ(fault(facts, "nvidia-without-vulkan").fix, "sudo apt-get install libegl1");
  EXPECT_TRUE(
      mentions(fault(facts, "nvidia-without-vulkan").text, "no vkCreateInstance without libEGL.so.1"));
  facts.manifests.back().load.detail = "it has no vkCreateInstance without libEGL.so.1, libX11.so.6";
  EXPECT_EQ(fault(facts, "driver-manifests").fix, "sudo apt-get install libegl1 libxext6");
  facts.manifests.back().load.detail = "libGLX_nvidia.so.0: cannot open shared object file: No such file";
  EXPECT_TRUE(mentions(fault(facts, "nvidia-without-vulkan").fix, "NVIDIA_DRIVER_CAPABILITIES=all"));
  facts.manifests.back().load = {Outcome::passed, ""};
  EXPECT_TRUE(mentions(fault(facts, "nvidia-without-vulkan").fix, "libgl1 libegl1 libxext6"));
}

TEST(DriverChecks, WslIsRecognised) {
  Facts facts = software_machine();
  facts.wsl = true;
  EXPECT_TRUE(mentions(fault(facts, "wsl").text, "dzn"));
  EXPECT_TRUE(mentions(fault(facts, "wsl").fix, "NODEVICE_SELECT=1"));
}

}  // namespace
}  // namespace fire3dv::doctor
