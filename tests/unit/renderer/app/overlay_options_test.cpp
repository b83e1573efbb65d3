// Test of the options of overlay files: --overlay, --variant and the file beside the scene.
#include "renderer/app/options/overlay_options.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace fire3dv::app {
namespace {

namespace fs = std::filesystem;

class OverlayOptions : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  const fs::path folder_ = fs::path(::testing::TempDir()) / "fire3dv_overlay_options";
};

TEST_F(OverlayOptions, FileIsBesideScene) {
  Options options;
  options.scene = folder_ / "demo.glb";
  EXPECT_EQ(overlay_file(options, true).path, folder_ / "demo.glb.overlay.json");
  EXPECT_TRUE(overlay_file(options, false).path.empty());
  options.overlay = folder_ / "mine.json";
  EXPECT_EQ(overlay_file(options, false).path, options.overlay);
  EXPECT_TRUE(load_overlay(options).ok()) << "a window saves it";
  options.headless = true;
  EXPECT_FALSE(load_overlay(options).ok());
  std::ofstream(options.overlay) << R"({"fire3dv_overlay": {"version": 1, "edits": [{"node": "a"}]}})";
  const Result<state::EditDocument> bad = load_overlay(options);
  ASSERT_FALSE(bad.ok());
  EXPECT_NE(bad.error().message.find("mine.json: edits[0]"), std::string::npos) << bad.error().message;
}

TEST_F(OverlayOptions, VariantReplacesThatOfFile) {
  Options options;
  options.overlay = folder_ / "mine.json";
  std::ofstream(options.overlay) << R"({"fire3dv_overlay": {"version": 1, "edits": [{"variant": "dusk"}]}})";
  Result<state::EditDocument> document = load_overlay(options);
  ASSERT_TRUE(document.ok()) << document.error().message;
  EXPECT_EQ(document->at(state::variant_key()), state::EditedValue("dusk"));
  EXPECT_FALSE(overlay_file(options, true).has_variant_option);
  options.variant = "night";
  document = load_overlay(options);
  ASSERT_TRUE(document.ok());
  EXPECT_EQ(document->at(state::variant_key()), state::EditedValue("night"));
  EXPECT_TRUE(overlay_file(options, true).has_variant_option);
  options.overlay.clear();
  EXPECT_EQ(load_overlay(options)->size(), 1u);
}

}  // namespace
}  // namespace fire3dv::app
