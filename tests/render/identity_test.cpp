// End-to-end test of transport independence: the same 200 pose frames, in lockstep, in process and over
// shared memory, TCP and UDP, give byte-identical images. In process no codec is involved: frames go straight
// to the pose state.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <functional>
#include <set>

#include "fire3dv/client.h"
#include "protocol/transport/open.h"
#include "renderer/streams/stream_receiver.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

constexpr uint32_t kFrames = 200;
constexpr uint32_t kBodies = 40;  // with 48 bytes a pose: two datagrams a frame over UDP
constexpr VkExtent2D kExtent{96, 72};

std::string body_name(uint32_t body) {
  return "body_" + std::to_string(body);
}

scene::Scene make_scene() {
  SceneBuilder builder;
  const uint32_t ground = builder.quad(builder.material(matte({0.5f, 0.5f, 0.5f})), 6);
  builder.mesh_node("ground", ground, glm::mat4(1));
  for (uint32_t body = 0; body < kBodies; ++body) {
    scene::Material material = matte({0.2f + 0.6f * static_cast<float>(body % 3 == 0), 0.3f, 0.7f});
    material.roughness = 0.4f;
    builder.mesh_node(body_name(body), builder.box(builder.material(material), {0.25f, 0.25f, 0.25f}),
                      at({0, 10, 0}));
  }
  builder.light_node(sun({1, 1, 1}, 2.5f), shining_towards({-0.4f, -1, -0.3f}));
  builder.camera_node("camera", {0, 5, 7}, {0, 0.5f, 0}, 0.9f);
  return builder.build();
}

// Every body moves in every frame, on its own path and about its own axis.
std::vector<wire::Affine3x4> make_poses(uint32_t frame) {
  std::vector<wire::Affine3x4> poses(kBodies);
  for (uint32_t body = 0; body < kBodies; ++body) {
    const float phase = 0.37f * static_cast<float>(body);
    const float t = 0.05f * static_cast<float>(frame + 1) + phase;
    const float c = std::cos(3 * t), s = std::sin(3 * t);
    const float x = static_cast<float>(body % 8) - 3.5f + 0.3f * std::sin(t);
    const float y = 0.5f + 0.2f * std::cos(2 * t);
    const float z = static_cast<float>(body / 8) - 2.0f + 0.3f * std::cos(t);
    poses[body].m = {c, 0, s, x, 0, 1, 0, y, -s, 0, c, z};
  }
  return poses;
}

// Flips one bit of one pose, to prove that the comparison detects it. Frame and body are arbitrary.
using Tamper = std::function<void(uint32_t frame, std::vector<wire::Affine3x4>&)>;
void flip_one_bit(uint32_t frame, std::vector<wire::Affine3x4>& poses) {
  if (frame != 123) return;
  uint32_t bits;
  std::memcpy(&bits, &poses[17].m[3], sizeof bits);
  bits ^= 1u << 21;  // of the mantissa: moves the body by at most a quarter of its position's power of two
  std::memcpy(&poses[17].m[3], &bits, sizeof bits);
}

class Identity : public ValidationIsSilent {
 protected:
  static const scene::Scene& scene() {
    static const scene::Scene the_scene = make_scene();
    return the_scene;
  }

  static std::vector<sinks::FrameImage> play_in_process(const Tamper& tamper = {}) {
    state::PoseState poses(scene());
    wire::StreamDescription description;
    description.adapter_name = "identity";
    description.epoch = 1;
    for (uint32_t body = 0; body < kBodies; ++body) description.node_names.push_back(body_name(body));
    const state::StreamId stream = poses.add_stream(description);

    RenderBench bench(scene(), kExtent);
    std::vector<sinks::FrameImage> images;
    for (uint32_t frame = 0; frame < kFrames; ++frame) {
      std::vector<wire::Affine3x4> stream_from_body = make_poses(frame);
      if (tamper) tamper(frame, stream_from_body);
      wire::PoseFrameView view;
      view.header = {1, frame + 1, frame * 1000000, 0, 0, 0};
      view.node_count = kBodies;
      view.poses = stream_from_body;
      EXPECT_TRUE(poses.push(stream, view));
      images.push_back(bench.draw(poses, first_camera_view(scene(), poses, kExtent)));
    }
    return images;
  }

