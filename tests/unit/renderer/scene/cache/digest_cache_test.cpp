// Test of the digest cache: an unchanged file is hashed once, and again whenever it may have changed.
#include "renderer/scene/cache_files.h"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <iterator>

#include "tests/support/gltf_builder.h"

namespace fire3dv::scene {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMax = 1 << 20;

class DigestCacheTest : public ::testing::Test {
 protected:
  void write(const std::string& text) { std::ofstream(asset_, std::ios::binary) << text; }

  fs::path record() const {
    for (const fs::directory_entry& entry : fs::directory_iterator(cache_)) return entry.path();
    return {};
  }

  std::string text() const {
    std::ifstream file(record(), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  // Returns the record without its checksum line.
  std::string body() const {
    const std::string text = this->text();
    return text.substr(0, text.rfind("end "));
  }

  void replace_whole(const std::string& text) { std::ofstream(record(), std::ios::binary) << text; }

  void replace(const std::string& body) {
    Checksum checksum;
    checksum.add(std::as_bytes(std::span(body)));
    replace_whole(body + "end " + std::to_string(checksum.value()) + "\n");
  }

  // Writes the record as if the file had been read long after its last write, with a changed digest that
  // reveals its use.
  void store_settled() {
    DigestCache cache(cache_, asset_);
    true_ = cache.of(asset_, kMax)->digest;
    cache.store();
    std::string text = body();
    const size_t digest = text.find(hex(true_)), taken = text.rfind(' ', digest - 2) + 1;
    ASSERT_NE(digest, std::string::npos);
    other_ = true_;
    other_[0] ^= 16;
    text.replace(digest, 2 * other_.size(), hex(other_));
    text.replace(taken, digest - 1 - taken, std::to_string(std::stoll(text.substr(taken)) + 10'000'000'000));
    replace(text);
  }

  Digest found() const {
    const auto held = DigestCache(cache_, asset_).of(asset_, kMax);
    EXPECT_TRUE(held.ok());
    return held ? held->digest : Digest{};
  }

  test::ScratchFolder folder_;
  fs::path cache_ = folder_.path() / "cache", asset_ = folder_.path() / "a b\nc.glb";
  Digest true_{}, other_{};

 private:
  void SetUp() override {
    fs::create_directory(cache_);
    write("what it holds");
  }
};

TEST_F(DigestCacheTest, CachedDigestsAreReused) {
  store_settled();
  EXPECT_NE(true_, other_);
  EXPECT_EQ(found(), other_);
}

TEST_F(DigestCacheTest, FreshFilesAreReread) {
  DigestCache cache(cache_, asset_);
  const Digest before = cache.of(asset_, kMax)->digest;
  cache.store();
  ASSERT_FALSE(record().empty());
  write("what it h0lds");
  EXPECT_NE(found(), before);
}

TEST_F(DigestCacheTest, ChangedFilesAreReread) {
  store_settled();
  fs::last_write_time(asset_, fs::last_write_time(asset_) + std::chrono::seconds(1));
  EXPECT_EQ(found(), true_);
  store_settled();
  write("something longer than before");
  EXPECT_NE(found(), other_);
  EXPECT_NE(found(), true_);
  fs::remove(asset_);
  EXPECT_FALSE(DigestCache(cache_, asset_).of(asset_, kMax).ok());
}

TEST_F(DigestCacheTest, LargeFilesAreRefused) {
  store_settled();
  EXPECT_FALSE(DigestCache(cache_, asset_).of(asset_, 3).ok());
}

TEST_F(DigestCacheTest, DamagedRecordIsNone) {
  store_settled();
  const std::string whole = text();
  for (size_t length = 0; length < whole.size(); ++length) {
    replace_whole(whole.substr(0, length));
    EXPECT_EQ(found(), true_) << length;
  }
  const size_t digit = whole.find(hex(other_)) + 20;
  std::string flipped = whole;
  flipped[digit] = flipped[digit] == '0' ? '1' : '0';
  replace_whole(flipped);
  EXPECT_EQ(found(), true_);
  // A valid checksum over an invalid record.
  for (const char* bad : {"", "fire3dv digests 1\n", "fire3dv digests 2\nx\n", "fire3dv digests 1\nx\n"}) {
    replace(bad);
    EXPECT_EQ(found(), true_) << bad;
  }
  replace_whole(whole);
  std::string not_hex = body();
  not_hex[digit] = 'x';
  replace(not_hex);
  EXPECT_EQ(found(), true_);
}

TEST_F(DigestCacheTest, ForeignRecordIsRefused) {
  store_settled();
  std::string text = body();
  const size_t line = text.find('\n') + 1;
  text.replace(line, text.find('\n', line) - line, "/elsewhere.glb");
  replace(text);
  EXPECT_EQ(found(), true_);
}

TEST_F(DigestCacheTest, FarTimesAreAccepted) {
  store_settled();
  const std::string whole = body();
  const size_t digest = whole.find(hex(other_)), taken = whole.rfind(' ', digest - 2) + 1;
  for (const std::string time :
       {"-9223372036854775808", "9223372036854775807", "99999999999999999999", "0"}) {
    std::string text = whole;
    text.replace(taken, digest - 1 - taken, time);
    replace(text);
    EXPECT_EQ(found(), time == "9223372036854775807" ? other_ : true_) << time;
  }
}

TEST_F(DigestCacheTest, NoFolderCachesNothing) {
  DigestCache cache;
  EXPECT_TRUE(cache.of(asset_, kMax).ok());
  cache.store();
  EXPECT_TRUE(fs::is_empty(cache_));
}

}  // namespace
}  // namespace fire3dv::scene
