// Test of the watch of scene files: a change is reported once, when it has settled, also by a rename.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "renderer/loading/file_watch.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::app {
namespace {

constexpr int64_t kStep_ns = 50'000'000;

class FileWatchTest : public testing::Test {
 protected:
  WatchedFile watched(const std::string& name) const {
    return {folder_.path() / name, scene::stamp_of(folder_.path() / name)};
  }
  // Polls for a time; returns the number of changes.
  int poll_for(FileWatch& watch, int64_t ns) {
    int changes = 0;
    for (const int64_t end = now_ns_ + ns; now_ns_ < end; now_ns_ += kStep_ns) changes += watch.poll(now_ns_);
    return changes;
  }
  const test::ScratchFolder folder_;
  int64_t now_ns_ = 1;
};

TEST_F(FileWatchTest, QuietChangesAreReported) {
  folder_.write("a.glb", "first");
  FileWatch watch({watched("a.glb")});
  EXPECT_EQ(poll_for(watch, 3'000'000'000), 0);
  // Written in pieces, each within the time of quiet.
  std::string text = "second";
  for (int i = 0; i < 8; ++i) {
    folder_.write("a.glb", text += "!");
    EXPECT_EQ(poll_for(watch, 200'000'000), 0) << i;
  }
  EXPECT_EQ(poll_for(watch, 1'000'000'000), 1);
  EXPECT_EQ(poll_for(watch, 3'000'000'000), 0) << "once";
}

TEST_F(FileWatchTest, RenamesAndMissingFilesAreSeen) {
  folder_.write("a.glb", "first");
  FileWatch watch({watched("a.glb")});
  folder_.write("b.glb", "other");  // of the same size
  std::filesystem::rename(folder_.path() / "b.glb", folder_.path() / "a.glb");
  EXPECT_EQ(poll_for(watch, 1'500'000'000), 1);
  std::filesystem::remove(folder_.path() / "a.glb");
  EXPECT_EQ(poll_for(watch, 3'000'000'000), 0) << "nothing can be loaded";
  folder_.write("a.glb", "third");
  EXPECT_EQ(poll_for(watch, 1'500'000'000), 1);
}

TEST_F(FileWatchTest, SceneFilesAreWatched) {
  folder_.write("a.gltf", "scene");
  folder_.write("a.bin", "buffer");
  FileWatch watch({watched("a.gltf"), watched("a.bin"), watched("gone.png")});
  EXPECT_EQ(poll_for(watch, 2'000'000'000), 0);
  folder_.write("gone.png", "it has come");
  EXPECT_EQ(poll_for(watch, 1'500'000'000), 1);
  folder_.write("a.bin", "other buffer");
  EXPECT_EQ(poll_for(watch, 1'500'000'000), 1);
  // A change between the report and the end of the load that it causes is not lost.
  folder_.write("a.bin", "changed while it was loaded");
  watch.watch({watched("a.gltf"), watched("a.bin")});
  EXPECT_EQ(poll_for(watch, 1'500'000'000), 1);
}

}  // namespace
}  // namespace fire3dv::app
