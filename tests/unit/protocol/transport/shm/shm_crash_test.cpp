// Crash test of shared memory between processes: killed, stopped and forked writers and readers; no frame is
// torn.
#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <random>
#include <thread>

#include "base/unique_fd.h"
#include "protocol/transport/shm/shm_segment.h"
#include "tests/unit/protocol/transport/child.h"
#include "tests/unit/protocol/transport/link_fixture.h"

namespace fire3dv::transport::test {
namespace {

constexpr size_t kFrameBytes = 16 << 10;

// Publishes frames at full speed; all bytes of a frame are equal. Never returns.
void publish_uniform_frames(const std::string& uri, uint64_t run) {
  auto publisher = open_publisher(uri);
  if (!publisher) ::_exit(1);
  const std::string description = "run " + std::to_string(run);
  if (!(*publisher)->set_description(bytes_of(description))) ::_exit(1);
  std::vector<std::byte> frame(kFrameBytes);
  for (uint64_t i = 0;; ++i) {
    std::fill(frame.begin(), frame.end(), static_cast<std::byte>(i));
    const std::span<const std::byte> all = frame;
    (*publisher)->publish({all.first(100), all.subspan(100)});
  }
}

bool is_uniform(const std::string& frame) {
  return frame.size() == kFrameBytes && frame.find_first_not_of(frame[0]) == std::string::npos;
}

TEST(ShmCrash, KilledWritersLeaveWholeFrames) {
  const std::string uri = unique_shm_uri("kill");
  Listener listener(uri);
  std::mt19937 generator(7345);
  uint64_t frames = 0;
  for (uint64_t run = 0; run < 50; ++run) {
    Child writer([&] { publish_uniform_frames(uri, run); });
    const std::string description = "run " + std::to_string(run);
    uint64_t of_this_run = 0;
    bool described = false;  // messages before the description belong to the last run
    const uint64_t wanted = 1 + generator() % 50;
    ASSERT_TRUE(listener.poll_until([&] {
      for (const Event& event : listener.events) {
        if (event.kind == Kind::control) described = event.text == description;
        if (event.kind != Kind::pose) continue;
        EXPECT_TRUE(is_uniform(event.text)) << "a torn frame";
        of_this_run += described;
        ++frames;
      }
      listener.events.clear();
      return of_this_run >= wanted;
    })) << "run "
        << run;
    ::usleep(generator() % 2000);
    writer.kill();
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GE(frames, 50u);
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::disconnected) == 1; }));
  EXPECT_EQ(listener.last(Kind::disconnected), "the publisher died");
  open_publisher_or_fail(uri);  // its destructor removes the dead publisher's file
}

std::string path_of(const std::string& uri) {
  return shm::segment_path(uri.substr(std::string("shm://").size()));
}

bool is_there(const std::string& path) {
  struct stat info {};
  return ::lstat(path.c_str(), &info) == 0;
}

// Waits for the child's segment. Another process may remove a dead one at any time, so that tests only look
// for living ones.
void await_segment(const std::string& uri) {
  const auto until = std::chrono::steady_clock::now() + kHangLimit;
  while (!is_there(path_of(uri)) && std::chrono::steady_clock::now() < until) ::usleep(1000);
  ASSERT_TRUE(is_there(path_of(uri))) << uri;
}

