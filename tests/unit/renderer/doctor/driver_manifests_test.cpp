// Tests of the search for manifests of drivers and layers.
#include "renderer/doctor/driver_manifests.h"

#include <gtest/gtest.h>

#include "tests/unit/renderer/doctor/folders.h"

namespace fire3dv::doctor {
namespace {

constexpr const char* kManifest = R"({"ICD": {"library_path": "libvulkan_x.so", "api_version": "1.3.0"}})";

TEST(DriverManifests, FoldersOfTheSystemAreSearched) {
  const TestRoot root;
  root.write("usr/share/vulkan/icd.d/b.json", kManifest);
  root.write("usr/share/vulkan/icd.d/readme.txt", "");
  root.write("etc/vulkan/icd.d/a.json", kManifest);
  root.write("home/ada/.local/share/vulkan/icd.d/c.json", kManifest);
  const auto found = find_driver_manifests({{"HOME", "/home/ada"}}, {}, root.path());
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0].file, "/etc/vulkan/icd.d/a.json");
  EXPECT_EQ(found[1].file, "/home/ada/.local/share/vulkan/icd.d/c.json");
  EXPECT_EQ(found[2].library, "libvulkan_x.so");
  EXPECT_EQ(found[2].variable, "");
}

TEST(DriverManifests, VariablesReplaceOrAdd) {
  const TestRoot root;
  root.write("usr/share/vulkan/icd.d/b.json", kManifest);
  root.write("mine/a.json", kManifest);
  const auto added = find_driver_manifests({{"VK_ADD_DRIVER_FILES", "/mine/a.json"}}, {}, root.path());
  ASSERT_EQ(added.size(), 2u);
  EXPECT_EQ(added[0].variable, "VK_ADD_DRIVER_FILES");
  const auto only = find_driver_manifests(
      {{"VK_DRIVER_FILES", "/mine:/nowhere.json"}, {"VK_ICD_FILENAMES", "/other.json"}}, {}, root.path());
  ASSERT_EQ(only.size(), 2u);
  EXPECT_EQ(only[0].file, "/mine/a.json");
  EXPECT_EQ(only[1].fault, "it does not exist");
  EXPECT_EQ(only[1].variable, "VK_DRIVER_FILES");
}

TEST(DriverManifests, BrokenFilesHaveAFault) {
  const TestRoot root;
  root.write("etc/vulkan/icd.d/a.json", "{");
  root.write("etc/vulkan/icd.d/b.json", R"({"ICD": {"library_path": 3}})");
  root.write("etc/vulkan/icd.d/c.json", "[]");
  const auto found = find_driver_manifests({}, {}, root.path());
  ASSERT_EQ(found.size(), 3u);
  EXPECT_TRUE(found[0].fault.starts_with("it is no JSON")) << found[0].fault;
  EXPECT_EQ(found[1].fault, "it has no ICD.library_path");
  EXPECT_EQ(found[2].fault, "it has no ICD.library_path");
}

TEST(DriverManifests, LibrariesWithAFolderAreRelativeToTheirManifest) {
  ManifestFacts manifest;
  manifest.file = "/wheel/lib/lvp.json";
  manifest.library = "./libvulkan_lvp.so";
  EXPECT_EQ(library_to_load(manifest), "/wheel/lib/./libvulkan_lvp.so");
  manifest.library = "libvulkan_lvp.so";
  EXPECT_EQ(library_to_load(manifest), "libvulkan_lvp.so");
}

TEST(DriverManifests, OldLoadersReadTheOldVariable) {
  const TestRoot root;
  root.write("mine/a.json", kManifest);
  root.write("mine/b.json", kManifest);
  root.write("etc/vulkan/icd.d/c.json", kManifest);
  const LoaderFacts old{"", "", make_version(1, 3, 204), ""};
  const std::map<std::string, std::string> environment{{"VK_DRIVER_FILES", "/mine/a.json"},
                                                       {"VK_ADD_DRIVER_FILES", "/mine/a.json"}};
  const auto ignored = find_driver_manifests(environment, old, root.path());
  ASSERT_EQ(ignored.size(), 1u);
  EXPECT_EQ(ignored[0].file, "/etc/vulkan/icd.d/c.json");
  const auto read = find_driver_manifests({{"VK_ICD_FILENAMES", "/mine/b.json"}}, old, root.path());
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].variable, "VK_ICD_FILENAMES");
}

