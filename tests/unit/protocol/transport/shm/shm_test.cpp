// Test of the shared-memory link within one process: delivery, joining, restarts, growth, replies.
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <atomic>
#include <filesystem>
#include <thread>

#include "protocol/transport/core/fork_guard.h"
#include "tests/unit/protocol/transport/link_fixture.h"

namespace fire3dv::transport::test {
namespace {

// The fork starts between open and registration. The child must keep neither the file nor its locks.
TEST(ForkGuard, ForkedChildClosesDescriptor) {
  const std::string path = testing::TempDir() + "fork-guard-" + std::to_string(::getpid());
  std::atomic<bool> begins{false};
  int status = -1;
  std::thread forker;
  const UnforkableFd guarded = UnforkableFd::open([&] {
    const int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    forker = std::thread([&, fd] {
      begins = true;
      const pid_t child = ::fork();
      if (child == 0) {
        struct stat info {};
        ::_exit(::fstat(fd, &info) == 0 && S_ISREG(info.st_mode) ? 1 : 0);
      }
      ::waitpid(child, &status, 0);
    });
    while (!begins) ::usleep(100);
    ::usleep(100'000);  // without the guard, the fork is over by now
    return fd;
  });
  forker.join();
  std::filesystem::remove(path);
  ASSERT_TRUE(guarded);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0) << "the child has the file";
}

TEST(Shm, ObserverHasEveryPoseOfAnUnpolledListener) {
  constexpr size_t kPoses = 100;  // a ring has 8 slots
  const std::string uri = unique_shm_uri("observed");
  Arrivals arrivals;
  ListenerOptions options;
  options.on_arrival = arrivals.observer();
  Listener listener(uri, options);
  auto publisher = open_publisher_or_fail(uri);
  ASSERT_TRUE(publisher->set_description(bytes_of("description")));
  ASSERT_TRUE(listener.poll_until([&] { return listener.saw(Kind::control, "description"); }));
  std::vector<std::string> expected;
  for (size_t i = 0; i < kPoses; ++i) {
    expected.push_back(std::to_string(i));
    ASSERT_TRUE(publisher->publish(message_of(expected.back())));
    ASSERT_TRUE(Arrivals::wait_until([&] { return arrivals.poses().size() == expected.size(); }));
  }
  std::vector<std::byte> reply;
  ::usleep(30'000);  // readers are counted every 20 ms
  publisher->poll(reply);
  EXPECT_EQ(publisher->stats().peers, 1u) << "an observer is no renderer";
  publisher->publish(message_of("last"));
  publisher.reset();
  listener.link->end_arrivals();
  expected.push_back("last");
  EXPECT_EQ(arrivals.poses(), expected);
  uint64_t overtaken = 0;
  listener.link->poll([&](const LinkEvent& event) { overtaken += event.overtaken; });
  EXPECT_EQ(overtaken, kPoses);
  EXPECT_EQ(listener.link->stats().poses_dropped, kPoses);
}

std::string file_of(const std::string& uri) {
  return "/dev/shm/fire3dv." + uri.substr(std::string("shm://").size());
}

TEST(Shm, RemovedFileIsMadeAgain) {
  const std::string uri = unique_shm_uri("removed");
  auto publisher = open_publisher_or_fail(uri);
  ASSERT_TRUE(publisher->set_description(bytes_of("description")));
  ASSERT_TRUE(publisher->put_state(
      1, std::make_shared<wire::Bytes>(bytes_of("state").begin(), bytes_of("state").end())));
  Listener first(uri);
  ASSERT_TRUE(publish_until_seen(*publisher, first, "pose"));
  ASSERT_TRUE(std::filesystem::remove(file_of(uri)));
  ASSERT_TRUE(first.poll_until([&] { return first.saw_part(Kind::note, "removed from /dev/shm"); }));
  std::vector<std::byte> reply;
  Listener later(uri);
  ASSERT_TRUE(later.poll_until([&] {
    publisher->poll(reply);
    return later.saw(Kind::pose, "pose");
  }));
  EXPECT_TRUE(later.saw(Kind::control, "description"));
  EXPECT_TRUE(later.saw(Kind::control, "state"));
  ASSERT_TRUE(publish_until_seen(*publisher, first, "next"));
  EXPECT_EQ(first.count(Kind::disconnected), 0u) << "a connected reader follows";
  EXPECT_EQ(first.count(Kind::note), 1u);
  EXPECT_EQ(publisher->problem(), "");
  publisher.reset();
  EXPECT_FALSE(std::filesystem::exists(file_of(uri)));
}

TEST(Shm, NameTakenByAnotherPublisherIsAProblem) {
  const std::string uri = unique_shm_uri("taken");
  auto publisher = open_publisher_or_fail(uri);
  ASSERT_TRUE(std::filesystem::remove(file_of(uri)));
  auto other = open_publisher_or_fail(uri);
  std::vector<std::byte> reply;
  ASSERT_TRUE(Arrivals::wait_until([&] {
    publisher->poll(reply);
    return !publisher->problem().empty();
  }));
  EXPECT_NE(publisher->problem().find("replaced by another publisher"), std::string::npos);
  publisher.reset();
  EXPECT_TRUE(std::filesystem::exists(file_of(uri))) << "the other one's";
}

TEST(Shm, JoinerGetsDescriptionThenNewestPose) {
  const std::string uri = unique_shm_uri("join");
  auto publisher = open_publisher_or_fail(uri);
  ASSERT_TRUE(publisher->set_description(bytes_of("description")));
  for (const char* pose : {"one", "two", "three"}) EXPECT_TRUE(publisher->publish(message_of(pose)));
  Listener listener(uri);
  listener.poll();
  ASSERT_EQ(listener.events.size(), 3u);
  EXPECT_EQ(listener.events[0].kind, Kind::connected);
  EXPECT_EQ(listener.events[1].kind, Kind::control);
  EXPECT_EQ(listener.events[1].text, "description");
  EXPECT_EQ(listener.events[2].kind, Kind::pose);
  EXPECT_EQ(listener.events[2].text, "three");
  listener.poll();
  EXPECT_EQ(listener.events.size(), 3u) << "nothing is handed on twice";
}

TEST(Shm, APausedPeerIsReadLater) {
  const std::string uri = unique_shm_uri("pause");
  Listener listener(uri);
  auto publisher = open_publisher_or_fail(uri);
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::connected) == 1; }));
  listener.link->pause_peer(listener.peer(), true);
  publisher->publish(message_of("pose"));
  for (int i = 0; i < 10; ++i) listener.poll();
  EXPECT_EQ(listener.count(Kind::pose), 0u);
  publisher.reset();
  listener.poll();
  EXPECT_EQ(listener.count(Kind::disconnected), 0u) << "not before its messages";
  listener.link->pause_peer(listener.peer(), false);
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::disconnected) == 1; }));
  EXPECT_TRUE(listener.saw(Kind::pose, "pose"));
}

