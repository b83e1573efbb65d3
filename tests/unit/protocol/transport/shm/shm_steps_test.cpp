// Exhaustive crash test of the shared-memory publisher: stopped at every instruction of a publish, and killed
// at every system call of its life.
#include <glob.h>

#include <algorithm>

#include "tests/unit/protocol/transport/child.h"
#include "tests/unit/protocol/transport/link_fixture.h"

namespace fire3dv::transport::test {
namespace {

using Stop = SteppedChild::Stop;

constexpr uint32_t kSlots = 4;

// All bytes of frame n are n; its length differs from the next frame's.
std::string frame_text(uint8_t number, size_t bytes) {
  return std::string(bytes + 8 * (number % 2), static_cast<char>(number));
}

// Returns the frame numbers that a new reader gets; 0 for a torn frame.
std::vector<int> joiner_sees(const std::string& uri, size_t bytes) {
  ListenerOptions options;
  options.delivery = Delivery::all;
  Listener listener(uri, options);
  listener.poll();
  std::vector<int> numbers;
  for (const Event& event : listener.events) {
    if (event.kind != Kind::pose) continue;
    const uint8_t number = event.text.empty() ? 0 : static_cast<uint8_t>(event.text[0]);
    numbers.push_back(event.text == frame_text(number, bytes) ? number : 0);
  }
  return numbers;
}

// Stops the writer after each instruction, as if killed there. After each `every`th one a new reader
// attaches.
void expect_whole_at_instructions(size_t bytes, int every) {
  constexpr uint8_t kBefore = 5, kWatched = 2;  // the ring has wrapped before the watch begins
  const std::string uri = unique_shm_uri("instruction");
  SteppedChild writer([&] {
    PublisherOptions options;
    options.ring_slots = kSlots;
    auto publisher = open_publisher(uri, options);
    if (!publisher) ::_exit(1);
    std::vector<std::string> frames;
    for (uint8_t i = 1; i <= kBefore + kWatched; ++i) frames.push_back(frame_text(i, bytes));
    const auto publish = [&](uint8_t number) {
      const std::span<const std::byte> all = bytes_of(frames[number - 1]);
      (*publisher)->publish({all.first(80), all.subspan(80)});
    };
    for (uint8_t i = 1; i <= kBefore; ++i) publish(i);
    SteppedChild::mark();
    for (uint8_t i = 1; i <= kWatched; ++i) publish(kBefore + i);
    SteppedChild::mark();
    ::pause();
  });
  ASSERT_TRUE(writer.stopped());
  Listener follower(uri);  // attached from the start
  int newest = 0, instructions = 0;
  do {
    follower.poll();
    if (++instructions % every != 0) continue;
    const std::vector<int> seen = joiner_sees(uri, bytes);
    ASSERT_EQ(seen.size(), kSlots - 1) << "at instruction " << instructions;
    const int last = seen.back();
    ASSERT_GE(last, std::max(newest, int{kBefore}));
    newest = last;
    for (size_t i = 0; i < seen.size(); ++i)
      ASSERT_EQ(seen[i], last - static_cast<int>(seen.size() - 1 - i)) << "at instruction " << instructions;
  } while (writer.instruction() == Stop::step);
  follower.poll();
  EXPECT_EQ(joiner_sees(uri, bytes).back(), kBefore + kWatched);
  EXPECT_GT(instructions, 50);
  std::vector<int> followed;
  for (const Event& event : follower.events)
    if (event.kind == Kind::pose) followed.push_back(static_cast<uint8_t>(event.text[0]));
  EXPECT_EQ(followed, (std::vector<int>{kBefore, kBefore + 1, kBefore + 2}));
  writer.kill();
  open_publisher_or_fail(uri);  // its destructor removes the dead publisher's file
}

TEST(ShmSteps, EachInstructionLeavesWholeFrames) {
  expect_whole_at_instructions(600, 1);
}

TEST(ShmSteps, LongCopiesLeaveWholeFrames) {
  // From 2 KiB on glibc copies with `rep movsb` on fast CPUs: each byte is a step.
  expect_whole_at_instructions(5000, 7);
}

// --- system calls

// Life cycle: opens, describes, publishes, outgrows its segment twice, and closes.
void live(const std::string& uri) {
  SteppedChild::mark();
  {
    auto publisher = open_publisher(uri);
    if (!publisher) ::_exit(1);
    if (!(*publisher)->set_description(bytes_of("mortal"))) ::_exit(1);
    (*publisher)->publish(message_of("mortal"));
    (*publisher)->publish(message_of(std::string(100'000, 'm')));
    if (!(*publisher)->set_description(bytes_of(std::string(100'000, 'd')))) ::_exit(1);
    (*publisher)->publish(message_of("mortal"));
  }
  ::_exit(0);
}

// A publisher killed between link and rename leaves a hidden file (SPEC-transport 1.1).
void remove_hidden_files(const std::string& uri) {
  glob_t found{};
  const std::string pattern = "/dev/shm/.fire3dv." + uri.substr(6) + ".*";
  if (::glob(pattern.c_str(), 0, nullptr, &found) == 0)
    for (size_t i = 0; i < found.gl_pathc; ++i) ::unlink(found.gl_pathv[i]);
  ::globfree(&found);
}

// dead_before: the name belongs to a killed publisher and must be taken over. stops: 1 for entry and exit of
// each call, 2 for one of them, between which no change is visible.
void expect_followed_after_each_system_call(const char* what, bool dead_before, int stops) {
  const std::string uri = unique_shm_uri(what);
  Listener listener(uri);
  bool lived_through = false;
  int killed_at = 0;
  while (!lived_through) {
    killed_at += stops;
    if (dead_before) {
      Child dead([&] {
        auto publisher = open_publisher(uri);
        if (!publisher || !(*publisher)->set_description(bytes_of("dead"))) ::_exit(1);
        while (true) ::pause();
      });
      ASSERT_TRUE(listener.poll_until([&] { return listener.saw(Kind::control, "dead"); }));
      dead.kill();
      listener.events.clear();
    }
    {
      SteppedChild mortal([&] { live(uri); });
      Stop stop = mortal.stopped() ? Stop::step : Stop::ended;
      for (int i = 0; i < killed_at && stop == Stop::step; ++i) {
        stop = mortal.system_call();
        if (i % 8 == 0) listener.poll();
      }
      lived_through = stop == Stop::ended;
      EXPECT_TRUE(!lived_through || mortal.ended_well());
    }
    const std::string name = "heir " + std::to_string(killed_at);
    {
      auto heir = open_publisher(uri);
      ASSERT_TRUE(heir.ok()) << "after a kill at stop " << killed_at << ": " << heir.error().message;
      ASSERT_TRUE((*heir)->set_description(bytes_of(name)));
      (*heir)->publish(message_of(name));
      ASSERT_TRUE(listener.poll_until([&] { return listener.saw(Kind::pose, name); }))
          << "not followed after a kill at stop " << killed_at;
    }
    for (const Event& event : listener.events)
      EXPECT_TRUE(event.kind != Kind::pose || event.text == "mortal" || event.text == name ||
                  event.text == std::string(100'000, 'm'))
          << "after a kill at stop " << killed_at;
    listener.events.clear();
    remove_hidden_files(uri);
    ASSERT_FALSE(testing::Test::HasFailure());
  }
  EXPECT_GT(killed_at, 60) << "a life has more system calls";
  EXPECT_EQ(listener.link->stats().rejected, 0u);
}

TEST(ShmSteps, SuccessorIsFollowedAfterKill) {
  expect_followed_after_each_system_call("life", false, 1);
}

TEST(ShmSteps, TakenNamesHeirIsFollowed) {
  expect_followed_after_each_system_call("inherit", true, 2);
}

}  // namespace
}  // namespace fire3dv::transport::test
