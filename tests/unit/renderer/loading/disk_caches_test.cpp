// Test of cache folders, and of cache entries for pipelines and environment maps: no invalid entry reaches
// the driver.
#include "renderer/loading/disk_caches.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <map>

#include "tests/support/gltf_builder.h"

namespace fire3dv::app {
namespace {

namespace fs = std::filesystem;
using Place = scene::SceneCacheSettings::Place;

CacheLocations places(std::string_view wanted, const std::map<std::string, const char*>& environment) {
  return find_cache_locations(wanted, [&](const char* name) {
    const auto found = environment.find(name);
    return found == environment.end() ? nullptr : found->second;
  });
}

TEST(DiskCaches, AReadOnlyFolderIsReportedOnce) {
  testing::internal::CaptureStderr();
  log_cache_error(Error{"cannot make the folder \"/ro/environments\""});
  log_cache_error(Error{"cannot make the folder \"/ro/scenes\""});
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("/ro/environments"), std::string::npos) << said;
  EXPECT_EQ(said.find("/ro/scenes"), std::string::npos) << said;
}

TEST(CacheLocations, FollowTheXdgSpecification) {
  CacheLocations found = places("auto", {{"XDG_CACHE_HOME", "/var/cache/me"}, {"HOME", "/home/me"}});
  EXPECT_EQ(found.pipelines, fs::path("/var/cache/me/fire3dv/pipelines"));
  EXPECT_EQ(found.environments, fs::path("/var/cache/me/fire3dv/environments"));
  EXPECT_EQ(found.scenes.place, Place::folder);
  EXPECT_EQ(found.scenes.folder, fs::path("/var/cache/me/fire3dv/scenes"));
  for (const char* ignored : {"", "relative/path"}) {
    found = places("auto", {{"XDG_CACHE_HOME", ignored}, {"HOME", "/home/me"}});
    EXPECT_EQ(found.scenes.folder, fs::path("/home/me/.cache/fire3dv/scenes"));
  }
}

TEST(CacheLocations, WithoutHomeNothingIsCached) {
  for (const auto& environment : {std::map<std::string, const char*>{}, {{"HOME", "not/absolute"}}}) {
    const CacheLocations found = places("auto", environment);
    EXPECT_FALSE(found.pipelines);
    EXPECT_FALSE(found.environments);
    EXPECT_EQ(found.scenes.place, Place::nowhere);
  }
}

TEST(CacheLocations, AsTheUserSays) {
  const std::map<std::string, const char*> home = {{"HOME", "/home/me"}};
  EXPECT_EQ(places("off", home).scenes.place, Place::nowhere);
  EXPECT_FALSE(places("off", home).pipelines);
  EXPECT_FALSE(places("off", home).environments);
  EXPECT_EQ(environment_store(places("off", home).environments), nullptr);
  EXPECT_EQ(places("here", home).scenes.folder, fs::path("here/scenes"));
  EXPECT_EQ(places("here", {}).pipelines, fs::path("here/pipelines"));
  EXPECT_EQ(places("beside", home).scenes.place, Place::beside_the_asset);
  EXPECT_EQ(places("beside", home).pipelines, fs::path("/home/me/.cache/fire3dv/pipelines"));
}

class PipelineFiles : public testing::Test {
 protected:
  std::string bytes() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void write(const std::string& bytes) const { std::ofstream(path_, std::ios::binary) << bytes; }

