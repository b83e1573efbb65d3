// Property test: with random edits, connections and packet loss, the renderer's scene and poses finally equal
// those of the simulator.
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <map>
#include <optional>
#include <random>

#include "fire3dv/client.hpp"
#include "fire3dv/markers.h"
#include "protocol/transport/open.h"
#include "protocol/transport/udp/udp_datagram.h"
#include "protocol/wire/decode.h"
#include "renderer/state/pose_state.h"
#include "tools/lab/impair/relay.h"

namespace fire3dv {
namespace {

using Key = std::pair<std::string, wire::Property>;
using Model = std::map<Key, wire::EditValue>;

// A renderer from a listener to its pose state and scene.
class Reader {
 public:
  explicit Reader(const std::string& uri) {
    auto opened = transport::open_listener(uri);
    EXPECT_TRUE(opened.ok()) << opened.error().message;
    if (opened.ok()) link_ = std::move(*opened);
  }
  std::string uri() const { return link_->uri(); }

  void poll() {
    link_->wait(std::chrono::milliseconds(1));
    link_->poll([this](const transport::LinkEvent& event) { take(event); });
    for (state::SceneChanges& changes : poses_.take_scene_changes()) {
      if (changes.ended) scene_.clear();
      for (wire::SceneEdit& edit : changes.edits) {
        EXPECT_GT(edit.version, version_) << "edits come in order";
        version_ = edit.version;
        scene_[{edit.node, edit.property}] = edit.value;
      }
    }
    // A frame never shows without the edits that it belongs to.
    if (stream_) {
      EXPECT_LE(poses_.streams()[*stream_].header.scene_version, version_);
    }
  }

  // Values that were cleared are as if they had never been set.
  Model scene() const {
    Model model = scene_;
    std::erase_if(model,
                  [](const auto& entry) { return std::holds_alternative<wire::Cleared>(entry.second); });
    return model;
  }
  std::vector<wire::Affine3x4> shown() const {
    return stream_ ? poses_.streams()[*stream_].poses : std::vector<wire::Affine3x4>();
  }
  const state::Stream* stream() const { return stream_ ? &poses_.streams()[*stream_] : nullptr; }

 private:
  void take(const transport::LinkEvent& event) {
    using Kind = transport::LinkEvent::Kind;
    if (event.kind == Kind::disconnected) end();
    if (event.kind != Kind::pose && event.kind != Kind::control) return;
    auto message = decoder_.decode(event.message);
    ASSERT_TRUE(message.ok()) << message.error().message;
    if (const auto* description = std::get_if<wire::StreamDescription>(&*message)) {
      if (stream_ && poses_.streams()[*stream_].epoch == description->epoch) return;
      end();
      stream_ = poses_.add_stream(*description);
      version_ = 0;
    }
    if (!stream_) return;
    if (const auto* frame = std::get_if<wire::PoseFrameView>(&*message)) poses_.push(*stream_, *frame);
    if (auto* edit = std::get_if<wire::SceneEdit>(&*message)) poses_.apply(*stream_, std::move(*edit));
  }
  void end() {
    if (stream_) poses_.remove_stream(*stream_);
    stream_.reset();
    scene_.clear();  // what was not taken is gone with the stream
  }