TEST(Shm, NewestSkipsAndCounts) {
  const std::string uri = unique_shm_uri("newest");
  Listener listener(uri);
  auto publisher = open_publisher_or_fail(uri);
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::connected) == 1; }));
  for (int i = 1; i <= 100; ++i) publisher->publish(message_of(std::to_string(i)));
  listener.poll();
  EXPECT_EQ(listener.count(Kind::pose), 1u);
  EXPECT_EQ(listener.last(Kind::pose), "100");
  EXPECT_EQ(listener.link->stats().poses_dropped, 99u);
}

TEST(Shm, AllKeepsOrderAndCountsLapped) {
  const std::string uri = unique_shm_uri("all");
  ListenerOptions options;
  options.delivery = Delivery::all;
  Listener listener(uri, options);
  auto publisher = open_publisher_or_fail(uri);
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::connected) == 1; }));
  int next = 1;
  for (int round = 0; round < 5; ++round) {
    for (int i = 0; i < 6; ++i) publisher->publish(message_of(std::to_string(next++)));
    listener.poll();
  }
  EXPECT_EQ(listener.count(Kind::pose), 30u);
  for (int i = 0; i < 30; ++i) publisher->publish(message_of(std::to_string(next++)));
  listener.poll();
  const size_t got = listener.count(Kind::pose);
  EXPECT_EQ(got + listener.link->stats().poses_dropped, 60u);
  int last = 0;
  for (const Event& event : listener.events) {
    if (event.kind != Kind::pose) continue;
    EXPECT_GT(std::stoi(event.text), last);
    last = std::stoi(event.text);
  }
  EXPECT_EQ(last, 60);
}

TEST(Shm, PieceBoundariesDoNotShow) {
  const std::string uri = unique_shm_uri("pieces");
  auto publisher = open_publisher_or_fail(uri);
  Listener listener(uri);
  std::string whole;
  for (int i = 0; i < 61; ++i) whole += static_cast<char>('A' + i % 26);
  for (size_t total = 0; total <= whole.size(); ++total) {
    for (size_t cut = 0; cut <= total; ++cut) {
      const std::string_view text(whole.data(), total);
      ASSERT_TRUE(publisher->publish({bytes_of(text.substr(0, cut)), bytes_of(text.substr(cut))}));
      listener.poll();
      ASSERT_EQ(listener.last(Kind::pose), text);
      listener.events.clear();
    }
  }
}

