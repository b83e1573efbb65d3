// Test of the file sink: frames reach the disk whole, in order and with their tags; an error is reported
// once, with its path.
#include <gtest/gtest.h>

#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "base/files.h"
#include "renderer/sinks/file_sink.h"
#include "renderer/sinks/frame.h"
#include "renderer/sinks/png.h"

namespace fire3dv::sinks {
namespace {

namespace fs = std::filesystem;

class FileSinkTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("fire3dv_sink_" + std::to_string(getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

FrameImage frame(uint64_t index, const std::string& camera = "front", uint32_t side = 16) {
  FrameImage image;
  image.width = image.height = side;
  image.rgba8.assign(size_t{4} * side * side, static_cast<uint8_t>(index));
  image.frame_index = index;
  image.camera = camera;
  state::FrameTag tag;
  tag.stream = "arm \"7\"";
  tag.epoch = 0xffffffffffffffffu;
  tag.sequence = 100 + index;
  tag.sim_time_ns = static_cast<int64_t>(index) * 1000;
  tag.condition = state::Condition::late;
  image.shown = {tag};
  return image;
}

// Incompressible pixels, so that the file size follows the image size.
FrameImage noise(uint64_t index, uint32_t side) {
  FrameImage image = frame(index, "front", side);
  uint32_t state = 1;
  for (uint8_t& byte : image.rgba8)
    byte = static_cast<uint8_t>((state = state * 1664525u + 1013904223u) >> 24);
  return image;
}

std::vector<nlohmann::json> lines_of(const fs::path& path) {
  std::vector<nlohmann::json> lines;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) lines.push_back(nlohmann::json::parse(line));
  return lines;
}

TEST_F(FileSinkTest, FramesAreWrittenInOrder) {
  auto sink = FileSink::open({.folder = folder_ / "made" / "by the sink", .queue_limit = 2});
  ASSERT_TRUE(sink.ok()) << sink.error().message;
  for (uint64_t i = 0; i < 40; ++i) ASSERT_TRUE((*sink)->consume(frame(i)).ok());
  ASSERT_TRUE((*sink)->finish().ok());
  EXPECT_EQ((*sink)->frames_written(), 40u);
  const fs::path out = folder_ / "made" / "by the sink";
  const auto lines = lines_of(out / "frames.jsonl");
  ASSERT_EQ(lines.size(), 40u);
  for (uint64_t i = 0; i < 40; ++i) {
    EXPECT_EQ(lines[i]["frame"], i);
    EXPECT_EQ(lines[i]["camera"], "front");
    EXPECT_EQ(lines[i]["streams"][0]["stream"], "arm \"7\"");
    EXPECT_EQ(lines[i]["streams"][0]["epoch"], "ffffffffffffffff");
    EXPECT_EQ(lines[i]["streams"][0]["sequence"], 100 + i);
    EXPECT_EQ(lines[i]["streams"][0]["sim_time_ns"], 1000 * i);
    EXPECT_EQ(lines[i]["streams"][0]["state"], "late");
    const auto file = read_png(out / std::string(lines[i]["file"]));
    ASSERT_TRUE(file.ok()) << file.error().message;
    EXPECT_EQ(file->image.rgba8[0], i);
    EXPECT_EQ(file->image.shown[0].sequence, 100 + i);
  }
  EXPECT_TRUE(fs::exists(out / "frame_000039.png"));
}

TEST_F(FileSinkTest, QueueIsFlushedAtEnd) {
  {
    auto sink = FileSink::open({.folder = folder_, .queue_limit = 100});
    ASSERT_TRUE(sink.ok());
    for (uint64_t i = 0; i < 30; ++i) ASSERT_TRUE((*sink)->consume(frame(i)).ok());
  }
  EXPECT_EQ(lines_of(folder_ / "frames.jsonl").size(), 30u);
}

TEST_F(FileSinkTest, CamerasHaveOwnFolders) {
  auto sink = FileSink::open({.folder = folder_ / "out", .folder_per_camera = true});
  ASSERT_TRUE(sink.ok());
  for (const char* camera : {"front", "../../escape", "top view", "top_view", ""})
    ASSERT_TRUE((*sink)->consume(frame(3, camera)).ok());
  ASSERT_TRUE((*sink)->finish().ok());
  const auto lines = lines_of(folder_ / "out" / "frames.jsonl");
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_EQ(lines[0]["file"], "front/frame_000003.png");
  EXPECT_EQ(lines[1]["file"], "_.._.._escape/frame_000003.png");
  EXPECT_EQ(lines[2]["file"], "top_view/frame_000003.png");
  EXPECT_EQ(lines[3]["file"], "top_view_2/frame_000003.png");
  EXPECT_EQ(lines[4]["file"], "camera/frame_000003.png");
  for (const auto& line : lines) EXPECT_TRUE(fs::exists(folder_ / "out" / std::string(line["file"])));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1) << "nothing beside the folder";
}

TEST_F(FileSinkTest, SharedFolderIsRefused) {
  auto sink = FileSink::open({.folder = folder_});
  ASSERT_TRUE(sink.ok());
  ASSERT_TRUE((*sink)->consume(frame(0, "front")).ok());
  auto second = (*sink)->consume(frame(0, "top"));
  auto finished = (*sink)->finish();
  ASSERT_FALSE(finished.ok());
  EXPECT_NE(finished.error().message.find("frame 0"), std::string::npos);
}

TEST_F(FileSinkTest, UnwritableFolderIsNamed) {
  std::ofstream(folder_ / "file") << "in the way";
  for (const fs::path& bad :
       {folder_ / "file", folder_ / "file" / "below", fs::path("/proc/fire3dv/out"), fs::path()}) {
    const auto sink = FileSink::open({.folder = bad});
    ASSERT_FALSE(sink.ok()) << bad;
    EXPECT_NE(sink.error().message.find(bad.string()), std::string::npos) << sink.error().message;
  }
}

TEST_F(FileSinkTest, UnwritableListIsNamed) {
  fs::create_directories(folder_ / "frames.jsonl");
  const auto sink = FileSink::open({.folder = folder_});
  ASSERT_FALSE(sink.ok());
  EXPECT_NE(sink.error().message.find("frames.jsonl"), std::string::npos);
}

TEST_F(FileSinkTest, FailedWriteLeavesNoFile) {
  auto sink = FileSink::open({.folder = folder_, .queue_limit = 2});
  ASSERT_TRUE(sink.ok());
  ASSERT_TRUE((*sink)->consume(frame(0)).ok());
  while ((*sink)->frames_written() < 1) usleep(1000);

  // A file size limit makes a started write fail, like a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  rlimit small = before;
  small.rlim_cur = 20000;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  int told = 0;
  std::string message;
  for (uint64_t i = 1; i <= 20; ++i) {
    if (const auto taken = (*sink)->consume(noise(i, 128)); !taken) ++told, message = taken.error().message;
  }
  if (const auto finished = (*sink)->finish(); !finished) ++told, message = finished.error().message;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);

