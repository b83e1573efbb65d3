// Test of outputs that the user names: files, links, pipes.
#include "base/output/output_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "base/unique_fd.h"

namespace fire3dv::base {
namespace {

namespace fs = std::filesystem;

class OutputFile : public testing::Test {
 protected:
  OutputFile() {
    std::string name = (fs::temp_directory_path() / "fire3dv-output-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~OutputFile() override { fs::remove_all(folder_); }

  static std::string text_of(const fs::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  static std::span<const std::byte> bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

  fs::path folder_;
};

TEST_F(OutputFile, LinksStayAndTheirFilesAreWritten) {
  std::ofstream(folder_ / "file") << "old";
  ::chmod((folder_ / "file").c_str(), 0600);
  fs::create_symlink("file", folder_ / "link");
  fs::create_symlink("new", folder_ / "dangling");
  ASSERT_TRUE(write_output(folder_ / "link", bytes("text")).ok());
  ASSERT_TRUE(write_output(folder_ / "dangling", bytes("other")).ok());
  EXPECT_TRUE(fs::is_symlink(folder_ / "link") && fs::is_symlink(folder_ / "dangling"));
  EXPECT_EQ(text_of(folder_ / "file"), "text");
  EXPECT_EQ(fs::status(folder_ / "file").permissions(), fs::perms(0600));
  EXPECT_EQ(text_of(folder_ / "new"), "other");
}

TEST_F(OutputFile, PipesStay) {
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const UniqueFd reader(::open(pipe.c_str(), O_RDONLY | O_NONBLOCK));
  ASSERT_TRUE(write_output(pipe, bytes("text")).ok());
  std::string text(16, '\0');
  EXPECT_EQ(::read(reader.get(), text.data(), text.size()), 4);
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST_F(OutputFile, OpenPipesAreWrittenByTheirNameInProc) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const UniqueFd reader(ends[0]), writer(ends[1]);
  const fs::path name = "/proc/self/fd/" + std::to_string(writer.get());
  EXPECT_TRUE(is_open_as(writer.get(), name));
  EXPECT_FALSE(is_open_as(writer.get(), folder_));
  EXPECT_FALSE(is_open_as(writer.get(), folder_ / "none"));
  ASSERT_TRUE(write_output(name, bytes("text")).ok());
  std::string text(16, '\0');
  EXPECT_EQ(::read(reader.get(), text.data(), text.size()), 4);
}

TEST_F(OutputFile, FilesBehindDescriptorsAreContinued) {
  const fs::path log = folder_ / "log";
  const UniqueFd writer(::open(log.c_str(), O_WRONLY | O_CREAT, 0600));
  ASSERT_TRUE(write_descriptor(writer.get(), bytes("before ")).ok());
  fs::create_symlink("/dev/fd/" + std::to_string(writer.get()), folder_ / "link");
  ASSERT_TRUE(write_output("/dev/fd/" + std::to_string(writer.get()), bytes("report ")).ok());
  ASSERT_TRUE(write_output(folder_ / "link", bytes("again ")).ok());
  ASSERT_TRUE(write_descriptor(writer.get(), bytes("after")).ok());
  EXPECT_EQ(text_of(log), "before report again after");
  EXPECT_TRUE(is_open_as(writer.get(), log)) << "the file was replaced";
}

TEST_F(OutputFile, DescriptorsForReadingAreRefused) {
  std::ofstream(folder_ / "file") << "old";
  const UniqueFd reader(::open((folder_ / "file").c_str(), O_RDONLY));
  EXPECT_FALSE(write_output("/proc/self/fd/" + std::to_string(reader.get()), bytes("text")).ok());
  EXPECT_EQ(text_of(folder_ / "file"), "old");
}

TEST_F(OutputFile, NamesThatCannotBeLookedUpAreRefused) {
  std::ofstream(folder_ / "file") << "old";
  const fs::path below = folder_ / "file" / "x";
  const Result<void> written = write_output(below, bytes("text"));
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().message, "cannot write \"" + below.string() + "\": Not a directory");
  fs::create_symlink("loop", folder_ / "loop");
  EXPECT_FALSE(write_output(folder_ / "loop", bytes("text")).ok());
  EXPECT_TRUE(fs::is_symlink(folder_ / "loop"));
}

TEST_F(OutputFile, FoldersAreRefused) {
  const Result<void> written = write_output(folder_, bytes("text"));
  ASSERT_FALSE(written.ok());
  EXPECT_NE(written.error().message.find("cannot write \"" + folder_.string()), std::string::npos);
}

}  // namespace
}  // namespace fire3dv::base