TEST(DriverManifests, FiltersHideDriversByTheirFiles) {
  const TestRoot root;
  root.write("etc/vulkan/icd.d/nvidia_icd.json", kManifest);
  root.write("etc/vulkan/icd.d/lvp_icd.json", kManifest);
  const auto hidden = [&](const char* variable, const char* filter, const LoaderFacts& loader = {}) {
    std::string files;
    for (const ManifestFacts& manifest : find_driver_manifests({{variable, filter}}, loader, root.path()))
      files +=
          manifest.hidden_by == variable ? std::filesystem::path(manifest.file).stem().string() + " " : "";
    return files;
  };
  EXPECT_EQ(hidden("VK_LOADER_DRIVERS_DISABLE", "x,*NVIDIA*"), "nvidia_icd ");
  EXPECT_EQ(hidden("VK_LOADER_DRIVERS_SELECT", "nvidia*"), "lvp_icd ");
  EXPECT_EQ(hidden("VK_LOADER_DRIVERS_SELECT", "*"), "");
  EXPECT_EQ(hidden("VK_LOADER_DRIVERS_DISABLE", "*_icd.json"), "lvp_icd nvidia_icd ");
  EXPECT_EQ(hidden("VK_LOADER_DRIVERS_DISABLE", "lvp_icd"), "");
  EXPECT_EQ(hidden("VK_LOADER_DRIVERS_DISABLE", "*", {"", "", make_version(1, 3, 204), ""}), "");
}

TEST(DriverManifests, ManifestsWithoutAUsableLibraryHaveAFault) {
  const TestRoot root;
  root.write("etc/vulkan/icd.d/a.json", R"({"ICD": {"library_path": ""}})");
  root.write("etc/vulkan/icd.d/b.json", R"({"ICD": {"library_path": "a\u0000b"}})");
  root.write("etc/vulkan/icd.d/c.json", std::string(200'000, '[') + std::string(200'000, ']'));
  const auto found = find_driver_manifests({}, {}, root.path());
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0].fault, "its ICD.library_path is empty");
  EXPECT_EQ(found[1].fault, "its ICD.library_path is no path");
  EXPECT_EQ(found[2].fault, "it is nested deeper than 32 levels");
}