TEST(ShmCrash, NextStartRemovesSegmentsOfTheDead) {
  for (const bool is_renderer : {false, true}) {
    const std::string dead = unique_shm_uri("dead"), alive = unique_shm_uri("alive");
    Child killed([&] { publish_uniform_frames(dead, 1); });
    Child living([&] { publish_uniform_frames(alive, 1); });
    await_segment(dead);
    await_segment(alive);
    // As of a publisher that was killed while it replaced its segment.
    const std::string hidden = "/dev/shm/.fire3dv." + dead.substr(6) + ".0123456789abcdef";
    const std::string hidden_alive = "/dev/shm/.fire3dv." + alive.substr(6) + ".0123456789abcdef";
    ASSERT_EQ(::link(path_of(dead).c_str(), hidden.c_str()), 0);
    ASSERT_EQ(::link(path_of(alive).c_str(), hidden_alive.c_str()), 0);
    // Somebody else's file under such a name.
    const std::string foreign = path_of(unique_shm_uri("foreign"));
    ASSERT_TRUE(UniqueFd(::open(foreign.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600)));
    ASSERT_EQ(::truncate(foreign.c_str(), 1 << 20), 0);
    killed.kill();
    const std::string next = unique_shm_uri("next");
    if (is_renderer) {
      EXPECT_TRUE(open_listener(next));
    } else {
      open_publisher_or_fail(next);
    }
    EXPECT_FALSE(is_there(path_of(dead))) << is_renderer;
    EXPECT_FALSE(is_there(hidden)) << is_renderer;
    EXPECT_TRUE(is_there(path_of(alive))) << is_renderer;
    EXPECT_TRUE(is_there(hidden_alive)) << is_renderer;
    EXPECT_TRUE(is_there(foreign)) << is_renderer;
    Listener listener(alive);
    EXPECT_TRUE(listener.poll_until([&] { return listener.count(Kind::pose) > 0; }));
    living.kill();
    EXPECT_TRUE(listener.poll_until([&] { return listener.count(Kind::disconnected) == 1; }));
    EXPECT_FALSE(is_there(path_of(alive))) << "a reader removes what its publisher left";
    ::unlink(hidden_alive.c_str());
    ::unlink(foreign.c_str());
  }
}

TEST(ShmCrash, EndingRendererRemovesDeadSegment) {
  const std::string uri = unique_shm_uri("ends");
  Child writer([&] { publish_uniform_frames(uri, 1); });
  {
    Listener listener(uri);
    ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::pose) > 0; }));
  }
  EXPECT_TRUE(is_there(path_of(uri)));
  {
    const Listener listener(uri);
    writer.kill();
  }
  EXPECT_FALSE(is_there(path_of(uri)));
}

TEST(ShmCrash, AStoppedWriterIsAlive) {
  const std::string uri = unique_shm_uri("stop");
  Listener listener(uri);
  Child writer([&] { publish_uniform_frames(uri, 1); });
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::pose) > 0; }));
  writer.signal(SIGSTOP);
  for (int i = 0; i < 20; ++i) {
    ::usleep(10'000);
    listener.poll();
  }
  EXPECT_EQ(listener.count(Kind::disconnected), 0u);
  writer.signal(SIGCONT);
  listener.events.clear();
  EXPECT_TRUE(listener.poll_until([&] { return listener.count(Kind::pose) > 0; }));
  writer.kill();
  EXPECT_TRUE(listener.poll_until([&] { return listener.count(Kind::disconnected) == 1; }));
  open_publisher_or_fail(uri);
}

TEST(ShmCrash, DeadReadersSlotsAreFreed) {
  const std::string uri = unique_shm_uri("readers");
  auto publisher = open_publisher_or_fail(uri);
  for (int run = 0; run < 20; ++run) {
    Child reader([&] {
      auto listener = open_listener(uri);
      if (!listener) ::_exit(1);
      bool said = false;
      while (true) {
        (*listener)->poll([&](const LinkEvent& event) {
          if (event.kind != Kind::connected || said) return;
          (*listener)->send(event.peer, bytes_of("hello" + std::to_string(run)));
          said = true;
        });
        (*listener)->wait(std::chrono::milliseconds(1));
      }
    });
    ASSERT_TRUE(poll_until_reply(*publisher, "hello" + std::to_string(run))) << run;
  }
  // The last reader is dead, too: all places are free.
  std::vector<std::byte> message;
  const auto until = std::chrono::steady_clock::now() + kHangLimit;
  do publisher->poll(message);
  while (publisher->stats().peers != 0 && std::chrono::steady_clock::now() < until);
  EXPECT_EQ(publisher->stats().peers, 0u);
}

