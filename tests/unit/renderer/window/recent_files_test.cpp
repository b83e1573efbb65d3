// Test of the list of recently opened files: order, bound, damaged files, and several windows.
#include "renderer/window/recent_files.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <fstream>
#include <map>
#include <string>

namespace fire3dv::app {
namespace {

using Paths = std::vector<std::filesystem::path>;

class Recent : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "fire3dv_recent_test.XXXXXX").string();
    ASSERT_TRUE(mkdtemp(name.data()));
    folder_ = name;
    place_ = folder_ / "new" / "recent";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_, place_;
};

TEST_F(Recent, NewestOfTenIsFirst) {
  for (int i = 0; i < 12; ++i) {
    RecentFiles window(place_);  // each in a window of its own
    ASSERT_TRUE(window.add("/models/" + std::to_string(i) + ".glb"));
  }
  RecentFiles last(place_);
  ASSERT_TRUE(last.add("/models/x/../5.glb"));
  EXPECT_EQ(last.files(),
            (Paths{"/models/5.glb", "/models/11.glb", "/models/10.glb", "/models/9.glb", "/models/8.glb",
                   "/models/7.glb", "/models/6.glb", "/models/4.glb", "/models/3.glb", "/models/2.glb"}));
  std::ifstream file(place_);
  std::string first;
  std::getline(file, first);
  EXPECT_EQ(first, "/models/5.glb");
}

TEST_F(Recent, RelativePathsBecomeAbsolute) {
  RecentFiles window(place_);
  ASSERT_TRUE(window.add("arm.glb"));
  EXPECT_EQ(window.files(), Paths{std::filesystem::current_path() / "arm.glb"});
  ASSERT_TRUE(window.add("/two\nlines.glb"));
  EXPECT_EQ(window.files().size(), 1u) << "a path of two lines would be two paths";
}

TEST_F(Recent, ADamagedListBeginsAnew) {
  std::filesystem::create_directories(place_.parent_path());
  std::ofstream(place_) << "/a.glb\nnot a path\n\n/a.glb\n/b.glb" << '\0' << "c\n/d.glb";
  RecentFiles window(place_);
  ASSERT_TRUE(window.add("/e.glb"));
  EXPECT_EQ(window.files(), (Paths{"/e.glb", "/a.glb", "/d.glb"}));
  std::ofstream(place_) << std::string(100'000, '/');
  ASSERT_TRUE(window.add("/f.glb"));
  EXPECT_EQ(window.files(), Paths{"/f.glb"});
}

TEST_F(Recent, UnwritableFolderIsReported) {
  std::ofstream(folder_ / "new") << "a file";
  RecentFiles window(place_);
  const Result<void> added = window.add("/a.glb");
  ASSERT_FALSE(added);
  EXPECT_NE(added.error().message.find(place_.string()), std::string::npos);
  EXPECT_EQ(window.files(), Paths{"/a.glb"});
  EXPECT_TRUE(RecentFiles(std::nullopt).add("/a.glb")) << "without a home nothing is kept";
}

TEST_F(Recent, PlaceIsInUsersStateFolder) {
  std::map<std::string, std::string> variables;
  const auto place = [&] {
    return recent_files_path([&](const char* name) -> const char* {
      const auto found = variables.find(name);
      return found == variables.end() ? nullptr : found->second.c_str();
    });
  };
  EXPECT_FALSE(place());
  variables["HOME"] = "/home/me";
  EXPECT_EQ(place(), "/home/me/.local/state/fire3dv/recent");
  variables["XDG_STATE_HOME"] = "relative";
  EXPECT_EQ(place(), "/home/me/.local/state/fire3dv/recent");
  variables["XDG_STATE_HOME"] = "/state";
  EXPECT_EQ(place(), "/state/fire3dv/recent");
}

}  // namespace
}  // namespace fire3dv::app