TEST(ImplicitLayers, EnvironmentEnablesAndDisables) {
  const TestRoot root;
  root.write("usr/share/vulkan/implicit_layer.d/a.json",
             R"({"layer": {"name": "VK_LAYER_A", "disable_environment": {"NO_A": "1"}}})");
  root.write("usr/share/vulkan/implicit_layer.d/b.json", R"({"layers": [{"name": "VK_LAYER_B",
             "enable_environment": {"USE_B": "1"}, "disable_environment": {"NO_B": ""}}, 3]})");
  root.write("usr/share/vulkan/implicit_layer.d/c.json", R"({"layer": {"name": "VK_LAYER_skipped"}})");
  root.write("opt/layers/d.json",
             R"({"layer": {"name": "VK_LAYER_D", "disable_environment": {"NO_D": "1"}}})");
  const auto names = [&](const std::map<std::string, std::string>& environment,
                         const LoaderFacts& loader = {}) {
    std::string text;
    for (const LayerFacts& layer : find_implicit_layers(environment, loader, root.path()))
      text += layer.name + " ";
    return text;
  };
  EXPECT_EQ(names({}), "VK_LAYER_A ");
  EXPECT_EQ(names({{"USE_B", "1"}}), "VK_LAYER_A VK_LAYER_B ");
  EXPECT_EQ(names({{"USE_B", "0"}}), "VK_LAYER_A ") << "only the value of the manifest enables";
  EXPECT_EQ(names({{"NO_A", "0"}}), "") << "any value disables";
  EXPECT_EQ(names({{"VK_LOADER_LAYERS_ENABLE", "*_b"}}), "VK_LAYER_A VK_LAYER_B ");
  for (const char* filter : {"~implicit~", "~all~", "*", "x,vk_layer_*", "*layer_a*"})
    EXPECT_EQ(names({{"VK_LOADER_LAYERS_DISABLE", filter}}), "") << filter;
  EXPECT_EQ(names({{"VK_LOADER_LAYERS_DISABLE", "~explicit~,*B"}}), "VK_LAYER_A ");
  EXPECT_EQ(names({{"VK_LOADER_LAYERS_DISABLE", "*"}, {"VK_LOADER_LAYERS_ALLOW", "*A"}}), "VK_LAYER_A ");
  EXPECT_EQ(names({{"VK_LOADER_LAYERS_DISABLE", "*"}}, {"", "", make_version(1, 3, 204), ""}), "VK_LAYER_A ");
  EXPECT_EQ(names({{"VK_IMPLICIT_LAYER_PATH", "/opt/layers"}}), "VK_LAYER_D ");
  EXPECT_EQ(names({{"VK_ADD_IMPLICIT_LAYER_PATH", "/opt/layers/d.json"}}), "VK_LAYER_D VK_LAYER_A ");
  const std::vector<LayerFacts> both = find_implicit_layers({{"USE_B", "1"}}, {}, root.path());
  ASSERT_EQ(both.size(), 2u);
  EXPECT_EQ(both[1].variable + "=" + both[1].value, "NO_B=1");
}

TEST(ImplicitLayers, VariablesHaveNamesForAShell) {
  const TestRoot root;
  for (const char* name : {"X; reboot", "1X", "", "A-B", "A=B", "\\u00c4"}) {
    root.write(
        "usr/share/vulkan/implicit_layer.d/a.json",
        std::string(R"({"layer": {"name": "VK_LAYER_A", "disable_environment": {")") + name + R"(": "1"}}})");
    EXPECT_TRUE(find_implicit_layers({}, {}, root.path()).empty()) << name;
  }
  root.write("usr/share/vulkan/implicit_layer.d/a.json",
             R"({"layer": {"name": "VK_LAYER_A", "disable_environment": {"_no_A1": "1"}}})");
  EXPECT_EQ(find_implicit_layers({}, {}, root.path()).size(), 1u);
}

TEST(ImplicitLayers, VersionsOfTheLoaderReadTheirVariables) {
  const TestRoot root;
  root.write("opt/layers/d.json",
             R"({"layer": {"name": "VK_LAYER_D", "disable_environment": {"NO_D": "1"}}})");
  root.write("usr/share/vulkan/implicit_layer.d/a.json",
             R"({"layer": {"name": "VK_LAYER_A", "disable_environment": {"NO_A": "1"}}})");
  const auto count = [&](const std::map<std::string, std::string>& environment, uint32_t patch) {
    return find_implicit_layers(environment, {"", "", make_version(1, 3, patch), ""}, root.path()).size();
  };
  const std::map<std::string, std::string> allowed{{"VK_LOADER_LAYERS_DISABLE", "*"},
                                                   {"VK_LOADER_LAYERS_ALLOW", "*A"}};
  EXPECT_EQ(count(allowed, 261), 0u);
  EXPECT_EQ(count(allowed, 262), 1u);
  const std::map<std::string, std::string> added{{"VK_ADD_IMPLICIT_LAYER_PATH", "/opt/layers"}};
  EXPECT_EQ(count(added, 295), 1u);
  EXPECT_EQ(count(added, 296), 2u);
}

TEST(ImplicitLayers, DeepManifestsAreSkipped) {
  const TestRoot root;
  root.write("usr/share/vulkan/implicit_layer.d/a.json",
             "{\"layer\": " + std::string(200'000, '[') + std::string(200'000, ']') + "}");
  EXPECT_TRUE(find_implicit_layers({}, {}, root.path()).empty());
}

}  // namespace
}  // namespace fire3dv::doctor
