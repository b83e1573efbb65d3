// What a file held is read once, and again whenever it may have changed.
#include "renderer/scene/known_digests.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/gltf_builder.h"

namespace fire3dv::scene {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMost = 1 << 20;

class KnownDigestsTest : public ::testing::Test {
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

  void replace(const std::string& text) { std::ofstream(record(), std::ios::binary) << text; }

  // The record as if the file had been read long after it was written, with a digest whose use is seen.
  void keep_settled() {
    KnownDigests known(cache_, asset_);
    true_ = known.of(asset_, kMost)->digest;
    known.keep();
    std::string text = this->text();
    const size_t digest = text.find(hex(true_)), taken = text.rfind(' ', digest - 2) + 1;
    ASSERT_NE(digest, std::string::npos);
    other_ = true_;
    other_[0] ^= 16;
    text.replace(digest, 2 * other_.size(), hex(other_));
    text.replace(taken, digest - 1 - taken, std::to_string(std::stoll(text.substr(taken)) + 10'000'000'000));
    replace(text);
  }

  Digest found() const {
    const auto held = KnownDigests(cache_, asset_).of(asset_, kMost);
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

TEST_F(KnownDigestsTest, WhatIsKnownIsNotReadAgain) {
  keep_settled();
  EXPECT_NE(true_, other_);
  EXPECT_EQ(found(), other_);
}

TEST_F(KnownDigestsTest, WhatWasJustWrittenIsReadAgain) {
  KnownDigests known(cache_, asset_);
  const Digest before = known.of(asset_, kMost)->digest;
  known.keep();
  ASSERT_FALSE(record().empty());
  write("what it h0lds");
  EXPECT_NE(found(), before);
}

TEST_F(KnownDigestsTest, WhatWasWrittenSinceIsReadAgain) {
  keep_settled();
  fs::last_write_time(asset_, fs::last_write_time(asset_) + std::chrono::seconds(1));
  EXPECT_EQ(found(), true_);
  keep_settled();
  write("something longer than before");
  EXPECT_NE(found(), other_);
  EXPECT_NE(found(), true_);
  fs::remove(asset_);
  EXPECT_FALSE(KnownDigests(cache_, asset_).of(asset_, kMost).ok());
}

TEST_F(KnownDigestsTest, WhatIsTooLargeByNowIsRefused) {
  keep_settled();
  EXPECT_FALSE(KnownDigests(cache_, asset_).of(asset_, 3).ok());
}

TEST_F(KnownDigestsTest, ADamagedRecordIsNone) {
  keep_settled();
  const std::string whole = text();
  for (size_t length = 0; length + 1 < whole.size(); ++length) {
    replace(whole.substr(0, length));
    EXPECT_EQ(found(), true_) << length;
  }
  for (const char* bad :
       {"", "fire3dv digests 1\n", "fire3dv digests 2\nx\nend\n", "fire3dv digests 1\nx\nend\n"}) {
    replace(bad);
    EXPECT_EQ(found(), true_) << bad;
  }
  std::string not_hex = whole;
  not_hex[whole.find(hex(other_)) + 20] = 'x';
  replace(not_hex);
  EXPECT_EQ(found(), true_);
}

TEST_F(KnownDigestsTest, AnotherAssetsRecordIsNotBelieved) {
  keep_settled();
  const fs::path own = record();
  const fs::path other = folder_.path() / "other.glb";
  fs::copy_file(asset_, other);
  KnownDigests known(cache_, other);
  ASSERT_TRUE(known.of(other, kMost).ok());
  known.keep();
  fs::path others;
  for (const fs::directory_entry& entry : fs::directory_iterator(cache_))
    if (entry.path() != own) others = entry.path();
  ASSERT_FALSE(others.empty());
  fs::copy_file(others, own, fs::copy_options::overwrite_existing);
  EXPECT_EQ(found(), true_);
}

TEST_F(KnownDigestsTest, WithoutAFolderNothingIsKept) {
  KnownDigests known;
  EXPECT_TRUE(known.of(asset_, kMost).ok());
  known.keep();
  EXPECT_TRUE(fs::is_empty(cache_));
}

}  // namespace
}  // namespace fire3dv::scene
