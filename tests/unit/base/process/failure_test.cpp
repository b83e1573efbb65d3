// Test of the texts of failures that end a program: limits by name, and what was being done.
#include "base/process/failure.h"

#include <gtest/gtest.h>

#include <new>
#include <stdexcept>
#include <string>
#include <system_error>

#include "base/process/start_thread.h"

namespace fire3dv {
namespace {

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Failure, ThreadLimitIsNamed) {
  const std::string text =
      thread_failure_text("recording", std::make_error_code(std::errc::resource_unavailable_try_again));
  EXPECT_TRUE(has(text, "the recording thread cannot be started")) << text;
  EXPECT_TRUE(has(text, "ulimit -u, now ")) << text;
}

TEST(Failure, InnermostActivityIsNamed) {
  const auto caught = [](const auto& work) {
    try {
      const Activity outer("drawing an image");
      { const Activity over("loading the scene"); }
      work();
    } catch (const std::exception& failure) {
      return describe_failure(failure);
    }
    return std::string();
  };
  EXPECT_EQ(describe_failure(std::runtime_error("it broke")), "it broke") << "nothing is known";
  const std::string text = caught([] {
    const Activity inner("uploading textures");
    throw std::bad_alloc();
  });
  EXPECT_TRUE(has(text, "out of memory while uploading textures; ")) << text;
}

}  // namespace
}  // namespace fire3dv