  std::unique_ptr<transport::ListenerLink> link_;
  wire::Decoder decoder_;
  scene::Scene empty_;
  state::PoseState poses_{empty_};
  std::optional<state::StreamId> stream_;
  Model scene_;
  uint64_t version_ = 0;
};

class EditsProperty : public testing::TestWithParam<const char*> {
 protected:
  void run(uint32_t seed);
  void edit(Stream& stream, std::mt19937& generator, Model& model);
};

void EditsProperty::edit(Stream& stream, std::mt19937& generator, Model& model) {
  const std::string node = "node " + std::to_string(generator() % 12);
  const auto fraction = [&] { return static_cast<float>(generator() % 100) / 100.0f; };
  using P = wire::Property;
  switch (generator() % 9) {
    case 0: {
      const bool visible = generator() % 2 != 0;
      stream.set_visible(node, visible);
      model[{node, P::visible}] = wire::Visible{visible};
      break;
    }
    case 1: {
      const std::array<float, 4> rgba{fraction(), fraction(), fraction(), 1};
      stream.set_base_color(node, rgba);
      model[{node, P::base_color}] = wire::BaseColor{rgba};
      break;
    }
    case 2: {
      fire3dv_light light{};
      light.kind = FIRE3DV_LIGHT_SPOT;
      light.color_rgb[1] = fraction();
      light.intensity = 1000 * fraction();
      light.range_m = fraction();
      light.inner_cone_rad = 0.25f;
      light.outer_cone_rad = 0.5f;
      light.casts_shadow = generator() % 2 != 0;
      stream.set_light(node, light);
      model[{node, P::light}] = wire::Light{
          wire::LightKind::spot,  {0, light.color_rgb[1], 0}, light.intensity, light.range_m, 0.25f, 0.5f,
          light.casts_shadow != 0};
      break;
    }
    case 3: {
      fire3dv_camera camera{};
      camera.vertical_fov_rad = 0.5f + fraction();
      camera.near_m = 0.1f;
      stream.set_camera(node, camera);
      model[{node, P::camera}] = wire::Camera{camera.vertical_fov_rad, 0.1f, 0, 0};
      break;
    }
    case 4: {
      const std::vector<std::byte> glb(generator() % 20'000, std::byte{7});
      fire3dv_node added{};
      added.parent = "base";
      added.asset_glb = glb.empty() ? nullptr : glb.data();
      added.asset_glb_bytes = glb.size();
      stream.add_node(node, added);
      model[{node, P::node}] = wire::NodeAdded{"base", {}, "", glb};
      break;
    }
    case 5:
      stream.remove_node(node);
      model[{node, P::node}] = wire::NodeRemoved{};
      break;
    case 6: {
      std::vector<std::array<float, 3>> positions(1 + generator() % 2000);
      for (auto& position : positions) position = {fraction(), 0, 1};
      stream.set_vertices(node, positions);
      model[{node, P::vertices}] = wire::Vertices{positions, {}};
      break;
    }
    case 7: {
      std::vector<uint8_t> pixels(3 * (1 + generator() % 900));
      for (uint8_t& value : pixels) value = static_cast<uint8_t>(generator());
      const float position[] = {fraction(), 0, 1}, size[] = {1, fraction(), 0};
      fire3dv_marker marker{};
      marker.struct_size = sizeof marker;
      marker.kind = FIRE3DV_MARKER_IMAGES;
      marker.positions = position;
      marker.sizes = size;
      marker.position_count = marker.size_count = 1;
      marker.image_pixels = pixels.data();
      marker.image_width = static_cast<uint32_t>(pixels.size() / 3);
      marker.image_height = 1;
      marker.image_channels = 3;
      ASSERT_EQ(fire3dv_set_marker(stream.get(), node.c_str(), &marker), FIRE3DV_OK) << fire3dv_last_error();
      wire::Marker expected;
      expected.kind = wire::MarkerKind::images;
      expected.width = 0;
      expected.positions = {{position[0], 0, 1}};
      expected.sizes = {{1, size[1], 0}};
      expected.image = {marker.image_width, 1, 3, pixels};
      model[{node, P::marker}] = expected;
      break;
    }
    case 8: {
      // fire3dv_clear() clears what the scene has, up to markers.
      const auto property = static_cast<int>(generator() % (static_cast<unsigned>(P::marker) + 1));
      stream.clear(node, property);
      model.erase({node, static_cast<P>(property)});
      break;
    }
  }
}

void EditsProperty::run(uint32_t seed) {
  std::mt19937 generator(seed);
  const std::string scheme = GetParam();
  const std::string name = "shm://test-property-" + std::to_string(::getpid()) + "-" + std::to_string(seed);
  auto reader = std::make_unique<Reader>(scheme == "shm" ? name : scheme + "://127.0.0.1:0");
  const std::string listener_uri = reader->uri();
  std::string uri = listener_uri;
  std::unique_ptr<impair::UdpRelay> relay;
  if (scheme == "udp") {
    impair::Impairment bad;
    bad.loss = 0.2;
    bad.duplicate = 0.05;
    bad.reorder = 0.25;
    bad.delay_ns = 1'000'000;
    bad.seed = seed;
    auto opened = impair::UdpRelay::open("udp://127.0.0.1:0", listener_uri, bad);
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    relay = std::move(*opened);
    uri = relay->uri();
  }

  Stream stream(uri, "property");
  Model model;
  size_t nodes = 0;
  std::vector<Pose> poses;
  const auto describe = [&] {
    nodes = 1 + generator() % 60;  // up to three datagrams
    std::vector<std::string> names;
    for (size_t i = 0; i < nodes; ++i) names.push_back("body " + std::to_string(i));
    stream.describe(names);
    poses.assign(nodes, Pose{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
    std::vector<uint32_t> all(nodes);
    for (uint32_t i = 0; i < nodes; ++i) all[i] = i;
    stream.publish_some(std::chrono::nanoseconds(0), all, poses);
  };
  edit(stream, generator, model);  // before anything is described
  describe();
  for (int step = 0; step < 400; ++step) {
    if (generator() % 3 == 0) edit(stream, generator, model);
    if (generator() % 100 == 0) describe();
    if (generator() % 100 == 0) {  // the renderer is started anew
      reader.reset();
      reader = std::make_unique<Reader>(listener_uri);
    }
    std::vector<uint32_t> moved;
    std::vector<Pose> some;
    for (uint32_t i = 0; i < nodes; ++i) {
      if (generator() % 5 != 0) continue;
      poses[i][3] = static_cast<float>(generator() % 1000);
      moved.push_back(i);
      some.push_back(poses[i]);
    }
    if (generator() % 10 == 0)
      stream.publish(std::chrono::nanoseconds(step), poses);
    else if (!moved.empty())
      stream.publish_some(std::chrono::nanoseconds(step), moved, some);
    if (generator() % 4 == 0) reader->poll();
  }
  // Nothing more is published; the links still have what it takes.
  const auto is_same = [&] {
    const auto shown = reader->shown();
    if (shown.size() != poses.size()) return false;
    for (size_t i = 0; i < poses.size(); ++i)
      if (shown[i].m != poses[i]) return false;
    return reader->scene() == model;
  };
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!is_same() && std::chrono::steady_clock::now() < until) reader->poll();
  EXPECT_EQ(reader->scene().size(), model.size());
  EXPECT_TRUE(reader->scene() == model);
  EXPECT_TRUE(is_same()) << "seed " << seed;
  ASSERT_NE(reader->stream(), nullptr);
  EXPECT_EQ(reader->stream()->edits_refused, 0u);
}

TEST_P(EditsProperty, QuietStateMatchesSimulator) {
  // A renderer that is started anew is found again sooner where nothing is lost on the way.
  const uint32_t runs = std::string(GetParam()) == "udp" ? 3 : 8;
  for (uint32_t seed = 1; seed <= runs && !HasFailure(); ++seed) run(seed);
}

INSTANTIATE_TEST_SUITE_P(Links, EditsProperty, testing::Values("shm", "tcp", "udp"),
                         [](const auto& test) { return std::string(test.param); });

// Body 0 moves for the last time in a frame that is lost; what comes after it does not speak of body 0, and
// then nothing comes at all.
TEST(EditsConverge, LastFrameIsLost) {
  Reader reader("udp://127.0.0.1:0");
  auto opened = impair::UdpRelay::open("udp://127.0.0.1:0", reader.uri(), {});
  ASSERT_TRUE(opened.ok()) << opened.error().message;
  std::atomic<bool> lose{false};
  std::atomic<int> lost{0};
  (*opened)->set_filter([&](bool, std::span<std::byte> datagram) {
    transport::udp::Header header;
    const bool is_pose =
        transport::udp::read_header(datagram, header) && header.type == transport::udp::Type::pose;
    const bool vanishes = is_pose && lose;
    lost += vanishes;
    return !vanishes;
  });
  Stream stream((*opened)->uri(), "converges");
  stream.describe({"a", "b"});
  const auto poll_until = [&](auto done) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!done() && std::chrono::steady_clock::now() < until) reader.poll();
    return done();
  };
  stream.publish_some(std::chrono::nanoseconds(0), {0, 1}, std::vector<Pose>(2));
  ASSERT_TRUE(poll_until([&] { return reader.shown().size() == 2; }));
  Pose moved{};
  moved[3] = 7;
  lose = true;
  stream.publish_some(std::chrono::nanoseconds(1), {0}, {moved});
  ASSERT_TRUE(poll_until([&] { return lost != 0; }));
  lose = false;
  stream.publish_some(std::chrono::nanoseconds(2), {1}, {moved});
  EXPECT_TRUE(poll_until([&] { return reader.shown()[1].m == moved; }));
  EXPECT_TRUE(poll_until([&] { return reader.shown()[0].m == moved; })) << "it stays where it was for good";
}

}  // namespace
}  // namespace fire3dv
