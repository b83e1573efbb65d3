// Test of the saved panel layout: path, contents, bounds, and damaged files.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "renderer/gui/layout_file.h"

namespace fire3dv::gui {
namespace {

Layout unlike_the_first() {
  Layout layout;
  layout.left_pt = 301.5f;
  layout.log_pt = 90;
  layout.camera_speed = 0.25f;
  layout.is_light = true;
  layout.is_open(Panel::frame) = false;
  layout.has_plotted = true;
  layout.is_open(Panel::lights) = true;
  return layout;
}

class GuiLayout : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = std::filesystem::temp_directory_path() /
             ("fire3dv_gui_layout_" + std::to_string(::testing::UnitTest::GetInstance()->random_seed()) +
              "_" + ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(folder);
  }
  void TearDown() override { std::filesystem::remove_all(folder); }
  std::filesystem::path folder;
};

TEST_F(GuiLayout, WrittenSettingsAreRead) {
  for (const Layout& layout : {Layout{}, unlike_the_first()}) {
    const Result<Layout> read = parse_layout(layout_text(layout));
    ASSERT_TRUE(read);
    EXPECT_EQ(*read, layout);
  }
}

TEST_F(GuiLayout, MissingSettingsKeepTheirDefaults) {
  const Result<Layout> read = parse_layout("# mine\r\n\n  right = 400\nlog=closed");
  ASSERT_TRUE(read);
  Layout wanted;
  wanted.right_pt = 400;
  wanted.is_open(Panel::log) = false;
  EXPECT_EQ(*read, wanted);
}

TEST_F(GuiLayout, NumbersStayWithinBounds) {
  const Result<Layout> read = parse_layout("left = 1e30\nright = -7\ncamera-speed = 0");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->left_pt, kMaxColumnPt);
  EXPECT_EQ(read->right_pt, kLeastColumnPt);
  EXPECT_GT(read->camera_speed, 0);
}

TEST_F(GuiLayout, UnknownSettingsNameLine) {
  for (const char* text : {"left 300", "left = wide", "left = nan", "left = 3 4", "scene = ajar",
                           "window = open", "= 3", "left =", "\x01\x02\xff"}) {
    const Result<Layout> read = parse_layout("right = 300\n" + std::string(text));
    ASSERT_FALSE(read) << text;
    EXPECT_NE(read.error().message.find("line 2"), std::string::npos) << read.error().message;
  }
}

TEST_F(GuiLayout, IsStoredBelowUsersFolder) {
  std::map<std::string, const char*> variables;
  const auto environment = [&](const char* name) -> const char* {
    const auto found = variables.find(name);
    return found == variables.end() ? nullptr : found->second;
  };
  EXPECT_FALSE(layout_place(environment));
  variables["HOME"] = "/home/ada";
  EXPECT_EQ(*layout_place(environment), "/home/ada/.config/fire3dv/window.conf");
  variables["XDG_CONFIG_HOME"] = "elsewhere";  // ignored because it is relative
  EXPECT_EQ(*layout_place(environment), "/home/ada/.config/fire3dv/window.conf");
  variables["XDG_CONFIG_HOME"] = "/configs";
  EXPECT_EQ(*layout_place(environment), "/configs/fire3dv/window.conf");
}

TEST_F(GuiLayout, FilesAreAtomicAndDamageReported) {
  const std::filesystem::path file = folder / "below" / "window.conf";
  const Result<Layout> none = load_layout(file);
  ASSERT_TRUE(none);
  EXPECT_EQ(*none, Layout{});
  ASSERT_TRUE(save_layout(file, unlike_the_first()));
  const Result<Layout> loaded = load_layout(file);
  ASSERT_TRUE(loaded);
  EXPECT_EQ(*loaded, unlike_the_first());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(file.parent_path()), {}), 1);

  std::ofstream(file) << "left = 300\nrig";
  const Result<Layout> damaged = load_layout(file);
  ASSERT_FALSE(damaged);
  EXPECT_NE(damaged.error().message.find(file.string() + ": line 2"), std::string::npos);
  std::ofstream(file) << std::string(1 << 20, 'x');
  EXPECT_FALSE(load_layout(file));
  std::ofstream(folder / "file") << "";
  EXPECT_FALSE(save_layout(folder / "file" / "window.conf", Layout{}));
}

}  // namespace
}  // namespace fire3dv::gui
