// Test of the C++ wrapper: ownership, exceptions, and complete transfer of arguments.
#include "fire3dv/client.hpp"

#include <utility>

#include "tests/unit/adapters/generic/client_fixture.h"

namespace fire3dv::test {
namespace {

using namespace std::chrono_literals;

template <typename Call>
void expect_thrown(int code, const std::string& text, Call call) {
  try {
    call();
    ADD_FAILURE() << "nothing was thrown, expected: " << text;
  } catch (const ClientError& error) {
    EXPECT_EQ(error.code(), code);
    EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
  }
}

TEST(ClientHpp, ThrowsWithTheSentence) {
  expect_thrown(FIRE3DV_ERROR_ARGUMENT, "nonsense", [] { Stream stream("nonsense"); });
  Stream stream(unique_shm_uri());
  expect_thrown(FIRE3DV_ERROR_STATE, "fire3dv_describe", [&] { stream.publish(0ns, std::vector<Pose>(1)); });
  expect_thrown(FIRE3DV_ERROR_ARGUMENT, "node_names[1]", [&] { stream.describe({"a", "a"}); });
  expect_thrown(FIRE3DV_ERROR_ARGUMENT, "holds a NUL", [&] { stream.describe({std::string("a\0b", 3)}); });
  Description description;
  description.world_from_stream = {1, 2, 3};
  expect_thrown(FIRE3DV_ERROR_ARGUMENT, "world_from_stream", [&] { stream.describe(description); });
  stream.describe({"a"});
  expect_thrown(FIRE3DV_ERROR_ARGUMENT, "pose_count is 2",
                [&] { stream.publish(0ns, std::vector<Pose>(2)); });
  expect_thrown(FIRE3DV_ERROR_ARGUMENT, "sequence is 1", [&] { stream.wait_ack(1, 0ms); });
}

TEST(ClientHpp, MovesAndCarriesEverything) {
  Renderer renderer(listener_uri("shm"));
  ASSERT_NE(renderer.link, nullptr);
  Stream first(renderer.link->uri(), "wrapper");
  Stream stream = std::move(first);
  Stream other(unique_shm_uri());
  std::swap(stream, other);
  other.describe(Description{});
  std::swap(stream, other);

  Description description;
  description.node_names = {"a", "b"};
  description.world_from_stream = {1, 0, 0, 5, 0, 1, 0, 6, 0, 0, 1, 7};
  description.body_from_node = {Pose{2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0}};
  description.nominal_rate_hz = 240;
  description.scene_uri = "file:scene.glb";
  stream.describe(description);
  const std::vector<Pose> poses = {Pose{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}, Pose{0}};
  ASSERT_TRUE(repeat_until([&] {
    stream.publish(7s, poses);
    renderer.poll();
    return !renderer.descriptions.empty() && renderer.has_whole_frame();
  }));
  const wire::StreamDescription& arrived = renderer.descriptions.back();
  EXPECT_EQ(arrived.adapter_name, "wrapper");
  EXPECT_EQ(arrived.node_names, description.node_names);
  EXPECT_EQ(arrived.world_from_stream.m[11], 7);
  ASSERT_EQ(arrived.body_from_node.size(), 1u);
  EXPECT_EQ(arrived.body_from_node[0].m[0], 2);
  EXPECT_EQ(arrived.nominal_rate_hz, 240);
  EXPECT_EQ(arrived.scene_uri, "file:scene.glb");
  EXPECT_EQ(renderer.poses[0].m, poses[0]);

  EXPECT_FALSE(stream.wait_ack(1, 1ms));
  const uint64_t shown = stream.poll().sequence;
  renderer.send(wire::Ack{arrived.epoch, shown});
  EXPECT_TRUE(stream.wait_ack(shown, 60s));

  fire3dv_image_request request{};
  expect_thrown(FIRE3DV_ERROR_ARGUMENT, "width is 0", [&] { stream.request_image(request); });
  request.width = request.height = 4;
  request.fx = request.fy = 4;
  const uint64_t id = stream.request_image(request);
  EXPECT_EQ(stream.wait_image(id, 0ms), nullptr);
  stream.cancel_image(id);
  expect_thrown(FIRE3DV_ERROR_STATE, "no image", [&] { stream.wait_image(0, 0ms); });
}

}  // namespace
}  // namespace fire3dv::test
