// Test of the C interface: argument checks, and a complete session with a renderer over each link.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <memory>

#include "tests/unit/adapters/generic/client_fixture.h"

namespace fire3dv::test {
namespace {

struct Close {
  void operator()(fire3dv_stream* stream) const { fire3dv_close(&stream); }
};
using Stream = std::unique_ptr<fire3dv_stream, Close>;

Stream open(const std::string& uri) {
  Stream stream(fire3dv_open(uri.c_str(), nullptr));
  EXPECT_NE(stream, nullptr) << fire3dv_last_error();
  return stream;
}

std::vector<float> identity_poses(size_t count) {
  std::vector<float> poses(count * 12, 0.0f);
  for (size_t i = 0; i < count; ++i) poses[i * 12] = poses[i * 12 + 5] = poses[i * 12 + 10] = 1;
  return poses;
}

// Each error names its cause in one line.
#define EXPECT_REFUSED(call, code, text)                                                                \
  do {                                                                                                  \
    EXPECT_EQ(call, code);                                                                              \
    EXPECT_NE(std::string(fire3dv_last_error()).find(text), std::string::npos) << fire3dv_last_error(); \
    EXPECT_EQ(std::string(fire3dv_last_error()).find('\n'), std::string::npos);                         \
  } while (false)

TEST(Client, OpenRefusesWhatIsNoLink) {
  for (const char* uri :
       {"", "demo", "shm://", "shm://../etc/passwd", "shm://a/b", "tcp://127.0.0.1", "tcp://127.0.0.1:x",
        "tcp://127.0.0.1:70000", "udp://", "http://127.0.0.1:80", "file:///etc/passwd"}) {
    EXPECT_EQ(fire3dv_open(uri, nullptr), nullptr) << uri;
    EXPECT_STRNE(fire3dv_last_error(), "") << uri;
  }
  EXPECT_EQ(fire3dv_open(nullptr, nullptr), nullptr);
  EXPECT_STREQ(fire3dv_last_error(), "uri is NULL");
  fire3dv_options options{};
  EXPECT_EQ(fire3dv_open("shm://x", &options), nullptr);
  EXPECT_NE(std::string(fire3dv_last_error()).find("options.struct_size is 0"), std::string::npos);
  options.struct_size = sizeof options;
  options.adapter_name = "line\nline";
  EXPECT_EQ(fire3dv_open("shm://x", &options), nullptr);
  EXPECT_NE(std::string(fire3dv_last_error()).find("adapter_name"), std::string::npos);
}

TEST(Client, LongerStructIsAccepted) {
  struct Later {
    fire3dv_options known;
    uint64_t unknown;
  } later{};
  later.known.struct_size = sizeof later;
  const std::string uri = unique_shm_uri();
  fire3dv_stream* stream = fire3dv_open(uri.c_str(), &later.known);
  EXPECT_NE(stream, nullptr) << fire3dv_last_error();
  fire3dv_close(&stream);
  later.unknown = 1;
  EXPECT_EQ(fire3dv_open(uri.c_str(), &later.known), nullptr);
}

TEST(Client, TakesStructOfFirstVersion) {
  fire3dv_options options{};
  options.struct_size = offsetof(fire3dv_options, key_file);
  options.key_file = "/nowhere";  // bytes beyond the caller's struct are not read
  fire3dv_stream* stream = fire3dv_open("udp://127.0.0.1:9", &options);
  EXPECT_NE(stream, nullptr) << fire3dv_last_error();
  fire3dv_status status{};
  status.struct_size = offsetof(fire3dv_status, conflicting_names);
  status.conflicting_names = 77;  // bytes beyond the caller's struct are not written
  EXPECT_EQ(fire3dv_poll(stream, &status), FIRE3DV_OK) << fire3dv_last_error();
  EXPECT_EQ(status.welcome, -1);
  EXPECT_EQ(status.conflicting_names, 77u);
  fire3dv_close(&stream);
}

TEST(Client, KeyFileIsReadOnOpen) {
  fire3dv_options options{};
  options.struct_size = sizeof options;
  options.key_file = "/nowhere";
  EXPECT_EQ(fire3dv_open("udp://127.0.0.1:9", &options), nullptr);
  EXPECT_NE(std::string(fire3dv_last_error()).find("key file '/nowhere' cannot be read"), std::string::npos)
      << fire3dv_last_error();
}

TEST(Client, NullStreamIsAnError) {
  fire3dv_status status{};
  status.struct_size = sizeof status;
  fire3dv_description description{};
  EXPECT_REFUSED(fire3dv_describe(nullptr, &description), FIRE3DV_ERROR_ARGUMENT, "stream is NULL");
  EXPECT_REFUSED(fire3dv_publish(nullptr, 0, nullptr, 0, 0), FIRE3DV_ERROR_ARGUMENT, "stream is NULL");
  EXPECT_REFUSED(fire3dv_poll(nullptr, &status), FIRE3DV_ERROR_ARGUMENT, "stream is NULL");
  EXPECT_REFUSED(fire3dv_wait_ack(nullptr, 1, 0), FIRE3DV_ERROR_ARGUMENT, "stream is NULL");
  fire3dv_close(nullptr);
  fire3dv_stream* none = nullptr;
  fire3dv_close(&none);
}

TEST(Client, DescribeRefusesInvalidNames) {
  const Stream stream = open(unique_shm_uri());
  const char* names[] = {"a", "b"};
  const fire3dv_description good = [&] {
    fire3dv_description d{};
    d.struct_size = sizeof d;
    d.node_names = names;
    d.node_count = 2;
    return d;
  }();
  const auto refused = [&](const char* text, auto change) {
    fire3dv_description d = good;
    change(d);
    EXPECT_REFUSED(fire3dv_describe(stream.get(), &d), FIRE3DV_ERROR_ARGUMENT, text);
  };
  EXPECT_REFUSED(fire3dv_describe(stream.get(), nullptr), FIRE3DV_ERROR_ARGUMENT, "description is NULL");
  refused("struct_size", [](auto& d) { d.struct_size = 8; });
  refused("node_names is NULL", [](auto& d) { d.node_names = nullptr; });
  refused("node_count", [](auto& d) { d.node_count = SIZE_MAX; });
  const char* bad_names[][2] = {{"a", nullptr}, {"a", ""}, {"a", "a"}, {"a", "\x1b[2J"}, {"a", "\xff"}};
  for (auto& pair : bad_names) refused("node_names[1]", [&](auto& d) { d.node_names = pair; });
  const std::string long_name(5000, 'x');
  const char* too_long[] = {"a", long_name.c_str()};
  refused("node_names[1]", [&](auto& d) { d.node_names = too_long; });
  double world[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, NAN};
  refused("world_from_stream[11]", [&](auto& d) { d.world_from_stream = world; });
  const std::vector<float> matrices = identity_poses(2);
  refused("body_from_node is NULL", [&](auto& d) { d.body_from_node_count = 1; });
  refused("body_from_node_count is 3", [&](auto& d) {
    d.body_from_node = matrices.data();
    d.body_from_node_count = 3;
  });
  refused("nominal_rate_hz", [](auto& d) { d.nominal_rate_hz = -1; });
  refused("scene_uri", [&](auto& d) { d.scene_uri = long_name.c_str(); });

  EXPECT_REFUSED(fire3dv_publish(stream.get(), 0, matrices.data(), 2, 0), FIRE3DV_ERROR_STATE,
                 "fire3dv_describe");
  EXPECT_EQ(fire3dv_describe(stream.get(), &good), FIRE3DV_OK) << fire3dv_last_error();
}

TEST(Client, PublishRefusesInvalidFrames) {
  const Stream stream = open(unique_shm_uri());
  ASSERT_EQ(describe(stream.get(), {"a", "b"}), FIRE3DV_OK);
  std::vector<float> poses = identity_poses(2);
  EXPECT_REFUSED(fire3dv_publish(stream.get(), 0, poses.data(), 1, 0), FIRE3DV_ERROR_ARGUMENT,
                 "pose_count is 1");
  EXPECT_REFUSED(fire3dv_publish(stream.get(), 0, nullptr, 2, 0), FIRE3DV_ERROR_ARGUMENT,
                 "stream_from_body is NULL");
  EXPECT_REFUSED(fire3dv_publish(stream.get(), 0, poses.data(), 2, 2), FIRE3DV_ERROR_ARGUMENT, "flags is 2");
  poses[17] = NAN;
  EXPECT_REFUSED(fire3dv_publish(stream.get(), 0, poses.data(), 2, 0), FIRE3DV_ERROR_ARGUMENT,
                 "stream_from_body[1] row 1 column 1 is NaN");
  poses[17] = INFINITY;
  EXPECT_REFUSED(fire3dv_publish(stream.get(), 0, poses.data(), 2, 0), FIRE3DV_ERROR_ARGUMENT, "is infinity");
  poses[17] = 1;
  EXPECT_EQ(fire3dv_publish(stream.get(), 0, poses.data(), 2, FIRE3DV_FRAME_DISCONTINUITY), FIRE3DV_OK);
  EXPECT_EQ(poll(stream.get()).sequence, 1u) << "a refused frame took a sequence number";
  fire3dv_status status{};
  EXPECT_REFUSED(fire3dv_poll(stream.get(), &status), FIRE3DV_ERROR_ARGUMENT, "status.struct_size");
  EXPECT_EQ(fire3dv_poll(stream.get(), nullptr), FIRE3DV_OK);
  EXPECT_REFUSED(fire3dv_wait_ack(stream.get(), 2, 0), FIRE3DV_ERROR_ARGUMENT, "sequence is 2");
  EXPECT_REFUSED(fire3dv_wait_ack(stream.get(), 1, 5), FIRE3DV_ERROR_TIMEOUT,
                 "no renderer has shown frame 1");
}

TEST(Client, NewDescriptionIsNewEpoch) {
  const Stream stream = open(unique_shm_uri());
  const std::vector<float> poses = identity_poses(2);
  ASSERT_EQ(describe(stream.get(), {"a", "b"}), FIRE3DV_OK);
  ASSERT_EQ(fire3dv_publish(stream.get(), 0, poses.data(), 2, 0), FIRE3DV_OK);
  const fire3dv_status first = poll(stream.get());
  EXPECT_EQ(describe(stream.get(), {"a", "a"}), FIRE3DV_ERROR_ARGUMENT);
  EXPECT_EQ(poll(stream.get()).epoch, first.epoch) << "a refused description replaced the earlier one";
  ASSERT_EQ(describe(stream.get(), {"a"}), FIRE3DV_OK);
  const fire3dv_status second = poll(stream.get());
  EXPECT_NE(second.epoch, first.epoch);
  EXPECT_EQ(second.sequence, 0u);
  EXPECT_EQ(fire3dv_publish(stream.get(), 0, poses.data(), 1, 0), FIRE3DV_OK);
  EXPECT_EQ(poll(stream.get()).frames_published, 2u);
}

class ClientOver : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Links, ClientOver, testing::Values("shm", "tcp", "udp"),
                         [](const auto& link) { return std::string(link.param); });

TEST_P(ClientOver, PublishingNeedsNoRenderer) {
  const Stream stream = open(silent_uri(GetParam()));
  constexpr size_t kNodes = 100;
  std::vector<std::string> names;
  std::vector<const char*> pointers;
  for (size_t i = 0; i < kNodes; ++i) names.push_back("node " + std::to_string(i));
  for (const std::string& name : names) pointers.push_back(name.c_str());
  ASSERT_EQ(describe(stream.get(), pointers), FIRE3DV_OK) << fire3dv_last_error();
  const std::vector<float> poses = identity_poses(kNodes);
  for (int64_t i = 0; i < 10'000; ++i) {
    ASSERT_EQ(fire3dv_publish(stream.get(), i, poses.data(), kNodes, 0), FIRE3DV_OK) << fire3dv_last_error();
  }
  const fire3dv_status status = poll(stream.get());
  EXPECT_EQ(status.sequence, 10'000u);
  EXPECT_EQ(status.frames_published, 10'000u);
  EXPECT_EQ(status.renderers, 0u);
  EXPECT_EQ(status.welcome, -1);
}

TEST_P(ClientOver, HoldsAWholeConversation) {
  Renderer renderer(listener_uri(GetParam()));
  ASSERT_NE(renderer.link, nullptr);
  Stream stream = open(renderer.link->uri());
  // More poses than fit in a datagram, each different.
  constexpr size_t kNodes = 100;
  std::vector<std::string> names;
  std::vector<const char*> pointers;
  for (size_t i = 0; i < kNodes; ++i) names.push_back("node " + std::to_string(i));
  for (const std::string& name : names) pointers.push_back(name.c_str());
  ASSERT_EQ(describe(stream.get(), pointers), FIRE3DV_OK) << fire3dv_last_error();
  std::vector<float> poses(kNodes * 12);
  for (size_t i = 0; i < poses.size(); ++i) poses[i] = static_cast<float>(i) * 0.25f;

  const auto publish_and_poll = [&] {
    EXPECT_EQ(fire3dv_publish(stream.get(), 1000, poses.data(), kNodes, 0), FIRE3DV_OK);
    renderer.poll();
  };
  ASSERT_TRUE(repeat_until([&] {
    publish_and_poll();
    return !renderer.descriptions.empty() && renderer.has_whole_frame();
  }));
  const wire::StreamDescription& description = renderer.descriptions.front();
  EXPECT_EQ(description.adapter_name, "generic");
  EXPECT_EQ(description.node_names, names);
  EXPECT_EQ(description.epoch, poll(stream.get()).epoch);
  EXPECT_NE(description.clock.monotonic_at_open_ns, 0u);
  EXPECT_NE(description.clock.realtime_at_open_ns, 0);
  EXPECT_EQ(std::memcmp(renderer.poses.data(), poses.data(), poses.size() * sizeof(float)), 0);

  // An answer to another epoch is ignored.
  renderer.send(
      wire::Welcome{wire::WelcomeStatus::refused, 1, 0, description.epoch ^ 1, "", "stale", {}, {}});
  renderer.send(wire::Welcome{wire::WelcomeStatus::accepted,
                              1,
                              0,
                              description.epoch,
                              "test",
                              "hello",
                              {"node 3", "node 4"},
                              {"node 5"}});
  ASSERT_TRUE(repeat_until([&] {
    publish_and_poll();
    return poll(stream.get()).welcome == 0;
  }));
  const fire3dv_status status = poll(stream.get());
  EXPECT_EQ(status.renderers, 1u);
  EXPECT_EQ(status.unmatched_names, 2u);
  EXPECT_STREQ(status.welcome_message,
               "hello; no scene node is called node 3, node 4; another stream drives node 5");
  EXPECT_EQ(status.conflicting_names, 1u);
  EXPECT_EQ(status.contested_names, 0u);

  // A node of this stream that another stream requests.
  renderer.send(wire::Status{description.epoch ^ 1, {"node 1", "node 2"}, "of another epoch"});
  renderer.send(wire::Status{description.epoch, {"node 6"}, "another stream asks for it"});
  ASSERT_TRUE(repeat_until([&] {
    publish_and_poll();
    return poll(stream.get()).contested_names == 1;
  }));
  EXPECT_STREQ(
      poll(stream.get()).welcome_message,
      "hello; no scene node is called node 3, node 4; another stream drives node 5; this stream drives, and "
      "another stream requests node 6");
  renderer.send(wire::Status{description.epoch, {}, ""});
  ASSERT_TRUE(repeat_until([&] {
    publish_and_poll();
    return poll(stream.get()).contested_names == 0;
  }));
  EXPECT_STREQ(poll(stream.get()).welcome_message, status.welcome_message);
  renderer.send(wire::Status{description.epoch, {}, "this stream moves 1 node without its scale"});
  const std::string advised =
      std::string(status.welcome_message) + "; this stream moves 1 node without its scale";
  EXPECT_TRUE(repeat_until([&] {
    publish_and_poll();
    return poll(stream.get()).welcome_message == advised;
  }));
  // Two statuses that come together are shown one after the other.
  renderer.send(wire::Status{description.epoch, {}, "this stream has an edit without effect: a"});
  renderer.send(wire::Status{description.epoch, {}, "this stream has an edit without effect: b"});
  std::string all;
  EXPECT_TRUE(repeat_until([&] {
    publish_and_poll();
    all += poll(stream.get()).welcome_message;
    return all.ends_with("without effect: b");
  }));
  EXPECT_NE(all.find("without effect: a"), std::string::npos);
  // Long advice has the room that the names leave, and half of it at least.
  renderer.send(wire::Status{description.epoch, {}, "this stream has " + std::string(600, 'x')});
  EXPECT_TRUE(repeat_until([&] {
    publish_and_poll();
    const std::string text = poll(stream.get()).welcome_message;
    return text.starts_with(status.welcome_message) && text.find("; this stream has xxx") != text.npos &&
           text.size() > 500 && text.size() < sizeof status.welcome_message;
  }));

  // An acknowledgement of a frame that was never published is ignored.
  const uint64_t shown = renderer.sequence;
  renderer.send(wire::Ack{description.epoch, UINT64_MAX});
  ASSERT_TRUE(repeat_until([&] {
    renderer.send(wire::Ack{description.epoch, shown});
    renderer.poll();
    return fire3dv_wait_ack(stream.get(), shown, 20) == FIRE3DV_OK;
  }));
  EXPECT_EQ(poll(stream.get()).acked_sequence, shown);

  ASSERT_TRUE(repeat_until([&] {
    renderer.send(wire::Ping{77, 123});
    EXPECT_EQ(fire3dv_poll(stream.get(), nullptr), FIRE3DV_OK);
    publish_and_poll();
    return !renderer.pongs.empty();
  }));
  EXPECT_EQ(renderer.pongs.front().id, 77u);
  EXPECT_EQ(renderer.pongs.front().ping_sender_time_ns, 123u);
  EXPECT_NE(renderer.pongs.front().answer_time_ns, 0u);

  stream.reset();
  EXPECT_TRUE(repeat_until([&] {
    renderer.poll();
    return renderer.ended;
  }));
}

TEST_P(ClientOver, CarriesFrameOfNoNodes) {
  Renderer renderer(listener_uri(GetParam()));
  ASSERT_NE(renderer.link, nullptr);
  const Stream stream = open(renderer.link->uri());
  ASSERT_EQ(describe(stream.get(), {}), FIRE3DV_OK) << fire3dv_last_error();
  EXPECT_TRUE(repeat_until([&] {
    EXPECT_EQ(fire3dv_publish(stream.get(), 0, nullptr, 0, 0), FIRE3DV_OK) << fire3dv_last_error();
    renderer.poll();
    return !renderer.descriptions.empty() && renderer.sequence > 0;
  }));
}

// A child that inherits a stream, calls its functions and closes it leaves the parent's stream alone.
TEST_P(ClientOver, ForkedChildLeavesStreamAlone) {
  Renderer renderer(listener_uri(GetParam()));
  ASSERT_NE(renderer.link, nullptr);
  Stream stream = open(renderer.link->uri());
  ASSERT_EQ(describe(stream.get(), {"a"}), FIRE3DV_OK);
  const std::vector<float> poses = identity_poses(1);
  int64_t time_ns = 0;
  const auto shows = [&](uint64_t sequence) {
    return repeat_until([&] {
      EXPECT_EQ(fire3dv_publish(stream.get(), ++time_ns, poses.data(), 1, 0), FIRE3DV_OK);
      renderer.poll();
      return renderer.sequence > sequence || renderer.ended;
    });
  };
  ASSERT_TRUE(shows(0));
  const pid_t child = ::fork();
  if (child == 0) {
    const bool is_refused = fire3dv_publish(stream.get(), 0, poses.data(), 1, 0) == FIRE3DV_ERROR_STATE &&
                            std::strstr(fire3dv_last_error(), "before fork()") != nullptr;
    stream.reset();
    ::_exit(is_refused ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0) << "the child's calls must be refused";
  EXPECT_TRUE(shows(renderer.sequence));
  EXPECT_FALSE(renderer.ended) << "the child's goodbye came";
  EXPECT_EQ(renderer.descriptions.size(), 1u) << "the connection was lost";
}

TEST_P(ClientOver, TellsOfAnotherMajorVersion) {
  Renderer renderer(listener_uri(GetParam()));
  ASSERT_NE(renderer.link, nullptr);
  const Stream stream = open(renderer.link->uri());
  ASSERT_EQ(describe(stream.get(), {"a"}), FIRE3DV_OK);
  const std::vector<float> poses = identity_poses(1);
  ASSERT_TRUE(repeat_until([&] {
    EXPECT_EQ(fire3dv_publish(stream.get(), 0, poses.data(), 1, 0), FIRE3DV_OK);
    renderer.poll();
    if (renderer.descriptions.empty()) return false;
    const uint64_t epoch = renderer.descriptions.front().epoch;
    renderer.send(wire::Welcome{wire::WelcomeStatus::version_mismatch, 2, 1, epoch, "", "", {}, {}});
    return poll(stream.get()).welcome == 1;
  }));
  EXPECT_STREQ(
      poll(stream.get()).welcome_message,
      "the renderer speaks protocol 2.1, this library 1.10: use versions with the same major number");
}

}  // namespace
}  // namespace fire3dv::test
