// Test of the publish hot path over shared memory: no allocation after the first frame, and no system call.
// An interposer counts allocations; ptrace counts the system calls of a child between two marker calls.
#include <gtest/gtest.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <csignal>
#include <map>
#include <string>
#include <vector>

#include "fire3dv/client.h"
#include "tests/unit/allocation_count.h"

namespace fire3dv::test {
namespace {

constexpr size_t kNodes = 1000;
constexpr int kFrames = 1000;
constexpr long kMarker = SYS_getppid;  // unused elsewhere in this program

class Publisher {
 public:
  Publisher() : names_(kNodes), poses_(kNodes * 12, 0.5f) {
    std::vector<const char*> pointers;
    for (size_t i = 0; i < kNodes; ++i) names_[i] = "node " + std::to_string(i);
    for (const std::string& name : names_) pointers.push_back(name.c_str());
    const std::string uri = "shm://hot-path-" + std::to_string(::getpid());
    stream_ = fire3dv_open(uri.c_str(), nullptr);
    fire3dv_description description{};
    description.struct_size = sizeof description;
    description.node_names = pointers.data();
    description.node_count = kNodes;
    good_ = stream_ && fire3dv_describe(stream_, &description) == FIRE3DV_OK && publish(1);
  }
  ~Publisher() { fire3dv_close(&stream_); }
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

  bool good() const { return good_; }
  bool publish(int frames) {
    for (int i = 0; i < frames; ++i) {
      poses_[static_cast<size_t>(i) % poses_.size()] += 1;
      if (fire3dv_publish(stream_, i, poses_.data(), kNodes, 0) != FIRE3DV_OK) return false;
    }
    return true;
  }

 private:
  std::vector<std::string> names_;
  std::vector<float> poses_;
  fire3dv_stream* stream_ = nullptr;
  bool good_ = false;
};

TEST(ClientHotPath, AllocatesNothing) {
  Publisher publisher;
  ASSERT_TRUE(publisher.good()) << fire3dv_last_error();
  const uint64_t before = allocations_of_this_thread();
  ASSERT_GT(before, 0u) << "the counter counts nothing";
  ASSERT_TRUE(publisher.publish(kFrames));
  EXPECT_EQ(allocations_of_this_thread() - before, 0u);
}

// Child process: runs work between two markers. Destructors run after the second one, outside of the count.
template <typename Work>
[[noreturn]] void be_traced(Work work) {
  Publisher publisher;
  if (!publisher.good()) ::_exit(1);
  ::ptrace(PTRACE_TRACEME, 0, nullptr, nullptr);
  ::raise(SIGSTOP);
  ::syscall(kMarker);
  const bool worked = work(publisher);
  ::syscall(kMarker);
  publisher.~Publisher();
  ::_exit(worked ? 0 : 1);
}

// Counts system calls between the markers, by number. -1 counts abnormal exits.
template <typename Work>
std::map<long, int> count_system_calls(Work work) {
  const pid_t child = ::fork();
  if (child == 0) be_traced(work);
  std::map<long, int> calls;
  int status = 0;
  bool entering = true;
  int markers = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  if (WIFSTOPPED(status))
    ::ptrace(PTRACE_SETOPTIONS, child, nullptr, PTRACE_O_TRACESYSGOOD | PTRACE_O_EXITKILL);
  while (WIFSTOPPED(status)) {
    const int signal = WSTOPSIG(status);
    if (signal == (SIGTRAP | 0x80)) {
      if (entering) {
        __ptrace_syscall_info info{};
        ::ptrace(PTRACE_GET_SYSCALL_INFO, child, sizeof info, &info);
        const long number = static_cast<long>(info.entry.nr);
        if (number == kMarker) {
          ++markers;
        } else if (markers == 1) {
          ++calls[number];
        }
      }
      entering = !entering;
    }
    const bool forward = signal != (SIGTRAP | 0x80) && signal != SIGSTOP && signal != SIGTRAP;
    if (::ptrace(PTRACE_SYSCALL, child, nullptr, forward ? static_cast<long>(signal) : 0L) != 0) break;
    if (::waitpid(child, &status, 0) != child) break;
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || markers != 2) ++calls[-1];
  return calls;
}

std::string listed(const std::map<long, int>& calls) {
  std::string text;
  for (const auto& [number, count] : calls)
    text += " #" + std::to_string(number) + " x " + std::to_string(count);
  return text;
}

TEST(ClientHotPath, TheTracerCounts) {
  const std::map<long, int> calls = count_system_calls([](Publisher&) {
    for (int i = 0; i < 7; ++i) ::syscall(SYS_getuid);
    return true;
  });
  EXPECT_EQ(calls, (std::map<long, int>{{SYS_getuid, 7}})) << listed(calls);
}

TEST(ClientHotPath, MakesNoSystemCall) {
  // Without a user-space clock (vDSO) each clock read is a system call; it is the only one allowed then.
  const std::map<long, int> clock = count_system_calls([](Publisher&) {
    timespec now{};
    return ::clock_gettime(CLOCK_MONOTONIC, &now) == 0;
  });
  std::map<long, int> calls =
      count_system_calls([](Publisher& publisher) { return publisher.publish(kFrames); });
  if (clock.count(SYS_clock_gettime)) {
    RecordProperty("clock", "system call");
    calls.erase(SYS_clock_gettime);
  }
  EXPECT_TRUE(calls.empty()) << listed(calls);
}

}  // namespace
}  // namespace fire3dv::test