TEST(Shm, GrowthKeepsPeer) {
  const std::string uri = unique_shm_uri("grow");
  ListenerOptions options;
  options.delivery = Delivery::all;
  Listener listener(uri, options);
  auto publisher = open_publisher_or_fail(uri);
  ASSERT_TRUE(publisher->set_description(bytes_of("small")));
  EXPECT_TRUE(publisher->publish(message_of("before")));
  listener.poll_until([&] { return listener.count(Kind::pose) == 1; });
  const std::string large(300'000, 'p');
  const std::string description(200'000, 'd');
  EXPECT_TRUE(publisher->publish(message_of("last of the small")));
  EXPECT_TRUE(publisher->publish(message_of(large)));
  publisher->send_control(bytes_of("ping"));
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::pose) == 3; }));
  ASSERT_TRUE(publisher->set_description(bytes_of(description)));
  EXPECT_TRUE(publisher->publish(message_of("after")));
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::pose) == 4; }));
  EXPECT_TRUE(listener.saw(Kind::pose, large));
  EXPECT_TRUE(listener.saw(Kind::control, description));
  EXPECT_TRUE(listener.saw(Kind::control, "ping"));
  EXPECT_EQ(listener.count(Kind::control), 3u) << "the small description is not repeated";
  EXPECT_EQ(listener.count(Kind::connected), 1u);
  EXPECT_EQ(listener.count(Kind::disconnected), 0u);
  EXPECT_EQ(listener.link->stats().poses_dropped, 0u);
}

