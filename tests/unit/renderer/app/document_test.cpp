// Test of documents: a dropped file replaces the shown one when it is loaded.
#include "renderer/app/document.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <thread>

namespace fire3dv::app {
namespace {

// A dropped file is loaded and checked before it replaces the shown document.
TEST(Documents, UnreadableFileIsReported) {
  const std::filesystem::path file =
      std::filesystem::path(::testing::TempDir()) / "fire3dv_document_test_dropped.gltf";
  std::ofstream(file) << R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
                            "nodes": [{"name": "lonely"}]})";
  Options options;
  options.scene = file;
  const CacheLocations places;
  Result<std::unique_ptr<Document>> now = Document::open(options, places);
  ASSERT_TRUE(now.ok());
  ASSERT_TRUE((*now)->load().wait().ok());
  bool can = false;
  DocumentLoader next(**now, places, [&](const scene::Scene& scene) -> Result<void> {
    EXPECT_EQ(scene.nodes.at(0).name, "lonely");
    if (can) return {};
    return Error{"the device takes no more"};
  });
  const auto ready_in_the_end = [&] {
    next.open(file);
    EXPECT_EQ(next.take_log_messages().size(), 1u);
    for (int i = 0; i < 10'000; ++i) {
      if (next.is_ready()) return true;
      const std::vector<std::string> notes = next.take_log_messages();
      if (!notes.empty()) {
        EXPECT_EQ(notes, std::vector<std::string>{"error: the device takes no more"});
        return false;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ADD_FAILURE() << "it is loading still";
    return false;
  };
  EXPECT_FALSE(ready_in_the_end());
  EXPECT_EQ(next.take(), nullptr);
  can = true;
  EXPECT_TRUE(ready_in_the_end());
  next.open(file);  // again, while it is held for unsaved edits
  EXPECT_TRUE(next.take_log_messages().empty());
  EXPECT_TRUE(next.is_ready());
  EXPECT_NE(next.take(), nullptr);
  std::filesystem::remove(file);
}

TEST(Documents, DroppedFileReplacesItsKind) {
  Options options;
  options.scene = "arm.glb";
  options.recording.replay = "run.mcap";
  options.recording.start_s = 5;
  options.listen = {"shm://demo"};
  Options other = with_file(options, "other.gltf");
  EXPECT_EQ(other.scene, "other.gltf");
  EXPECT_EQ(other.recording.replay, "");
  EXPECT_EQ(other.listen, options.listen);
  other = with_file(options, "later.mcap");
  EXPECT_EQ(other.recording.replay, "later.mcap");
  EXPECT_EQ(other.recording.start_s, 0);
  EXPECT_TRUE(other.scene.empty());
}

}  // namespace
}  // namespace fire3dv::app
