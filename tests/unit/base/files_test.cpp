// Test of atomic file replacement: temporary names, modes, and errors.
#include "base/files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

namespace fire3dv::base {
namespace {

namespace fs = std::filesystem;

class AtomicFiles : public testing::Test {
 protected:
  AtomicFiles() {
    std::string name = (fs::temp_directory_path() / "fire3dv-atomic-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~AtomicFiles() override { fs::remove_all(folder_); }

  size_t files() const { return static_cast<size_t>(std::distance(fs::directory_iterator(folder_), {})); }
  static std::string text_of(const fs::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  static std::span<const std::byte> bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

  fs::path folder_;
};

TEST_F(AtomicFiles, WritersHaveSeparateFiles) {
  const fs::path path = folder_ / "shared";
  auto first = AtomicFile::create(path), second = AtomicFile::create(path);
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_NE(first->temporary_path(), second->temporary_path());
  ASSERT_TRUE(first->append(bytes("first")).ok());
  ASSERT_TRUE(second->append(bytes("second")).ok());
  EXPECT_FALSE(fs::exists(path));
  ASSERT_TRUE(second->commit().ok());
  EXPECT_EQ(text_of(path), "second");
  ASSERT_TRUE(first->commit().ok());
  EXPECT_EQ(text_of(path), "first");
  EXPECT_EQ(files(), 1u);
}

TEST_F(AtomicFiles, NothingIsLeftWithoutCommit) {
  {
    auto file = AtomicFile::create(folder_ / "half");
    ASSERT_TRUE(file.ok());
    ASSERT_TRUE(file->append(bytes("half of it")).ok());
    auto moved = std::move(*file);
    EXPECT_EQ(files(), 1u);
  }
  EXPECT_EQ(files(), 0u);
}

TEST_F(AtomicFiles, StaleTemporariesAreRemoved) {
  const pid_t child = ::fork();
  if (child == 0) {
    auto file = AtomicFile::create(folder_ / "frame_1");
    ::_exit(file.ok() ? 0 : 1);  // without destructors, like a killed process
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_EQ(status, 0);
  ASSERT_TRUE(write_atomically(folder_ / "frame_2.part-abc", {}).ok());
  auto alive = AtomicFile::create(folder_ / "frame_3");
  ASSERT_TRUE(alive.ok());
  EXPECT_EQ(files(), 3u);
  remove_abandoned_temporaries(folder_, "other");
  EXPECT_EQ(files(), 3u);
  remove_abandoned_temporaries(folder_, "frame_");
  EXPECT_EQ(files(), 2u);
  EXPECT_TRUE(alive->commit().ok());
  EXPECT_TRUE(fs::exists(folder_ / "frame_3"));
}

TEST_F(AtomicFiles, ExistingFileNeedsOption) {
  const fs::path path = folder_ / "file";
  ASSERT_TRUE(write_atomically(path, {bytes("o"), bytes("ld")}).ok());
  const auto refused = write_atomically(path, {bytes("new")}, {.replaces = false});
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find(path.string()), std::string::npos) << refused.error().message;
  // The file may also appear during the write.
  auto late = AtomicFile::create(folder_ / "late", {.replaces = false});
  ASSERT_TRUE(late.ok());
  ASSERT_TRUE(write_atomically(folder_ / "late", {bytes("theirs")}).ok());
  EXPECT_FALSE(late->commit().ok());
  EXPECT_EQ(text_of(folder_ / "late"), "theirs");
  EXPECT_EQ(text_of(path), "old");
  ASSERT_TRUE(write_atomically(path, {bytes("new")}).ok());
  EXPECT_EQ(text_of(path), "new");
}

TEST_F(AtomicFiles, ModesAreThoseOfOptions) {
  const auto mode_of = [&](const AtomicFileOptions& options) {
    struct stat status {};
    EXPECT_TRUE(write_atomically(folder_ / "file", {}, options).ok());
    EXPECT_EQ(::stat((folder_ / "file").c_str(), &status), 0);
    return status.st_mode & 0777;
  };
  const mode_t mask = ::umask(027);
  EXPECT_EQ(mode_of({}), 0640u);
  EXPECT_EQ(mode_of({.mode = 0600}), 0600u);
  EXPECT_EQ(mode_of({.exact_mode = 0664}), 0664u);
  ::umask(mask);
}

TEST_F(AtomicFiles, LinksAreReplaced) {
  ASSERT_TRUE(write_atomically(folder_ / "outside", {bytes("theirs")}).ok());
  fs::create_symlink(folder_ / "outside", folder_ / "link");
  ASSERT_TRUE(write_atomically(folder_ / "link", {bytes("ours")}).ok());
  EXPECT_EQ(text_of(folder_ / "outside"), "theirs");
  EXPECT_FALSE(fs::is_symlink(folder_ / "link"));
}

TEST_F(AtomicFiles, ErrorsNameTheFile) {
  const fs::path path = folder_ / "missing" / "file\033[2J";
  const auto written = write_atomically(path, {bytes("text")});
  ASSERT_FALSE(written.ok());
  EXPECT_NE(written.error().message.find("missing/file?[2J"), std::string::npos) << written.error().message;
}

}  // namespace
}  // namespace fire3dv::base
