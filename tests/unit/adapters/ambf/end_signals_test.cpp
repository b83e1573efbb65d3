// Test of the plugin's end on SIGTERM, which AMBF does not handle: the stream ends with a goodbye, no files
// remain, and the previous signal action follows. Runs in child processes, since signals are per process.
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>

#include "tests/unit/adapters/ambf/plugin_world.h"

namespace fire3dv::test {
namespace {

constexpr int kHandlerRan = 77;

std::string file_of(const std::string& uri) {
  return "/dev/shm/fire3dv." + uri.substr(std::string("shm://").size());
}

// Starts AMBF in a child process that steps until it is killed.
template <typename Before>
pid_t start_ambf(const std::string& uri, Before&& before) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  ::alarm(120);  // hang limit
  before();
  AmbfWorld ambf(uri);
  ambf.body("a");
  if (ambf.init() != ambf::SUCCESS) ::_exit(1);
  for (;;) {
    ambf.step();
    ::usleep(1000);
  }
}

int ended(pid_t child) {
  int status = 0;
  return ::waitpid(child, &status, 0) == child ? status : -1;
}

class AmbfPluginEnd : public testing::Test {
 protected:
  AmbfPluginEnd() : uri_(ambf_uri()), renderer_(uri_) {}
  ::testing::AssertionResult comes() {
    const bool came = renderer_.poll_until([&] { return renderer_.frames.size() > 5; });
    return came && std::filesystem::exists(file_of(uri_)) ? testing::AssertionSuccess()
                                                          : testing::AssertionFailure();
  }
  std::string uri_;
  AmbfRenderer renderer_;
};

TEST_F(AmbfPluginEnd, SigtermEndsCleanly) {
  for (const int number : {SIGTERM, SIGHUP}) {
    const pid_t child = start_ambf(uri_, [] {
      ::signal(SIGTERM, SIG_DFL);
      ::signal(SIGHUP, SIG_DFL);
    });
    ASSERT_TRUE(comes());
    ::kill(child, number);
    const int status = ended(child);
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == number) << status;
    EXPECT_FALSE(std::filesystem::exists(file_of(uri_)));
    EXPECT_TRUE(renderer_.poll_until([&] { return renderer_.ended; }));
    renderer_.frames.clear();
    renderer_.ended = false;
  }
}

TEST_F(AmbfPluginEnd, EarlierHandlerIsCalled) {
  const pid_t child = start_ambf(uri_, [] { ::signal(SIGTERM, [](int) { ::_exit(kHandlerRan); }); });
  ASSERT_TRUE(comes());
  ::kill(child, SIGTERM);
  const int status = ended(child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == kHandlerRan) << status;
  EXPECT_FALSE(std::filesystem::exists(file_of(uri_)));
}

TEST_F(AmbfPluginEnd, IgnoredSignalStaysIgnored) {
  const pid_t child = start_ambf(uri_, [] { ::signal(SIGTERM, SIG_IGN); });
  ASSERT_TRUE(comes());
  ::kill(child, SIGTERM);
  const size_t before = renderer_.frames.size();
  EXPECT_TRUE(renderer_.poll_until([&] { return renderer_.frames.size() > before + 20; }));
  ::kill(child, SIGKILL);
  ended(child);
  std::filesystem::remove(file_of(uri_));
}

TEST_F(AmbfPluginEnd, CloseRestoresHandlers) {
  const auto handler = [](int) {};
  ::signal(SIGHUP, handler);
  {
    AmbfWorld ambf(uri_);
    ambf.body("a");
    ASSERT_EQ(ambf.init(), ambf::SUCCESS);
    ambf.step();
    ASSERT_TRUE(std::filesystem::exists(file_of(uri_)));
  }
  EXPECT_FALSE(std::filesystem::exists(file_of(uri_)));
  EXPECT_EQ(::signal(SIGHUP, SIG_DFL), static_cast<sighandler_t>(handler));
}

}  // namespace
}  // namespace fire3dv::test
