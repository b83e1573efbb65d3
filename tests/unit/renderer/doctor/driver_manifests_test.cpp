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
  const auto found = find_driver_manifests({{"HOME", "/home/ada"}}, root.path());
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
  const auto added = find_driver_manifests({{"VK_ADD_DRIVER_FILES", "/mine/a.json"}}, root.path());
  ASSERT_EQ(added.size(), 2u);
  EXPECT_EQ(added[0].variable, "VK_ADD_DRIVER_FILES");
  const auto only = find_driver_manifests(
      {{"VK_DRIVER_FILES", "/mine:/nowhere.json"}, {"VK_ICD_FILENAMES", "/other.json"}}, root.path());
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
  const auto found = find_driver_manifests({}, root.path());
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

TEST(ImplicitLayers, EnvironmentEnablesAndDisables) {
  const TestRoot root;
  root.write("usr/share/vulkan/implicit_layer.d/a.json",
             R"({"layer": {"name": "VK_LAYER_A", "disable_environment": {"NO_A": "1"}}})");
  root.write("usr/share/vulkan/implicit_layer.d/b.json",
             R"({"layers": [{"name": "VK_LAYER_B", "enable_environment": {"USE_B": "1"}}, 3]})");
  ASSERT_EQ(find_implicit_layers({}, root.path()).size(), 1u);
  EXPECT_EQ(find_implicit_layers({}, root.path())[0].name, "VK_LAYER_A");
  EXPECT_EQ(find_implicit_layers({{"USE_B", "1"}}, root.path()).size(), 2u);
  EXPECT_TRUE(find_implicit_layers({{"NO_A", "1"}}, root.path()).empty());
  EXPECT_TRUE(find_implicit_layers({{"VK_LOADER_LAYERS_DISABLE", "~implicit~"}}, root.path()).empty());
}

}  // namespace
}  // namespace fire3dv::doctor
