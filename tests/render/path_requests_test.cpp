// Render test of path-traced images that are requested: withdrawn and replaced requests, and the images of
// viewers, which are sent while they refine.
#include <gtest/gtest.h>

#include <cstddef>
#include <map>
#include <span>
#include <vector>

#include "base/clock.h"
#include "renderer/app/device_uploader.h"
#include "renderer/images/image_service.h"
#include "renderer/passes/path/path_pass.h"
#include "renderer/passes/view/view.h"
#include "tests/render/support/path_bench.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"
#include "tests/render/support/truth_scenes.h"

namespace fire3dv::test {
namespace {

constexpr uint64_t kEpoch = 3;
constexpr uint32_t kWidth = 24, kHeight = 16;
constexpr uint32_t kEndless = 1 << 20;  // samples of an image that no test awaits
constexpr state::RequesterId kClient = 1, kViewer = 10, kOtherViewer = 11;

scene::LoadedScene loaded(scene::Scene scene) {
  scene::LoadedScene loaded{std::move(scene), {}};
  loaded.derived = scene::derive(loaded.scene);
  return loaded;
}

// A client and viewers whose frame 1 is shown, and their images.
class Client final : public app::ImageReplies {
 public:
  struct Image {
    uint64_t request = 0;
    uint32_t samples = 0;
    std::vector<std::byte> pixels;
  };

  std::optional<Shown> shown(state::RequesterId requester) const override {
    Shown shown{{kEpoch, 1, 0}, {}, {}};
    if (requester != kClient) {
      shown.appearance.shown_samples = shown_samples.at(requester);
      shown.appearance.keeps_samples = keeps_samples;
    }
    return shown;
  }
  void refuse_image(state::RequesterId, const wire::ImageRefused& refused, bool) override {
    ADD_FAILURE() << refused.message;
  }
  bool send_image(state::RequesterId, const wire::ImageFrame& frame,
                  const transport::ListenerLink::FillPixels& fill) override {
    images.push_back({frame.request, samples[frame.request], std::vector<std::byte>(frame.pixel_bytes)});
    fill(images.back().pixels);
    return true;
  }
  void set_samples(state::RequesterId, uint64_t request, uint32_t count) override {
    samples[request] = count;
  }

  std::vector<Image> images;
  std::map<uint64_t, uint32_t> samples;                                                   // of each request
  std::map<state::RequesterId, uint32_t> shown_samples{{kViewer, 0}, {kOtherViewer, 0}};  // of viewers
  bool keeps_samples = true;                                                              // of viewers
};

class PathRequests : public ValidationIsSilent {
 protected:
  wire::ImageRequest request(uint64_t id, uint32_t place, glm::vec3 eye) const {
    wire::ImageRequest request;
    request.epoch = kEpoch;
    request.id = id;
    request.place = place;
    request.parent_from_camera = app::affine_of(passes::look_at_pose(eye, {0, 0.4f, 0}));
    request.intrinsics = {kWidth, kHeight, 20, 20, kWidth / 2.0f - 0.5f, kHeight / 2.0f - 0.5f, 0.01f, 0, {}};
    return request;
  }
  void ask(const wire::ImageRequest& request, state::RequesterId requester = kClient) {
    requests_.on_image_request(requester, request, nullptr);
  }
  // The viewer's next image.
  Client::Image view(state::RequesterId viewer, glm::vec3 eye) {
    const size_t before = client_.images.size();
    ask(request(++last_request_, 0, eye), viewer);
    serve_until([&] { return client_.images.size() > before; });
    const Client::Image image = client_.images.back();
    EXPECT_EQ(image.request, last_request_);
    client_.shown_samples[viewer] = image.samples;
    return image;
  }
  void set_samples(uint32_t samples) {
    settings_.path->samples_per_pixel = samples;
    bench_.renderer().apply(settings_);
  }
  uint32_t samples() { return bench_.renderer().path_tracer()->progress().samples; }
  // Serves requests until the condition holds; fails if it does not come to hold.
  template <typename Condition>
  void serve_until(Condition&& condition) {
    // Not a number of turns: those in which a requester has its quiet time cost next to nothing.
    for (const int64_t end_ns = monotonic_ns() + 60 * kSecondNs; monotonic_ns() < end_ns;) {
      if (condition()) return;
      (void)service_.draw_due(bench_.frames());
      service_.wait(service_.submitted());
      service_.deliver();
    }
    ADD_FAILURE() << "endless";
  }
  // Begins the image of this request, which nobody can await.
  void begin_endless(const wire::ImageRequest& request) {
    set_samples(kEndless);
    ask(request);
    serve_until([&] { return service_.is_tracing() && samples() >= 2; });
  }

