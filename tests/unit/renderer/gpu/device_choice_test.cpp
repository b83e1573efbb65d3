// Test of device selection, without a device.
#include "renderer/gpu/selection/device_choice.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "renderer/gpu/device/driver_files.h"

namespace fire3dv::gpu {
namespace {

DeviceReport report(uint32_t index, const char* name, DeviceType type,
                    std::vector<std::string> missing = {}) {
  DeviceReport r;
  r.index = index;
  r.name = name;
  r.driver = "driver 1.0";
  r.type = type;
  r.api_version = VK_API_VERSION_1_3;
  r.missing = std::move(missing);
  return r;
}

bool mentions(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

TEST(DeviceChoice, TheBestUsableDeviceWins) {
  const auto choice =
      choose_device({report(0, "llvmpipe", DeviceType::software), report(1, "iGPU", DeviceType::integrated),
                     report(2, "Big GPU", DeviceType::discrete)},
                    "");
  ASSERT_TRUE(choice.ok());
  EXPECT_EQ(choice->index, 2u);
  EXPECT_TRUE(choice->notes.empty());
}

TEST(DeviceChoice, OldMesaIsUpdated) {
  DeviceReport old = report(0, "llvmpipe", DeviceType::software, {"Vulkan 1.3"});
  old.driver = "llvmpipe Mesa 20.3.5";
  for (const char* wanted : {"", "llvmpipe"})
    EXPECT_TRUE(
        mentions(choose_device({old}, wanted).error().message, "apt-get install mesa-vulkan-drivers"));
  // Debian 12's: Vulkan 1.3, without what the renderer needs.
  old.driver = "llvmpipe Mesa 22.3.6 (LLVM 15.0.6)";
  old.missing = {"runtimeDescriptorArray"};
  for (const char* wanted : {"", "llvmpipe"}) {
    const std::string text = choose_device({old}, wanted).error().message;
    EXPECT_TRUE(mentions(text, "Mesa 22.3 is too old, 25 works")) << text;
    EXPECT_TRUE(mentions(text, "apt install -t bookworm-backports mesa-vulkan-drivers")) << text;
    EXPECT_TRUE(mentions(text, "docs/install.md")) << text;
  }
  old.driver = "llvmpipe Mesa 25.0.7";  // it lacks something else
  EXPECT_FALSE(mentions(choose_device({old}, "").error().message, "too old"));
  old.driver = "NVIDIA 450";
  EXPECT_FALSE(mentions(choose_device({old}, "").error().message, "apt-get"));
}

TEST(DeviceChoice, NoDriverNamesDriversToInstall) {
  const std::string text = choose_device({}, "").error().message;
  EXPECT_TRUE(mentions(text, "mesa-vulkan-drivers")) << text;
  EXPECT_TRUE(mentions(text, "install the file fire3dv_cpu-*.whl, too")) << text;
}

TEST(DriverFiles, VariablesThatLeadNowhereAreNamed) {
  std::map<std::string, std::string> set;
  const auto note = [&set] {
    return describe_driver_files([&set](const char* name) {
      const auto found = set.find(name);
      return found == set.end() ? nullptr : found->second.c_str();
    });
  };
  EXPECT_EQ(note(), "");
  set["VK_ICD_FILENAMES"] = "/nonexistent/a.json";
  EXPECT_EQ(
      note(),
      "; the environment variable VK_ICD_FILENAMES names \"/nonexistent/a.json\", which does not exist: "
      "correct or unset it");
  set["VK_DRIVER_FILES"] = "/dev/null:/nonexistent/b.json";
  EXPECT_TRUE(mentions(note(), "VK_DRIVER_FILES names \"/nonexistent/b.json\""));
  set["VK_DRIVER_FILES"] = "/dev/null";
  EXPECT_TRUE(mentions(note(), "VK_DRIVER_FILES leaves only the drivers of \"/dev/null\""));
}

TEST(DeviceChoice, SoftwareDeviceIsReported) {
  const auto choice = choose_device({report(0, "Old GPU", DeviceType::discrete, {"dynamicRendering"}),
                                     report(1, "llvmpipe", DeviceType::software)},
                                    "");
  ASSERT_TRUE(choice.ok());
  EXPECT_EQ(choice->index, 1u);
  ASSERT_EQ(choice->notes.size(), 2u);
  EXPECT_TRUE(mentions(choice->notes[0], "llvmpipe is a software device"));
  EXPECT_TRUE(mentions(choice->notes[1], "Old GPU was not taken: it lacks dynamicRendering"));
}

TEST(DeviceChoice, WishIsMetOrError) {
  const std::vector<DeviceReport> reports{report(0, "Big GPU", DeviceType::discrete),
                                          report(1, "llvmpipe (LLVM)", DeviceType::software),
                                          report(2, "Old GPU", DeviceType::discrete, {"Vulkan 1.3"})};
  EXPECT_EQ(choose_device(reports, "LLVMpipe")->index, 1u);
  EXPECT_EQ(choose_device(reports, "1")->index, 1u);
  const auto unknown = choose_device(reports, "Voodoo");
  ASSERT_FALSE(unknown.ok());
  EXPECT_TRUE(mentions(unknown.error().message, "--device Voodoo"));
  EXPECT_TRUE(mentions(unknown.error().message, "Big GPU"));  // the available devices
  const auto unusable = choose_device(reports, "old");
  ASSERT_FALSE(unusable.ok());
  EXPECT_TRUE(mentions(unusable.error().message, "Vulkan 1.3"));
  EXPECT_FALSE(choose_device(reports, "7").ok());
  EXPECT_FALSE(choose_device(reports, "1x").ok());  // neither an index nor a name
}

std::vector<uint32_t> indices_of(const Result<std::vector<DeviceChoice>>& choices) {
  std::vector<uint32_t> indices;
  for (const DeviceChoice& choice : choices.value()) indices.push_back(choice.index);
  return indices;
}

TEST(DeviceChoice, SeveralDevicesKeepOrder) {
  const std::vector<DeviceReport> reports{
      report(0, "llvmpipe", DeviceType::software), report(1, "Big GPU", DeviceType::discrete),
      report(2, "Old GPU", DeviceType::discrete, {"Vulkan 1.3"}), report(3, "Big GPU", DeviceType::discrete)};
  using Indices = std::vector<uint32_t>;
  EXPECT_EQ(indices_of(choose_devices(reports, "all")), (Indices{1, 3}));
  EXPECT_EQ(indices_of(choose_devices(reports, "3,1")), (Indices{3, 1}));
  EXPECT_EQ(indices_of(choose_devices(reports, "big,0,0")), (Indices{1, 0, 0}));
  EXPECT_FALSE(choose_devices(reports, "1,2").ok()) << "that one cannot be used";
  for (const char* wrong : {"1,,3", "1,", ",", "1,9", "1,all"}) {
    const auto choices = choose_devices(reports, wrong);
    ASSERT_FALSE(choices.ok()) << wrong;
    EXPECT_TRUE(mentions(choices.error().message, "--device")) << choices.error().message;
  }
  EXPECT_FALSE(choose_devices({}, "all").ok());
}

TEST(DeviceChoice, GpuWithoutDriverIsNamed) {
  const std::vector<DeviceReport> software{report(0, "llvmpipe", DeviceType::software)};
  const auto choice = choose_device(software, "", {{0x10de}, {}, {}});
  ASSERT_EQ(choice->notes.size(), 2u);
  EXPECT_TRUE(mentions(choice->notes[1], "NVIDIA"));
  EXPECT_EQ(choose_device(software, "llvmpipe", {{0x10de}, {}, {}})->notes.size(),
            1u);  // requested, so no notice

  const auto root = std::filesystem::temp_directory_path() / ("fire3dv_pci_" + std::to_string(getpid()));
  auto add = [&](const char* name, const char* pci_class, const char* vendor) {
    std::filesystem::create_directories(root / name);
    std::ofstream(root / name / "class") << pci_class << "\n";
    std::ofstream(root / name / "vendor") << vendor << "\n";
  };
  add("gpu", "0x030200", "0x10de");
  add("console", "0x030000", "0x1a03");
  add("network", "0x020000", "0x8086");
  EXPECT_EQ(graphics_vendors_present(root), std::vector<uint32_t>{0x10de});
  std::filesystem::remove_all(root);
  EXPECT_TRUE(graphics_vendors_present(root).empty());
}

TEST(DeviceChoice, MissingDeviceNamesRemedy) {
  const auto choice = choose_device({}, "");
  ASSERT_FALSE(choice.ok());
  EXPECT_TRUE(mentions(choice.error().message, "install"));
  const auto none_usable = choose_device({report(0, "Old GPU", DeviceType::discrete, {"shaderInt64"})}, "");
  ASSERT_FALSE(none_usable.ok());
  EXPECT_TRUE(mentions(none_usable.error().message, "shaderInt64"));
}

}  // namespace
}  // namespace fire3dv::gpu