  test::ScratchFolder folder_;
  fs::path path_ = folder_.path() / "cached.pipelines";
  fire3dv::Digest kind_{1, 2, 3};
  std::vector<std::byte> data_ = std::vector<std::byte>(333, std::byte{5});
};

TEST_F(PipelineFiles, ComeBackAsTheyWere) {
  ASSERT_TRUE(store_cache_file(path_, kPipelineFiles, kind_, data_).ok());
  const auto read = read_cache_file(path_, kPipelineFiles, kind_);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(*read, data_);
}

TEST_F(PipelineFiles, OtherDeviceOrBuildIsRefused) {
  ASSERT_TRUE(store_cache_file(path_, kPipelineFiles, kind_, data_).ok());
  const auto read = read_cache_file(path_, kPipelineFiles, fire3dv::Digest{1, 2, 4});
  ASSERT_FALSE(read.ok());
  EXPECT_NE(read.error().message.find("another device"), std::string::npos) << read.error().message;
}

TEST_F(PipelineFiles, DamagedAreRefused) {
  ASSERT_TRUE(store_cache_file(path_, kPipelineFiles, kind_, data_).ok());
  const std::string good = bytes();
  for (size_t i = 0; i < good.size(); ++i) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ 0x10);
    write(bad);
    EXPECT_FALSE(read_cache_file(path_, kPipelineFiles, kind_).ok()) << i;
    write(good.substr(0, i));
    EXPECT_FALSE(read_cache_file(path_, kPipelineFiles, kind_).ok()) << i;
  }
  write(good + "x");
  EXPECT_FALSE(read_cache_file(path_, kPipelineFiles, kind_).ok());
  fs::remove(path_);
  EXPECT_FALSE(read_cache_file(path_, kPipelineFiles, kind_).ok());
}

TEST_F(PipelineFiles, KindFollowsDeviceAndDriver) {
  VkPhysicalDeviceProperties device{};
  const fire3dv::Digest before = pipeline_kind(device);
  EXPECT_EQ(pipeline_kind(device), before);
  device.driverVersion = 1;
  const fire3dv::Digest other_driver = pipeline_kind(device);
  EXPECT_NE(other_driver, before);
  device.pipelineCacheUUID[3] = 9;
  EXPECT_NE(pipeline_kind(device), other_driver);
}

class EnvironmentFolders : public PipelineFiles {
 protected:
  EnvironmentCache cache_{folder_.path() / "new" / "environments"};
  fs::path cache_path_ = cache_path(folder_.path() / "new" / "environments", kEnvironmentFiles, kind_);
};

TEST_F(EnvironmentFolders, ReturnStoredEntries) {
  EXPECT_FALSE(cache_.find(kind_, data_.size()));
  cache_.keep(kind_, data_);
  EXPECT_EQ(cache_.find(kind_, data_.size()), data_);
  EXPECT_FALSE(cache_.find(fire3dv::Digest{1, 2, 4}, data_.size()));
  EXPECT_FALSE(cache_.find(kind_, data_.size() + 1));
}

TEST_F(EnvironmentFolders, ForeignFilesAreIgnored) {
  // Under the right file name: an entry of pipelines, one with another key, one with a changed byte.
  fs::create_directories(cache_path_.parent_path());
  ASSERT_TRUE(store_cache_file(cache_path_, kPipelineFiles, kind_, data_).ok());
  EXPECT_FALSE(cache_.find(kind_, data_.size()));
  ASSERT_TRUE(store_cache_file(cache_path_, kEnvironmentFiles, fire3dv::Digest{1, 2, 4}, data_).ok());
  EXPECT_FALSE(cache_.find(kind_, data_.size()));
  ASSERT_TRUE(store_cache_file(cache_path_, kEnvironmentFiles, kind_, data_).ok());
  EXPECT_TRUE(cache_.find(kind_, data_.size()));
  path_ = cache_path_;
  std::string bad = bytes();
  bad.back() = static_cast<char>(bad.back() ^ 1);
  write(bad);
  EXPECT_FALSE(cache_.find(kind_, data_.size()));
}

TEST_F(EnvironmentFolders, UnwritableFolderIsNoError) {
  write("a file");
  EnvironmentCache in_a_file(path_ / "environments");
  in_a_file.keep(kind_, data_);
  EXPECT_FALSE(in_a_file.find(kind_, data_.size()));
}

}  // namespace
}  // namespace fire3dv::app
