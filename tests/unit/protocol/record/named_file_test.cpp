// Test of the check of a file's name: removed, moved and replaced files are told apart.
#include "protocol/record/mcap/named_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "base/unique_fd.h"

namespace fire3dv::record {
namespace {

TEST(NamedFile, LostNamesAreErrors) {
  namespace fs = std::filesystem;
  const fs::path path = fs::path(testing::TempDir()) / ("named-file-" + std::to_string(::getpid()));
  const fs::path other = path.string() + ".other";
  const auto open = [&] { return UniqueFd(::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600)); };
  const auto message = [&](const UniqueFd& fd) {
    const Result<void> named = check_name_of(fd.get(), path.string());
    return named ? std::string() : named.error().message;
  };
  UniqueFd fd = open();
  EXPECT_EQ(message(fd), "");
  fs::rename(path, other);
  EXPECT_NE(message(fd).find(" was moved while it was written"), std::string::npos) << message(fd);
  std::ofstream(path) << "another";
  EXPECT_NE(message(fd).find(" was moved and replaced while"), std::string::npos) << message(fd);
  fs::rename(other, path);
  EXPECT_EQ(message(fd), "");
  fs::remove(path);
  EXPECT_NE(message(fd).find(" was removed while"), std::string::npos) << message(fd);
  std::ofstream(path) << "another";
  EXPECT_NE(message(fd).find(" was replaced while"), std::string::npos) << message(fd);
  fs::remove(path);
}

}  // namespace
}  // namespace fire3dv::record