  EXPECT_EQ(told, 1);
  EXPECT_NE(message.find((folder_ / "frame_000001.png").string()), std::string::npos) << message;
  EXPECT_EQ((*sink)->frames_written(), 1u);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 2) << "frame 0 and the list, no .part";
}

TEST_F(FileSinkTest, LinksAreNotFollowed) {
  const fs::path outside = folder_ / "outside", out = folder_ / "out";
  fs::create_directories(out);
  std::ofstream(outside) << "mine";
  fs::create_symlink(outside, out / "frame_000001.png");
  auto sink = FileSink::open({.folder = out});
  ASSERT_TRUE(sink.ok());
  for (uint64_t i = 0; i < 2; ++i) ASSERT_TRUE((*sink)->consume(frame(i)).ok());
  ASSERT_TRUE((*sink)->finish().ok());
  std::string text;
  std::ifstream(outside) >> text;
  EXPECT_EQ(text, "mine");
  EXPECT_TRUE(read_png(out / "frame_000000.png").ok());
  EXPECT_TRUE(read_png(out / "frame_000001.png").ok());
}

TEST_F(FileSinkTest, WritersDoNotCollide) {
  constexpr size_t kWriters = 4, kWrites = 100, kBytes = 20'000;
  fs::create_directories(folder_);
  std::atomic<size_t> failures = 0;
  {
    std::vector<std::jthread> writers;
    for (uint8_t writer = 0; writer < kWriters; ++writer)
      writers.emplace_back([&, writer] {
        const std::vector<uint8_t> bytes(kBytes, writer);
        for (size_t i = 0; i < kWrites; ++i)
          failures += !write_whole_file(folder_ / "shared", bytes, base::Durability::contents);
      });
  }
  EXPECT_EQ(failures, 0u);
  const auto bytes = read_whole_file(folder_ / "shared", kBytes);
  ASSERT_TRUE(bytes.ok());
  EXPECT_EQ(*bytes, std::vector<uint8_t>(kBytes, bytes->at(0)));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1) << "no temporary file";
}

TEST_F(FileSinkTest, EarlierFramesAreNotListed) {
  for (const uint64_t count : {5u, 2u}) {
    auto sink = FileSink::open({.folder = folder_});
    ASSERT_TRUE(sink.ok());
    for (uint64_t i = 0; i < count; ++i) ASSERT_TRUE((*sink)->consume(frame(i)).ok());
    ASSERT_TRUE((*sink)->finish().ok());
    EXPECT_EQ(lines_of(folder_ / "frames.jsonl").size(), count);
    EXPECT_EQ((*sink)->count_stale_frames(), 5 - count);
  }
}

TEST(NullSink, Counts) {
  NullSink sink;
  for (uint64_t i = 0; i < 3; ++i) EXPECT_TRUE(sink.consume(frame(i)).ok());
  EXPECT_TRUE(sink.finish().ok());
  EXPECT_EQ(sink.frames_consumed(), 3u);
}

}  // namespace
}  // namespace fire3dv::sinks
