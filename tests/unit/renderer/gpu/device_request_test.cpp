// Tests of --device cuda:N, uuid:HEX and pci:ADDRESS, and of CUDA_VISIBLE_DEVICES, without a device.
#include "renderer/gpu/selection/device_request.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "renderer/gpu/selection/cuda_devices.h"
#include "renderer/gpu/selection/device_choice.h"

namespace fire3dv::gpu {
namespace {

const std::string kUuids[] = {"00112233-4455-6677-8899-aabbccddeeff", "a0a1a2a3-0000-0000-0000-000000000001",
                              "a0b1b2b3-0000-0000-0000-000000000002"};

// Three equal GPUs and a software device whose name looks like a form of requests.
std::vector<DeviceReport> four_devices() {
  std::vector<DeviceReport> reports(4);
  for (uint32_t i = 0; i < 4; ++i) {
    reports[i].index = i;
    reports[i].name = i < 3 ? "NVIDIA H200" : "llvmpipe cuda:0 pci:1 uuid:2";
    reports[i].type = i < 3 ? DeviceType::discrete : DeviceType::software;
    reports[i].vendor_id = i < 3 ? 0x10de : 0x10005;
    reports[i].uuid = i < 3 ? kUuids[i] : "6d657361-3235-2e30-2e37-2d327e627000";
    reports[i].pci_address = i < 3 ? "0000:" + std::to_string(60 + i) + ":00.0" : "";
  }
  return reports;
}

// CUDA's order is the reverse of Vulkan's.
HostFacts host(const char* visible = nullptr,
               std::vector<CudaDevice> devices = {
                   {"NVIDIA H200", kUuids[2]}, {"NVIDIA H200", kUuids[1]}, {"NVIDIA H200", kUuids[0]}}) {
  HostFacts facts;
  if (visible) facts.cuda_visible_devices = visible;
  facts.cuda_devices = [devices] { return CudaDevices{devices, {}}; };
  return facts;
}

HostFacts host_without_cuda(const char* visible = nullptr) {
  HostFacts facts = host(visible);
  facts.cuda_devices = [] { return CudaDevices{{}, "CUDA's driver library cannot be loaded (none)"}; };
  return facts;
}

uint32_t chosen(std::string_view wanted, const HostFacts& facts = host()) {
  return choose_device(four_devices(), wanted, facts)->index;
}

std::string error_of(std::string_view wanted, const HostFacts& facts = host()) {
  const Result<DeviceChoice> choice = choose_device(four_devices(), wanted, facts);
  return choice ? "chose " + std::to_string(choice->index) : choice.error().message;
}

TEST(DeviceRequest, CudaOrdinalIsMappedByUuid) {
  EXPECT_EQ(chosen("cuda:0"), 2u);
  EXPECT_EQ(chosen("CUDA:2"), 0u);
  EXPECT_EQ(chosen("cuda:0", host("1", {{"NVIDIA H200", kUuids[1]}})), 1u) << "CUDA itself left out the rest";
}

TEST(DeviceRequest, UuidTakesEveryCommonSpelling) {
  EXPECT_EQ(chosen("uuid:a0a1a2a3-0000-0000-0000-000000000001"), 1u);
  EXPECT_EQ(chosen("uuid:A0A1A2A3000000000000000000000001"), 1u);
  EXPECT_EQ(chosen("uuid:GPU-a0a1a2a3-0000-0000-0000-000000000001"), 1u);
}

TEST(DeviceRequest, PciAddressTakesEveryCommonSpelling) {
  EXPECT_EQ(chosen("pci:0000:61:00.0"), 1u);
  EXPECT_EQ(chosen("pci:61:00.0"), 1u);
  EXPECT_EQ(chosen("PCI:00000000:61:0.0"), 1u);
}

TEST(DeviceRequest, FormsHoldInLists) {
  const auto choices =
      choose_devices(four_devices(), "pci:0000:61:00.0,cuda:0,uuid:" + kUuids[0] + ",3", host());
  ASSERT_TRUE(choices.ok()) << choices.error().message;
  std::vector<uint32_t> indices;
  for (const DeviceChoice& choice : *choices) indices.push_back(choice.index);
  EXPECT_EQ(indices, (std::vector<uint32_t>{1, 2, 0, 3}));
}

TEST(DeviceRequest, FormsAreNeverPartOfAName) {
  for (const char* wrong : {"cuda:", "cuda:x", "cuda:-1", "cuda:0x1", "uuid:2", "uuid:", "pci:1",
                            "pci:", "pci:61:00", "pci:61:20.0", "pci:61:00.8", "pci:0:0:61:00.0"}) {
    const Result<DeviceRequest> request = parse_device_request(wrong);
    EXPECT_FALSE(request.ok()) << wrong;
    EXPECT_NE(error_of(wrong).find("--device " + std::string(wrong) + ": "), std::string::npos)
        << error_of(wrong);
  }
  EXPECT_EQ(chosen("pipe cuda"), 3u);  // without the colon it is a name
}

TEST(DeviceRequest, UnmatchedCudaOrdinalNamesTheCause) {
  EXPECT_NE(error_of("cuda:3").find("cuda:2: NVIDIA H200, uuid:" + kUuids[0]), std::string::npos)
      << error_of("cuda:3");
  EXPECT_NE(error_of("cuda:0", host("", {})).find("CUDA has no device (CUDA_VISIBLE_DEVICES=)"),
            std::string::npos);
  EXPECT_NE(error_of("cuda:0", host_without_cuda()).find("cannot be loaded"), std::string::npos);
  EXPECT_NE(error_of("cuda:0", HostFacts{}).find("there is no CUDA"), std::string::npos);
  const std::vector<CudaDevice> mig{{"NVIDIA H200 MIG 1g.18gb", kUuids[0], true}};
  EXPECT_NE(error_of("cuda:0", host(nullptr, mig)).find("MIG instance"), std::string::npos);
  const std::vector<CudaDevice> other{{"Tesla V100", "ffffffff-0000-0000-0000-000000000000"}};
  EXPECT_NE(error_of("cuda:0", host(nullptr, other)).find("no Vulkan driver serves it"), std::string::npos);
}

TEST(CudaVisibleDevices, FirstNamedGpuIsTheDefault) {
  EXPECT_EQ(chosen(""), 0u);
  for (const char* by_uuid : {"GPU-a0b1b2b3-0000-0000-0000-000000000002", "GPU-a0b", "gpu-A0B,GPU-0011"})
    EXPECT_EQ(chosen("", host_without_cuda(by_uuid)), 2u) << by_uuid << " needs no CUDA";
  EXPECT_EQ(chosen("", host("1,0", {{"NVIDIA H200", kUuids[1]}, {"NVIDIA H200", kUuids[0]}})), 1u);
  const auto choice = choose_device(four_devices(), "", host("0", {{"NVIDIA H200", kUuids[2]}}));
  EXPECT_EQ(choice->index, 2u);
  ASSERT_EQ(choice->notes.size(), 1u);
  EXPECT_NE(choice->notes[0].find("CUDA_VISIBLE_DEVICES=0 chooses device 2"), std::string::npos);
}

TEST(CudaVisibleDevices, WithoutAVulkanDeviceTheBestIsTakenAndSaid) {
  for (const char* none : {"", "-1", "NoDevFiles", "MIG-7a1", "GPU-ffff", "GPU-"}) {
    const auto choice = choose_device(four_devices(), "", host(none));
    EXPECT_EQ(choice->index, 0u) << none;
    ASSERT_EQ(choice->notes.size(), 1u) << none;
    EXPECT_NE(choice->notes[0].find("has no effect on the choice"), std::string::npos) << choice->notes[0];
  }
  EXPECT_EQ(chosen("", host_without_cuda("1")), 0u);
  EXPECT_EQ(chosen("1", host("GPU-a0b")), 1u) << "a request comes first";
}

TEST(CudaVisibleDevices, AllDevicesAreThoseNamed) {
  const auto choices = choose_devices(four_devices(), "all", host_without_cuda("GPU-a0b,GPU-a0a"));
  ASSERT_EQ(choices->size(), 2u);
  EXPECT_EQ((*choices)[0].index, 2u);
  EXPECT_EQ((*choices)[1].index, 1u);
}

TEST(CudaVisibleDevices, OneGpuNeedsNoCuda) {
  std::vector<DeviceReport> one{four_devices()[0]};
  HostFacts facts = host("0");
  facts.cuda_devices = []() -> CudaDevices { throw std::runtime_error("CUDA was initialised"); };
  const auto choice = choose_device(one, "", facts);
  EXPECT_TRUE(choice.ok());
  EXPECT_TRUE(choice->notes.empty());
}

TEST(CudaDevices, MissingLibraryIsAFailureWithItsReason) {
  const CudaDevices read = read_cuda_devices("libfire3dv_has_no_such_library.so.1");
  EXPECT_TRUE(read.devices.empty());
  EXPECT_NE(read.failure.find("libfire3dv_has_no_such_library"), std::string::npos) << read.failure;
  EXPECT_NE(read_cuda_devices("libm.so.6").failure.find("older than"), std::string::npos);
}

}  // namespace
}  // namespace fire3dv::gpu