// The carried-over pose was published in a segment that the reader never saw, or in one that it saw.
TEST(Shm, MissedSegmentsPoseArrives) {
  for (const Delivery delivery : {Delivery::newest, Delivery::all}) {
    const std::string uri = unique_shm_uri("growtwice");
    Listener listener(uri, {.delivery = delivery});
    auto publisher = open_publisher_or_fail(uri);
    ASSERT_TRUE(publisher->set_description(bytes_of("d")).ok());
    publisher->publish(message_of("one"));
    ASSERT_TRUE(listener.poll_until([&] { return listener.saw(Kind::pose, "one"); }));
    ASSERT_TRUE(publisher->make_room_for_images(4096, 1).ok());
    publisher->publish(message_of("two"));
    ASSERT_TRUE(publisher->make_room_for_images(100'000, 1).ok());
    EXPECT_TRUE(listener.poll_until([&] { return listener.saw(Kind::pose, "two"); }));
    ASSERT_TRUE(publisher->make_room_for_images(1'000'000, 1).ok());
    ASSERT_TRUE(publisher->make_room_for_images(2'000'000, 1).ok());
    publisher->publish(message_of("three"));
    EXPECT_TRUE(listener.poll_until([&] { return listener.saw(Kind::pose, "three"); }));
    EXPECT_EQ(listener.count(Kind::pose), 3u) << "and none that it has seen";
    EXPECT_EQ(listener.count(Kind::connected), 1u);
  }
}

TEST(Shm, ReplyDuringGrowthArrives) {
  const std::string uri = unique_shm_uri("growreply");
  Listener listener(uri);
  auto publisher = open_publisher_or_fail(uri);
  ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::connected) == 1; }));
  EXPECT_TRUE(publisher->publish(message_of(std::string(100'000, 'x'))));
  listener.link->send(listener.peer(), bytes_of("into the old one"));
  EXPECT_TRUE(poll_until_reply(*publisher, "into the old one"));
}

TEST(Shm, PublisherRestarts) {
  const std::string uri = unique_shm_uri("restart");
  Listener listener(uri);
  PeerId earlier = 0;
  for (int run = 0; run < 3; ++run) {
    auto publisher = open_publisher_or_fail(uri);
    ASSERT_TRUE(publisher->set_description(bytes_of("the same")));
    ASSERT_TRUE(publish_until_seen(*publisher, listener, "pose"));
    EXPECT_EQ(listener.count(Kind::control), 1u)
        << "a new peer's description is handed on even when it is the same";
    EXPECT_GT(listener.peer(), earlier);
    earlier = listener.peer();
    publisher->send_control(bytes_of("goodbye"));
    publisher.reset();
    ASSERT_TRUE(listener.poll_until([&] { return listener.count(Kind::disconnected) == 1; }));
    EXPECT_EQ(listener.events[listener.events.size() - 2].text, "goodbye");
    listener.events.clear();
  }
}

TEST(Shm, ListenerRestartIsTransparent) {
  const std::string uri = unique_shm_uri("relisten");
  auto publisher = open_publisher_or_fail(uri);
  ASSERT_TRUE(publisher->set_description(bytes_of("d")));
  for (int run = 0; run < 20; ++run) {  // more often than there are reader places
    Listener listener(uri);
    ASSERT_TRUE(publish_until_seen(*publisher, listener, "pose"));
    listener.link->send(listener.peer(), bytes_of("reply" + std::to_string(run)));
    ASSERT_TRUE(poll_until_reply(*publisher, "reply" + std::to_string(run)));
    EXPECT_EQ(listener.count(Kind::note), 0u);
  }
}

TEST(Shm, ListenersGetAllAndReply) {
  const std::string uri = unique_shm_uri("many");
  auto publisher = open_publisher_or_fail(uri);
  std::vector<std::unique_ptr<Listener>> listeners;
  for (int i = 0; i < 17; ++i) {
    listeners.push_back(std::make_unique<Listener>(uri));
    listeners.back()->poll();
  }
  publisher->publish(message_of("pose"));
  for (int i = 0; i < 17; ++i) {
    listeners[i]->poll();
    EXPECT_EQ(listeners[i]->last(Kind::pose), "pose");
    EXPECT_EQ(listeners[i]->count(Kind::note), i == 16 ? 1u : 0u)
        << "the 17th gets a note that it cannot reply";
    listeners[i]->link->send(listeners[i]->peer(), bytes_of("reply" + std::to_string(i)));
  }
  std::vector<std::byte> message;
  size_t replies = 0;
  while (publisher->poll(message)) ++replies;
  EXPECT_EQ(replies, 16u);
  EXPECT_EQ(publisher->stats().peers, 16u);
}

TEST(Shm, UnreadBackChannelIsBounded) {
  const std::string uri = unique_shm_uri("backfull");
  auto publisher = open_publisher_or_fail(uri);
  Listener listener(uri);
  listener.poll();
  const std::string reply(1000, 'r');
  for (int i = 0; i < 100; ++i) listener.link->send(listener.peer(), bytes_of(reply));
  EXPECT_GT(listener.link->stats().rejected, 0u);
  std::vector<std::byte> message;
  uint64_t got = 0;
  for (; publisher->poll(message); ++got) EXPECT_EQ(text_of(message), reply);
  EXPECT_EQ(got + listener.link->stats().rejected, 100u);
  listener.link->send(listener.peer(), bytes_of("room again"));
  EXPECT_TRUE(poll_until_reply(*publisher, "room again"));
}

TEST(Shm, ALivePublishersNameIsRefused) {
  const std::string uri = unique_shm_uri("busy");
  auto publisher = open_publisher_or_fail(uri);
  const auto second = open_publisher(uri);
  ASSERT_FALSE(second.ok());
  EXPECT_NE(second.error().message.find(uri + " is being published by process " + std::to_string(::getpid())),
            std::string::npos)
      << second.error().message;
  publisher.reset();
  EXPECT_TRUE(open_publisher(uri).ok());
}

TEST(Shm, OversizedFrameIsDropped) {
  const std::string uri = unique_shm_uri("huge");
  auto publisher = open_publisher_or_fail(uri);
  const std::vector<std::byte> huge(publisher->max_pose_message_bytes() + 1);
  EXPECT_FALSE(publisher->publish({huge, {}}));
  EXPECT_EQ(publisher->stats().poses_dropped, 1u);
  EXPECT_TRUE(publisher->publish(message_of("still fine")));
}

// A file size limit replaces a full /dev/shm: the same call fails.
struct FileSizeLimit {
  explicit FileSizeLimit(rlim_t bytes) {
    ::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before);
    rlimit limit = before;
    limit.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() { ::setrlimit(RLIMIT_FSIZE, &before); }
  rlimit before{};
};

TEST(Shm, FullMemoryIsAnError) {
  const FileSizeLimit limit(1 << 20);
  const auto publisher = open_publisher(unique_shm_uri("full"));
  ASSERT_FALSE(publisher.ok());
  EXPECT_NE(publisher.error().message.find("no room"), std::string::npos) << publisher.error().message;
}

TEST(Shm, FailedGrowthDropsFrame) {
  const std::string uri = unique_shm_uri("fullgrow");
  auto publisher = open_publisher_or_fail(uri);
  Listener listener(uri);
  listener.poll();
  {
    const FileSizeLimit limit(4 << 20);
    EXPECT_FALSE(publisher->publish(message_of(std::string(2'000'000, 'x'))));
    EXPECT_EQ(publisher->stats().poses_dropped, 1u);
    EXPECT_FALSE(publisher->set_description(bytes_of(std::string(3'000'000, 'd'))).ok());
  }
  EXPECT_TRUE(publisher->publish(message_of("small")));
  listener.poll();
  EXPECT_EQ(listener.last(Kind::pose), "small");
}

}  // namespace
}  // namespace fire3dv::transport::test
