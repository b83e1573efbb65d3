// Test of --require-gpu, without a device.
#include "renderer/gpu/selection/required_gpu.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace fire3dv::gpu {
namespace {

DeviceReport device(uint32_t index, const char* name, DeviceType type,
                    std::vector<std::string> missing = {}) {
  DeviceReport report;
  report.index = index;
  report.name = name;
  report.type = type;
  report.missing = std::move(missing);
  return report;
}

const std::vector<DeviceReport> kBoth{device(0, "llvmpipe", DeviceType::software),
                                      device(1, "iGPU", DeviceType::integrated)};

std::string refusal(const std::vector<DeviceReport>& reports, std::string_view wanted,
                    std::string_view list = {}, const HostFacts& host = {}) {
  const Result<void> checked = check_required_gpu(reports, wanted, list, host);
  return checked ? "" : checked.error().message;
}

TEST(RequiredGpu, GpuIsEnough) {
  EXPECT_EQ(refusal(kBoth, ""), "");
  EXPECT_EQ(refusal(kBoth, "igpu"), "");
  EXPECT_EQ(refusal(kBoth, "", "all"), "");
}

TEST(RequiredGpu, SoftwareDeviceIsRefused) {
  const HostFacts with_gpu{{0x10de}, {}, {}};
  const std::string text = refusal({device(0, "llvmpipe", DeviceType::software)}, "", {}, with_gpu);
  EXPECT_NE(text.find("--require-gpu: no GPU can draw here"), std::string::npos) << text;
  EXPECT_NE(text.find("there is a GPU by NVIDIA"), std::string::npos) << text;
  EXPECT_NE(refusal(kBoth, "llvm").find("llvmpipe was requested"), std::string::npos);
  EXPECT_NE(refusal(kBoth, "", "1,0").find("llvmpipe was requested"), std::string::npos);
}

TEST(RequiredGpu, NoUsableDeviceIsRefused) {
  EXPECT_NE(refusal({}, "").find("no Vulkan device found"), std::string::npos);
  EXPECT_NE(refusal({device(0, "Old GPU", DeviceType::discrete, {"Vulkan 1.3"})}, "").find("Vulkan 1.3"),
            std::string::npos);
}

TEST(RequiredGpu, UnmatchedRequestIsLeftToTheChoice) {
  EXPECT_EQ(refusal(kBoth, "Voodoo"), "");
}

}  // namespace
}  // namespace fire3dv::gpu