  static std::vector<sinks::FrameImage> play_over(const std::string& listen_uri, const Tamper& tamper = {}) {
    state::PoseState poses(scene());
    app::StreamReceiver receiver(poses, true);
    transport::ListenerOptions options;
    options.delivery = transport::Delivery::all;
    auto listener = transport::open_listener(listen_uri, options);
    if (!listener) {
      ADD_FAILURE() << listener.error().message;
      return {};
    }
    const std::string uri = (*listener)->uri();
    receiver.add(std::move(*listener));

    fire3dv_stream* stream = fire3dv_open(uri.c_str(), nullptr);
    if (!stream) {
      ADD_FAILURE() << fire3dv_last_error();
      return {};
    }
    std::vector<std::string> names;
    std::vector<const char*> name_pointers;
    for (uint32_t body = 0; body < kBodies; ++body) names.push_back(body_name(body));
    for (const std::string& name : names) name_pointers.push_back(name.c_str());
    fire3dv_description description{};
    description.struct_size = sizeof description;
    description.node_names = name_pointers.data();
    description.node_count = kBodies;
    EXPECT_EQ(fire3dv_describe(stream, &description), FIRE3DV_OK) << fire3dv_last_error();
    wait_for_welcome(stream, receiver);

    RenderBench bench(scene(), kExtent);
    std::vector<sinks::FrameImage> images;
    for (uint32_t frame = 0; frame < kFrames && !HasFailure(); ++frame) {
      std::vector<wire::Affine3x4> stream_from_body = make_poses(frame);
      if (tamper) tamper(frame, stream_from_body);
      EXPECT_EQ(fire3dv_publish(stream, frame * 1000000, stream_from_body[0].m.data(), kBodies, 0),
                FIRE3DV_OK);
      if (!shown_before_hang_limit(receiver)) break;
      images.push_back(bench.draw(poses, first_camera_view(scene(), poses, kExtent)));
      EXPECT_EQ(images.back().shown.at(0).sequence, frame + 1);
      receiver.acknowledge(images.back().shown);
      EXPECT_EQ(fire3dv_wait_ack(stream, frame + 1, 60000), FIRE3DV_OK) << fire3dv_last_error();
    }
    fire3dv_close(&stream);
    return images;
  }

  // UDP sends no poses before the end of the handshake, and a lost frame would not be acknowledged.
  static void wait_for_welcome(fire3dv_stream* stream, app::StreamReceiver& receiver) {
    fire3dv_status status{};
    status.struct_size = sizeof status;
    status.welcome = -1;
    for (int i = 0; i < 60000 && status.welcome < 0; ++i) {
      receiver.poll();
      receiver.wait(std::chrono::milliseconds(1));
      fire3dv_poll(stream, &status);
    }
    EXPECT_EQ(status.welcome, 0) << status.welcome_message;
    EXPECT_EQ(status.unmatched_names, 0u) << status.welcome_message;
  }

  static bool shown_before_hang_limit(app::StreamReceiver& receiver) {
    for (int i = 0; i < 60000; ++i) {
      if (receiver.poll()) return true;
      receiver.wait(std::chrono::milliseconds(1));
    }
    ADD_FAILURE() << "a published frame did not arrive";
    return false;
  }

  static const std::vector<sinks::FrameImage>& reference() {
    static const std::vector<sinks::FrameImage> images = play_in_process();
    return images;
  }

  static void expect_identical(const std::vector<sinks::FrameImage>& images, const char* transport) {
    ASSERT_EQ(images.size(), reference().size());
    for (size_t frame = 0; frame < images.size(); ++frame) {
      ASSERT_TRUE(matches_image(images[frame], reference()[frame],
                                std::string("identity_") + transport + "_" + std::to_string(frame),
                                Tolerance::exact()))
          << "frame " << frame << " over " << transport;
    }
  }

  static size_t count_different(const std::vector<sinks::FrameImage>& images) {
    size_t different = 0;
    for (size_t frame = 0; frame < images.size(); ++frame) {
      different += images[frame].rgba8 != reference().at(frame).rgba8;
    }
    return different;
  }

  static std::string shm_uri() { return "shm://identity_" + std::to_string(getpid()); }
};

TEST_F(Identity, TheImagesDifferFromOneAnother) {
  std::set<std::vector<uint8_t>> distinct;
  for (const sinks::FrameImage& image : reference()) distinct.insert(image.rgba8);
  EXPECT_EQ(distinct.size(), kFrames);
}

TEST_F(Identity, OverSharedMemory) {
  expect_identical(play_over(shm_uri()), "shm");
}
TEST_F(Identity, OverTcp) {
  expect_identical(play_over("tcp://127.0.0.1:0"), "tcp");
}
TEST_F(Identity, OverUdp) {
  expect_identical(play_over("udp://127.0.0.1:0"), "udp");
}

// Negative controls: on each transport a single wrong bit changes exactly one image.
TEST_F(Identity, WrongBitIsDetectedInProcess) {
  EXPECT_EQ(count_different(play_in_process(flip_one_bit)), 1u);
}
TEST_F(Identity, WrongBitIsDetectedOverShm) {
  EXPECT_EQ(count_different(play_over(shm_uri(), flip_one_bit)), 1u);
}
TEST_F(Identity, WrongBitIsDetectedOverTcp) {
  EXPECT_EQ(count_different(play_over("tcp://127.0.0.1:0", flip_one_bit)), 1u);
}
TEST_F(Identity, WrongBitIsDetectedOverUdp) {
  EXPECT_EQ(count_different(play_over("udp://127.0.0.1:0", flip_one_bit)), 1u);
}

}  // namespace
}  // namespace fire3dv::test
