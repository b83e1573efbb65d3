// Tests of the checks of Vulkan and CUDA devices.
#include <gtest/gtest.h>

#include "tests/unit/renderer/doctor/machines.h"

namespace fire3dv::doctor {
namespace {

TEST(DeviceChecks, ADriverThatHangsOrCrashesIsNamed) {
  Facts facts = good_machine();
  facts.devices.clear();
  facts.chosen.reset();
  facts.listing = {Outcome::hung, ""};
  EXPECT_TRUE(mentions(fault(facts, "devices").text, "listing the Vulkan devices hangs"));
  facts.listing = {Outcome::crashed, "SIGSEGV"};
  EXPECT_TRUE(mentions(fault(facts, "devices").text, "crashes (SIGSEGV)"));
  facts.manifests[0].listing = {Outcome::crashed, "SIGSEGV"};
  facts.manifests[1].listing = {Outcome::passed, ""};
  EXPECT_TRUE(mentions(fault(facts, "devices").text,
                       "the driver of /usr/share/vulkan/icd.d/nvidia_icd.json crashes"));
  EXPECT_EQ(fault(facts, "devices").fix, "export VK_DRIVER_FILES=/usr/share/vulkan/icd.d/lvp_icd.json");
  facts.loader.version = make_version(1, 3, 204);
  EXPECT_EQ(fault(facts, "devices").fix, "export VK_ICD_FILENAMES=/usr/share/vulkan/icd.d/lvp_icd.json");
  facts.manifests[0].load = {Outcome::hung, ""};
  EXPECT_TRUE(mentions(fault(facts, "devices").text, "nvidia_icd.json hangs when it is loaded"));
  facts.listing = {Outcome::passed, ""};
  EXPECT_TRUE(mentions(fault(facts, "devices").text, "no driver lists a Vulkan device"));
}

TEST(DeviceChecks, TheReasonOfAFailedListingIsNamed) {
  Facts facts = software_machine();
  facts.devices.clear();
  facts.chosen.reset();
  facts.listing = {Outcome::failed, "cannot create a Vulkan instance: out of host memory; install a driver"};
  EXPECT_EQ(fault(facts, "devices").text,
            "no driver lists a Vulkan device, so nothing can draw: cannot create a Vulkan instance: out of "
            "host memory");
  facts.environment["VK_DRIVER_FILES"] = "";
  EXPECT_EQ(fault(facts, "devices").fix, "unset VK_DRIVER_FILES VK_ICD_FILENAMES");
  facts.listing.detail = "FIRE3DV_DEVICE_MASK: unknown word \"x\"";
  EXPECT_EQ(fault(facts, "devices").fix, "unset FIRE3DV_DEVICE_MASK");
}

TEST(DeviceChecks, AReadBackThatLayersBreakIsTheirs) {
  Facts facts = software_machine();
  facts.implicit_layers = {{"VK_LAYER_a", "/a.json", "NO_A", "1", {}}};
  facts.devices[0].read_back = {Outcome::crashed, "SIGSEGV"};
  facts.devices[0].ray = {};
  facts.devices[0].read_back_without_layers = {Outcome::passed, ""};
  EXPECT_TRUE(
      mentions(fault(facts, "read-back").text, "crashes (SIGSEGV); without implicit layers it works"));
  EXPECT_EQ(fault(facts, "read-back").fix, "export NO_A=1");
}

TEST(DeviceChecks, CudaThatFailsIsNoted) {
  Facts facts = good_machine();
  facts.cuda = {Outcome::failed, "cuInit returned CUDA_ERROR_SYSTEM_DRIVER_MISMATCH (803)"};
  facts.cuda_devices.clear();
  EXPECT_TRUE(mentions(fault(facts, "cuda-order").text, "since CUDA fails: cuInit returned"));
}

TEST(DeviceChecks, OldMesaGetsBackportsOnDebian12) {
  Facts facts = software_machine();
  facts.system = "Debian GNU/Linux 12 (bookworm)";
  facts.devices[0].driver = "llvmpipe Mesa 22.3.6 (LLVM 15.0.6)";
  facts.devices[0].missing = {"runtimeDescriptorArray"};
  facts.chosen.reset();
  const Finding found = fault(facts, "old-mesa");
  EXPECT_EQ(found.level, Level::error);
  EXPECT_TRUE(mentions(found.text, "Mesa 22.3 is too old")) << found.text;
  EXPECT_TRUE(mentions(found.fix, "bookworm-backports"));
}

TEST(DeviceChecks, OldMesaWithoutRayQueryIsAWarning) {
  Facts facts = software_machine();
  facts.devices[0].driver = "llvmpipe Mesa 24.0.1 (LLVM 17)";
  facts.devices[0].ray_query = false;
  EXPECT_TRUE(mentions(fault(facts, "old-mesa").text, "Mesa 24.0 draws without ray query"));
}

TEST(DeviceChecks, ASoftwareDeviceBesideAGpuIsAWarning) {
  Facts facts = software_machine();
  facts.gpu_vendors = {"AMD"};
  const Finding found = fault(facts, "software-device");
  EXPECT_EQ(found.level, Level::warning);
  EXPECT_TRUE(mentions(found.text, "although there is a GPU (AMD)"));
  EXPECT_TRUE(mentions(found.fix, "--require-gpu"));
}

TEST(DeviceChecks, ReadBackThatHangsNamesAnotherDevice) {
  Facts facts = good_machine();
  facts.devices[0].read_back = {Outcome::hung, ""};
  facts.devices[0].ray = {};
  const Finding found = fault(facts, "read-back");
  EXPECT_EQ(found.level, Level::error);
  EXPECT_TRUE(mentions(found.text, "device 0 (Big GPU) is listed, but opening it") &&
              mentions(found.text, "hangs"));
  EXPECT_EQ(found.fix, "fire3dv --device 1 FILE");
}

TEST(DeviceChecks, ASlowSoftwareDeviceMayBeOfABusyMachine) {
  Facts facts = software_machine();
  facts.devices[0].ray = {Outcome::hung, "20 s"};
  EXPECT_TRUE(mentions(fault(facts, "ray-tracing").text, "hangs (for more than 20 s)"));
  EXPECT_TRUE(mentions(fault(facts, "ray-tracing").fix, "fire3dv doctor --time-limit 300"));
  facts = good_machine();
  facts.devices[0].ray = {Outcome::hung, "20 s"};
  EXPECT_EQ(fault(facts, "ray-tracing").fix, "fire3dv --shadows map FILE");
}

TEST(DeviceChecks, RaysThatCrashFallBackToShadowMaps) {
  Facts facts = good_machine();
  facts.devices[0].ray = {Outcome::crashed, "SIGABRT"};
  const Finding found = fault(facts, "ray-tracing");
  EXPECT_TRUE(mentions(found.text, "claims ray tracing, but tracing one ray crashes (SIGABRT)"));
  EXPECT_EQ(found.fix, "fire3dv --shadows map FILE");
}

TEST(DeviceChecks, CudaInAnotherOrderIsNoted) {
  Facts facts = good_machine();
  DeviceFacts second = facts.devices[0];
  second.index = 2;
  second.uuid = "ffffffff-0506-0708-090a-0b0c0d0e0f10";
  second.pci_address = "0000:af:00.0";
  facts.devices.push_back(second);
  facts.cuda_devices = {{0, "Big GPU", second.uuid, false}, {1, "Big GPU", facts.devices[0].uuid, false}};
  EXPECT_TRUE(mentions(fault(facts, "cuda-order").text, "cuda:0 is device 2, cuda:1 is device 0"));
  facts.cuda_devices = {{0, "Other", "", false}};
  EXPECT_TRUE(mentions(fault(facts, "cuda-order").text, "no Vulkan device is the same"));
}

TEST(DeviceChecks, MigIsNamed) {
  Facts facts = good_machine();
  facts.cuda_devices[0].mig = true;
  EXPECT_TRUE(mentions(fault(facts, "mig").text, "slices of MIG have no Vulkan"));
  facts = good_machine();
  facts.environment["CUDA_VISIBLE_DEVICES"] = "MIG-1234";
  EXPECT_EQ(fault(facts, "mig").level, Level::warning);
}

}  // namespace
}  // namespace fire3dv::doctor
