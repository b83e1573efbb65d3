// Access to the live view: tokens and their file.
#include "renderer/browser/server/access.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace fire3dv::serve {
namespace {

std::filesystem::path fresh_file(const char* name) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / (std::string(name) + std::to_string(::getpid()));
  std::filesystem::remove(file);
  return file;
}

TEST(Tokens, TokensGrantTheirRightsOnly) {
  const Tokens tokens = random_tokens(), others = random_tokens();
  EXPECT_EQ(tokens.control.size(), 32u);
  EXPECT_NE(tokens.control, tokens.view);
  EXPECT_NE(tokens.control, others.control);
  EXPECT_EQ(access_of(tokens, tokens.control), Access::control);
  EXPECT_EQ(access_of(tokens, tokens.view), Access::view);
  for (const std::string& wrong :
       {std::string(), others.control, tokens.control + "0", tokens.view.substr(1)})
    EXPECT_EQ(access_of(tokens, wrong), Access::none) << wrong;
}

TEST(Tokens, FileIsPrivateAndReadAgain) {
  const std::filesystem::path file = fresh_file("fire3dv_tokens");
  const Result<Tokens> created = read_or_create_tokens(file);
  ASSERT_TRUE(created.ok()) << created.error().message;
  struct stat status {};
  ASSERT_EQ(::stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
  const Result<Tokens> again = read_or_create_tokens(file);
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(again->control, created->control);
  EXPECT_EQ(again->view, created->view);
  // A file that others can read is refused, and so is one with other contents.
  ASSERT_EQ(::chmod(file.c_str(), 0644), 0);
  EXPECT_FALSE(read_or_create_tokens(file).ok());
  ASSERT_EQ(::chmod(file.c_str(), 0600), 0);
  for (const std::string& text : {std::string("short\nshort\n"), created->control + "\n",
                                  created->control + "\n" + created->control + "\n"}) {
    std::ofstream(file, std::ios::trunc) << text;
    const Result<Tokens> bad = read_or_create_tokens(file);
    ASSERT_FALSE(bad.ok()) << text;
    EXPECT_NE(bad.error().message.find("--serve-tokens"), std::string::npos);
    EXPECT_EQ(bad.error().message.find(created->control), std::string::npos) << "a token in a message";
  }
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace fire3dv::serve
