// Test of frame folders: an interrupted run resumes, and frames of other runs stay untouched.
#include "renderer/offline/frame_folder.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "renderer/sinks/png.h"

namespace fire3dv::offline {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kFrames = 12;
const Machine kMachine{"device", "driver 1", "cpu"};

Manifest manifest_of(uint32_t shard = 1, uint32_t shards = 1) {
  Manifest manifest;
  manifest.settings = {{"recording", "abc"}, {"look", "--tone-map none"}};
  manifest.times = {-5, {30000, 1001}, kFrames};
  manifest.width = 6;
  manifest.height = 4;
  manifest.shard = shard;
  manifest.shards = shards;
  return manifest;
}

sinks::FrameImage image_of(uint64_t frame) {
  sinks::FrameImage image;
  image.width = 6;
  image.height = 4;
  image.frame_index = frame;
  image.camera = "front";
  image.rgba8.assign(6 * 4 * 4, static_cast<uint8_t>(frame));
  for (size_t i = 3; i < image.rgba8.size(); i += 4) image.rgba8[i] = 255;
  image.shown = {{"arm", 7, frame + 1, static_cast<int64_t>(frame), 3, state::Condition::live}};
  return image;
}

class OfflineFolder : public ::testing::Test {
 protected:
  OfflineFolder() {
    std::string name = (fs::temp_directory_path() / "fire3dv-folder-XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    root_ = name;
    folder_ = root_ / "frames";
  }
  ~OfflineFolder() override { fs::remove_all(root_); }

  // Completes a run; returns the number of frames that existed before.
  uint64_t run(uint64_t first, uint64_t end, const Manifest& manifest = manifest_of()) {
    auto folder = FrameFolder::open(folder_, manifest);
    if (!folder) {
      ADD_FAILURE() << folder.error().message;
      return 0;
    }
    const uint64_t existing = (*folder)->existing_frames();
    EXPECT_TRUE((*folder)->begin(kMachine).ok());
    for (uint64_t frame = first; frame < end; ++frame) {
      if ((*folder)->has(frame)) continue;
      EXPECT_TRUE((*folder)->consume(image_of(frame)).ok());
    }
    EXPECT_TRUE((*folder)->finish().ok());
    return existing;
  }
  std::string refused(const Manifest& manifest) {
    const auto folder = FrameFolder::open(folder_, manifest);
    return folder ? "" : folder.error().message;
  }
  std::string text_of(const char* name) {
    std::ifstream file(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void write(const fs::path& name, const std::string& text) {
    std::ofstream(folder_ / name, std::ios::binary | std::ios::trunc) << text;
  }

  fs::path root_, folder_;
};

TEST_F(OfflineFolder, IsGoneOnWith) {
  EXPECT_EQ(run(0, kFrames), 0u);
  const std::string whole = text_of(kFrameListName);
  fs::remove_all(folder_);
  EXPECT_EQ(run(0, 5), 0u);
  EXPECT_EQ(run(0, kFrames), 5u);
  EXPECT_EQ(text_of(kFrameListName), whole);
  for (uint64_t frame = 0; frame < kFrames; ++frame) {
    const auto png = sinks::read_png(folder_ / frame_file_name(frame));
    ASSERT_TRUE(png.ok());
    EXPECT_EQ(png->image.rgba8, image_of(frame).rgba8);
    EXPECT_EQ(png->image.frame_index, frame);
  }
}

TEST_F(OfflineFolder, IncompleteFramesAreDrawnAgain) {
  run(0, kFrames);
  const std::string whole = text_of(kFrameListName);
  fs::remove(folder_ / frame_file_name(3));
  write(frame_file_name(5), "");
  write(frame_file_name(7), text_of(frame_file_name(7).c_str()).substr(0, 60));
  fs::remove(folder_ / frame_file_name(8));
  fs::create_symlink(folder_ / frame_file_name(9), folder_ / frame_file_name(8));
  // A truncated last line, and invalid lines before it.
  write(kFrameListName, "no json\n[1]\n{\"frame\":-1}\n{\"frame\":99}\n{\"file\":\"../../x\"}\n" +
                            whole.substr(0, whole.size() - 10));
  EXPECT_EQ(run(0, kFrames), kFrames - 5);
  EXPECT_EQ(text_of(kFrameListName), whole);
  EXPECT_FALSE(fs::is_symlink(folder_ / frame_file_name(8)));
}

TEST_F(OfflineFolder, OtherRunsFramesStay) {
  run(0, 2);
  Manifest other = manifest_of();
  other.settings[1].second = "--tone-map aces";
  EXPECT_NE(refused(other).find("look is --tone-map none there and --tone-map aces here"), std::string::npos)
      << refused(other);
  other = manifest_of();
  other.times.rate = {60, 1};
  EXPECT_NE(refused(other).find("fps is 30000/1001 there and 60 here"), std::string::npos) << refused(other);
  other = manifest_of();
  other.width = 8;
  EXPECT_NE(refused(other).find("size is 6x4 there and 8x4 here"), std::string::npos) << refused(other);
  EXPECT_NE(refused(manifest_of(1, 2)).find("shard is 1/1 there and 1/2 here"), std::string::npos);
  fs::remove(folder_ / kManifestName);
  EXPECT_NE(refused(manifest_of()).find("has no manifest.json"), std::string::npos);
  EXPECT_TRUE(fs::exists(folder_ / frame_file_name(1)));
}

TEST_F(OfflineFolder, TwoRunsAreExclusive) {
  auto first = FrameFolder::open(folder_, manifest_of());
  ASSERT_TRUE(first.ok());
  EXPECT_NE(refused(manifest_of()).find("another run is writing to"), std::string::npos);
  first->reset();
  EXPECT_EQ(refused(manifest_of()), "");
}

TEST_F(OfflineFolder, ShardHoldsItsPartAlone) {
  const Manifest manifest = manifest_of(2, 3);
  EXPECT_EQ(manifest.part(), (Part{4, 4}));
  run(4, 8, manifest);
  const auto frames = listed_frames(folder_, manifest);
  ASSERT_TRUE(frames.ok());
  EXPECT_EQ(frames->size(), 4u);
  EXPECT_EQ(frames->begin()->first, 4u);
}

TEST_F(OfflineFolder, InvalidListIsIgnored) {
  run(0, 2);
  write(kFrameListName, std::string(17 << 20, 'x'));
  EXPECT_NE(refused(manifest_of()).find("frames.jsonl is not what fire3dv render writes"), std::string::npos);
  fs::remove(folder_ / kFrameListName);
  ASSERT_EQ(mkfifo((folder_ / kFrameListName).c_str(), 0600), 0);
  EXPECT_NE(refused(manifest_of()).find("frames.jsonl is not what fire3dv render writes"), std::string::npos);
  fs::remove(folder_ / kFrameListName);
  EXPECT_EQ(refused(manifest_of()), "");
}

TEST_F(OfflineFolder, FrameMustMatchItsName) {
  run(0, kFrames);
  fs::copy_file(folder_ / frame_file_name(3), folder_ / frame_file_name(5),
                fs::copy_options::overwrite_existing);
  const auto listed = listed_frames(folder_, manifest_of());
  ASSERT_TRUE(listed.ok());
  auto other = FrameFolder::open(root_ / "joined", manifest_of());
  ASSERT_TRUE(other.ok());
  ASSERT_TRUE((*other)->begin(kMachine).ok());
  EXPECT_TRUE((*other)->copy(4, folder_, listed->at(4)).ok());
  const auto wrong = (*other)->copy(5, folder_, listed->at(5));
  ASSERT_FALSE(wrong.ok());
  EXPECT_NE(wrong.error().message.find("frame_000005.png is not the frame that its name says"),
            std::string::npos)
      << wrong.error().message;
  Manifest larger = manifest_of();
  larger.width = 8;
  EXPECT_FALSE(read_frame(folder_, 4, larger).ok());
  ASSERT_TRUE((*other)->finish().ok());
  other->reset();
  EXPECT_EQ(listed_frames(root_ / "joined", manifest_of())->size(), 1u);
}

TEST_F(OfflineFolder, FullDiskIsReported) {
  auto folder = FrameFolder::open(folder_, manifest_of());
  ASSERT_TRUE(folder.ok());
  ASSERT_TRUE((*folder)->begin(kMachine).ok());
  fs::create_directories(folder_ / frame_file_name(2));  // blocks the third file
  Result<void> result;
  for (uint64_t frame = 0; frame < kFrames && result; ++frame) result = (*folder)->consume(image_of(frame));
  if (result) result = (*folder)->finish();
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.error().message.find("frame_000002.png"), std::string::npos) << result.error().message;
  folder->reset();
  const auto frames = listed_frames(folder_, manifest_of());
  ASSERT_TRUE(frames.ok());
  EXPECT_EQ(frames->size(), 2u);
}

// Two images of 257 MiB are more than may wait: the second one is taken when the first one is encoded.
TEST_F(OfflineFolder, WaitingImagesHaveALimitInBytes) {
  class SlowFrames final : public FrameFormat {
   public:
    Result<EncodedFrame> encode(const sinks::FrameImage& image) override {
      at_once_ = std::max(at_once_.load(), ++running_);
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      --running_;
      return EncodedFrame{{}, "{\"frame\":" + std::to_string(image.frame_index) + "}"};
    }
    bool is_complete(const fs::path&, uint64_t, const nlohmann::json&, bool) const override { return false; }
    Result<EncodedFrame> load(const fs::path&, uint64_t, const std::string&, const Manifest&) const override {
      return EncodedFrame{};
    }
    std::atomic<int> running_{0}, at_once_{0};
  };
  const auto format = std::make_shared<SlowFrames>();
  auto folder = FrameFolder::open(folder_, manifest_of(), format);
  ASSERT_TRUE(folder.ok() && (*folder)->begin(kMachine).ok());
  for (uint64_t frame = 0; frame < 2; ++frame) {
    sinks::FrameImage image = image_of(frame);
    if (frame == 0)
      image.amodal.emplace().masks.resize(size_t{257} << 20);
    else
      image.flow_backward.emplace().occlusion.resize(size_t{257} << 20);
    ASSERT_TRUE((*folder)->consume(std::move(image)).ok());
  }
  ASSERT_TRUE((*folder)->finish().ok());
  EXPECT_EQ(format->at_once_, 1);
}

// Otherwise each line of a packed set would read the files of the whole set.
TEST_F(OfflineFolder, FilesOfTheWholeRunAreLookedAtOnce) {
  run(0, kFrames);
  class PackedFrames final : public FrameFormat {
   public:
    Result<EncodedFrame> encode(const sinks::FrameImage&) override { return EncodedFrame{}; }
    bool is_packed(const fs::path&) const override { return ++looks_ == 1; }
    bool is_complete(const fs::path&, uint64_t, const nlohmann::json&, bool is_packed) const override {
      return is_packed;
    }
    Result<EncodedFrame> load(const fs::path&, uint64_t, const std::string&, const Manifest&) const override {
      return EncodedFrame{};
    }
    mutable int looks_ = 0;
  };
  const PackedFrames format;
  const auto listed = listed_frames(folder_, manifest_of(), format);
  ASSERT_TRUE(listed.ok());
  EXPECT_EQ(listed->size(), kFrames);
  EXPECT_EQ(format.looks_, 1);
}

TEST_F(OfflineFolder, ManifestIsValidated) {
  fs::create_directories(folder_);
  Manifest manifest = manifest_of(2, 3);
  manifest.machine = kMachine;
  ASSERT_TRUE(write_manifest(folder_, manifest).ok());
  const auto back = read_manifest(folder_);
  ASSERT_TRUE(back.ok() && *back);
  EXPECT_FALSE(difference(**back, manifest, true));
  EXPECT_EQ((*back)->machine, kMachine);
  EXPECT_EQ((*back)->times.first_ns, -5);
  const std::string text = text_of(kManifestName);
  std::mt19937 random(5);
  uint64_t refused = 0;
  for (int i = 0; i < 1000; ++i) {
    std::string damaged = text;
    damaged[random() % damaged.size()] = static_cast<char>(random());
    if (i % 3 == 0) damaged.resize(random() % damaged.size());
    fs::remove(folder_ / kManifestName);  // a new file is faster than a truncated one
    write(kManifestName, damaged);
    const auto read = read_manifest(folder_);
    refused += !read.ok();
    if (!read || !*read) continue;
    EXPECT_LE((*read)->times.frames, kMaxFrames);
    EXPECT_TRUE((*read)->shard >= 1 && (*read)->shard <= (*read)->shards);
    EXPECT_LE((*read)->part().first + (*read)->part().frames, (*read)->times.frames);
  }
  EXPECT_GT(refused, 500u);
}

// Command-line paths are arbitrary bytes of arbitrary number.
TEST_F(OfflineFolder, SettingsRoundTrip) {
  const std::string lengthy = "--assets /" + std::string(6000, 'a');
  const std::vector<std::string> values{"--assets /data/caf\xe9", "--assets /data/caf\xe8", lengthy,
                                        lengthy + "b"};
  for (const std::string& value : values) {
    Manifest manifest = manifest_of();
    manifest.settings[1].second = setting_text(value);
    fs::remove_all(folder_);
    EXPECT_EQ(run(0, 2, manifest), 0u);
    EXPECT_EQ(refused(manifest), "");
    for (const std::string& another : values) {
      manifest.settings[1].second = setting_text(another);
      EXPECT_EQ(refused(manifest).empty(), another == value) << another;
    }
  }
}

TEST_F(OfflineFolder, AManifestHasFewSettings) {
  fs::create_directories(folder_);
  Manifest manifest = manifest_of();
  while (manifest.settings.size() < 64)
    manifest.settings.emplace_back("s" + std::to_string(manifest.settings.size()), "x");
  ASSERT_TRUE(write_manifest(folder_, manifest).ok());
  EXPECT_TRUE(read_manifest(folder_).ok());
  manifest.settings.emplace_back("one more", "x");
  ASSERT_TRUE(write_manifest(folder_, manifest).ok());
  EXPECT_FALSE(read_manifest(folder_).ok());
}

}  // namespace
}  // namespace fire3dv::offline