TEST(ShmCrash, StoppedReaderCostsWriterNothing) {
  const std::string uri = unique_shm_uri("stopreader");
  auto publisher = open_publisher_or_fail(uri);
  Child reader([&] {
    auto listener = open_listener(uri);
    if (!listener) ::_exit(1);
    while (true) {
      (*listener)->poll([&](const LinkEvent& event) {
        if (event.kind == Kind::pose) (*listener)->send(event.peer, bytes_of("seen"));
      });
      (*listener)->wait(std::chrono::milliseconds(1));
    }
  });
  publisher->publish(message_of("pose"));
  ASSERT_TRUE(poll_until_reply(*publisher, "seen"));
  reader.signal(SIGSTOP);
  for (int i = 0; i < 10'000; ++i) EXPECT_TRUE(publisher->publish(message_of("more")));
  EXPECT_EQ(publisher->stats().poses_dropped, 0u);
  reader.signal(SIGCONT);
  publisher->publish(message_of("pose"));
  EXPECT_TRUE(poll_until_reply(*publisher, "seen"));
}

// A simulator forks a helper and dies: the helper keeps no lock of the link.
TEST(ShmCrash, ForkedChildReleasesSegment) {
  const std::string uri = unique_shm_uri("fork");
  int ready[2];
  ASSERT_EQ(::pipe2(ready, O_CLOEXEC), 0);
  pid_t helper = 0;
  Child simulator([&] {
    auto publisher = open_publisher(uri);
    if (!publisher || !(*publisher)->set_description(bytes_of("description"))) ::_exit(1);
    (*publisher)->publish(message_of("pose"));
    const pid_t forked = ::fork();
    if (forked == 0) {
      // The parent's link: calls of the child change nothing, without a crash.
      (*publisher)->publish(message_of("not mine"));
      if ((*publisher)->set_description(bytes_of("not mine"))) ::_exit(1);
      const pid_t own = ::getpid();
      [[maybe_unused]] const ssize_t told = ::write(ready[1], &own, sizeof own);
      while (true) ::pause();
    }
    while (true) ::pause();
  });
  ASSERT_EQ(::read(ready[0], &helper, sizeof helper), static_cast<ssize_t>(sizeof helper));
  Listener listener(uri);
  EXPECT_TRUE(listener.poll_until([&] { return listener.saw(Kind::pose, "pose"); }));
  simulator.kill();
  EXPECT_TRUE(listener.poll_until([&] { return listener.saw_part(Kind::disconnected, "died"); }));
  EXPECT_EQ(listener.count(Kind::pose), 1u);
  auto next = open_publisher(uri);
  EXPECT_TRUE(next.ok()) << "the name is free";
  ::kill(helper, SIGKILL);
  ::close(ready[0]);
  ::close(ready[1]);
}

// While a publisher takes the name over from a dead one, readers attach at every moment: none of them
// attaches to the dead segment.
TEST(ShmCrash, DeadSegmentIsNotAttached) {
  const std::string uri = unique_shm_uri("takeover");
  for (int run = 0; run < 60; ++run) {
    {
      Child dead([&] {
        auto publisher = open_publisher(uri);
        if (!publisher || !(*publisher)->set_description(bytes_of("dead"))) ::_exit(1);
        while (true) ::pause();
      });
      Listener listener(uri);
      ASSERT_TRUE(listener.poll_until([&] { return listener.saw(Kind::control, "dead"); }));
    }
    std::unique_ptr<PublisherLink> next;
    std::thread heir([&] { next = open_publisher_or_fail(uri); });
    for (bool taken = false; !taken;) {
      Listener listener(uri);
      listener.poll();
      EXPECT_FALSE(listener.saw(Kind::control, "dead")) << "run " << run;
      taken = listener.count(Kind::connected) == 1;
    }
    heir.join();
    ASSERT_FALSE(HasFailure());
  }
}

}  // namespace
}  // namespace fire3dv::transport::test