  const scene::LoadedScene scene_ = loaded(lit_ball());
  settings::DrawSettings settings_ = path_settings(kEndless, 1);
  RenderBench bench_{scene_.scene, {kWidth, kHeight}, settings_};
  state::PoseState poses_{scene_.scene};
  app::DeviceUploader uploader_{bench_.renderer()};
  app::LiveScene live_{scene_, poses_, uploader_, {}};
  uint64_t last_request_ = 100;
  Client client_;
  app::ImageRequestQueue requests_{client_, app::image_abilities(bench_.renderer(), true)};
  app::ImageService service_{device(), bench_.renderer(), poses_, requests_, live_, {}};
};

TEST_F(PathRequests, CancelledImageEndsAtSubmission) {
  const wire::ImageRequest endless = request(1, 0, {0.5f, 1.6f, 3});
  begin_endless(endless);
  wire::ImageRequest withdrawal = endless;
  withdrawal.when = wire::ImageWhen::never;
  ask(withdrawal);
  const uint32_t traced = samples();
  (void)service_.draw_due(bench_.frames());
  EXPECT_FALSE(service_.is_tracing());
  EXPECT_LE(samples(), traced);
  // With so few samples the first image would end as well.
  set_samples(3);
  ask(request(2, 1, {-0.5f, 1.6f, 3}));
  serve_until([&] { return !client_.images.empty(); });
  EXPECT_EQ(client_.images.front().request, 2u);
  EXPECT_EQ(samples(), 3u);
  serve_until([&] { return requests_.count() == 0; });
  EXPECT_EQ(client_.images.size(), 1u);
}

TEST_F(PathRequests, ReplacedImageEnds) {
  begin_endless(request(1, 0, {0.5f, 1.6f, 3}));
  ask(request(2, 0, {-0.5f, 1.6f, 3}));
  set_samples(3);
  serve_until([&] { return !client_.images.empty(); });
  EXPECT_EQ(client_.images.front().request, 2u);
  EXPECT_EQ(requests_.count(), 0u);
}

// Until its image is whole, so that it can be withdrawn.
TEST_F(PathRequests, RequestStaysOpenWhileTracing) {
  begin_endless(request(1, 0, {0.5f, 1.6f, 3}));
  EXPECT_EQ(requests_.count(), 1u);
  set_samples(samples() + 3);
  serve_until([&] { return !client_.images.empty(); });
  EXPECT_EQ(client_.images.front().request, 1u);
  EXPECT_EQ(requests_.count(), 0u);
}

// Two viewers with views of their own: images come early, each with more samples of the same image.
TEST_F(PathRequests, ViewersRefineInTurns) {
  const glm::vec3 eye{0.5f, 1.6f, 3}, other_eye{-0.5f, 1.6f, 3};
  uint32_t before = 0, other_before = 0;
  for (int turn = 0; turn < 3; ++turn) {
    const uint32_t now = view(kViewer, eye).samples, other_now = view(kOtherViewer, other_eye).samples;
    EXPECT_GT(now, before);
    EXPECT_GT(other_now, other_before);
    before = now;
    other_before = other_now;
    // A pick comes between.
    wire::ImageRequest pick = request(++last_request_, 1, eye);
    pick.outputs = wire::kInstanceU32;
    ask(pick, kViewer);
    serve_until([&] { return client_.images.back().request == last_request_; });
  }
  // A camera that moves, which keeps no samples, leaves those of others.
  for (int step = 0; step < 8; ++step) {
    client_.shown_samples[kViewer] = 0;
    client_.keeps_samples = false;
    (void)view(kViewer, {0.1f * static_cast<float>(step), 1.6f, 3});
  }
  client_.keeps_samples = true;
  EXPECT_GT(view(kOtherViewer, other_eye).samples, other_before);
}

TEST_F(PathRequests, ViewerImageMatchesClientImage) {
  const glm::vec3 eye{0.5f, 1.6f, 3};
  set_samples(40);
  Client::Image image;
  while (image.samples < 40 && !HasFailure()) {
    image = view(kViewer, eye);
    (void)view(kOtherViewer, {-0.5f, 1.6f, 3});
  }
  ask(request(1, 0, eye));
  serve_until([&] { return client_.images.back().request == 1; });
  EXPECT_EQ(client_.images.back().samples, 40u);
  EXPECT_EQ(client_.images.back().pixels, image.pixels);
}

// Of a stream whose poses change, every image is of the newest ones and has at least one sample.
TEST_F(PathRequests, AViewerSeesPosesChange) {
  const glm::vec3 eye{0.5f, 1.6f, 3};
  const std::vector<std::byte> at_rest = view(kViewer, eye).pixels;
  state::RestPose pose = state::rest_pose(scene_.scene);
  pose.parent_from_node[0] = pose.world_from_node[0] = at({0.8f, 0.5f, 0});
  poses_.set_rest(pose);
  client_.shown_samples[kViewer] = 0;
  const Client::Image moved = view(kViewer, eye);
  EXPECT_GT(moved.samples, 0u);
  set_samples(moved.samples);
  ask(request(1, 0, eye));
  serve_until([&] { return client_.images.back().request == 1; });
  EXPECT_EQ(client_.images.back().pixels, moved.pixels);
  EXPECT_NE(moved.pixels, at_rest);
}

}  // namespace
}  // namespace fire3dv::test
