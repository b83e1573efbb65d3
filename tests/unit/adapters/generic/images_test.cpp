// Test of image requests through the C interface: argument checks, the request as the renderer receives it,
// and its answers.
#include <atomic>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <thread>

#include "fire3dv/batch.h"
#include "fire3dv/image.h"
#include "fire3dv/scene.h"
#include "protocol/wire/image.h"
#include "tests/unit/adapters/generic/client_fixture.h"

namespace fire3dv::test {
namespace {

struct Close {
  void operator()(fire3dv_stream* stream) const { fire3dv_close(&stream); }
};
using Stream = std::unique_ptr<fire3dv_stream, Close>;

struct Release {
  void operator()(fire3dv_image* image) const { fire3dv_release_image(&image); }
};
using Image = std::unique_ptr<fire3dv_image, Release>;

const float kPose[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

fire3dv_image_request small(int32_t when = 0) {
  fire3dv_image_request request{};
  request.struct_size = sizeof request;
  request.width = 8;
  request.height = 4;
  request.fx = request.fy = 10;
  request.cx = 3.5f;
  request.cy = 1.5f;
  request.when = when;
  return request;
}

// Fake renderer: receives requests, and answers with images whose pixels encode the sequence.
struct Drawer {
  std::unique_ptr<transport::ListenerLink> link;
  transport::PeerId peer = 0;
  std::map<uint32_t, wire::ImageRequest> requests;  // by place
  uint64_t sequence = 0;
  uint64_t epoch = 0;

  explicit Drawer(const std::string& uri) {
    auto opened = transport::open_listener(uri);
    EXPECT_TRUE(opened.ok()) << opened.error().message;
    if (opened.ok()) link = std::move(*opened);
  }
  void poll() {
    link->wait(std::chrono::milliseconds(1));
    link->poll([&](const transport::LinkEvent& event) {
      if (event.kind == transport::LinkEvent::Kind::connected) peer = event.peer;
      if (event.message.empty()) return;
      const auto message = decoder_.decode(event.message);
      ASSERT_TRUE(message.ok()) << message.error().message;
      if (const auto* m = std::get_if<wire::ImageRequest>(&*message)) requests[m->place] = *m;
      if (const auto* m = std::get_if<wire::PoseFrameView>(&*message)) sequence = m->header.sequence;
      if (const auto* m = std::get_if<wire::StreamDescription>(&*message)) {
        epoch = m->epoch;
        requests.clear();
      }
    });
  }
  bool poll_until(const std::function<bool()>& done) {
    return repeat_until([&] {
      poll();
      return done();
    });
  }
  // views: as of the request, unless the renderer lies.
  bool answer(const wire::ImageRequest& request, uint64_t number, uint64_t shows, uint32_t views = 0,
              uint32_t row_padding = 0) {
    wire::ImageFrame frame;
    frame.views = views == 0 ? request.views() : views;
    frame.request = request.id;
    frame.number = number;
    frame.epoch = request.epoch;
    frame.sequence = shows;
    frame.sim_time_ns = static_cast<int64_t>(shows) * 1000;
    frame.intrinsics = request.intrinsics;
    const uint32_t width = frame.intrinsics.width, height = frame.intrinsics.height * frame.views;
    for (uint32_t bit = 0; bit < wire::kImageOutputCount; ++bit) {
      if ((request.outputs >> bit & 1) == 0) continue;
      const wire::ImageOutputInfo& info = wire::info_at(bit);
      const uint32_t row = info.element_bytes * width + row_padding;
      frame.planes.push_back({bit, info.format, width, height, row, frame.pixel_bytes, row * height});
      frame.pixel_bytes += (frame.planes.back().bytes + 63) / 64 * 64;
    }
    return link->send_image(peer, request.id, wire::encode(frame), frame.pixel_bytes,
                            [&](std::span<std::byte> pixels) {
                              for (size_t i = 0; i + 8 <= pixels.size(); i += 8)
                                std::memcpy(pixels.data() + i, &shows, 8);
                            });
  }

 private:
  wire::Decoder decoder_;
};

// Returns the sequence that all pixels encode.
uint64_t drawn_sequence(const fire3dv_image& image) {
  const fire3dv_image_plane& plane = image.planes[0];
  uint64_t first = 0;
  std::memcpy(&first, plane.data, 8);
  for (size_t i = 0; i < size_t{plane.row_stride} * plane.height; i += 8) {
    uint64_t one = 0;
    std::memcpy(&one, static_cast<const std::byte*>(plane.data) + i, 8);
    EXPECT_EQ(one, first) << "pixels of several images";
  }
  return first;
}

class ClientImage : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    drawer_.emplace(listener_uri(GetParam()));
    stream_.reset(fire3dv_open(drawer_->link->uri().c_str(), nullptr));
    ASSERT_NE(stream_, nullptr) << fire3dv_last_error();
    ASSERT_EQ(describe(stream_.get(), {"node"}), FIRE3DV_OK);
  }
  uint64_t send_request(const fire3dv_image_request& request) {
    uint64_t id = 0;
    EXPECT_EQ(fire3dv_request_image(stream_.get(), &request, &id), FIRE3DV_OK) << fire3dv_last_error();
    return id;
  }
  // Returns the drawer's copy of the request after its arrival.
  wire::ImageRequest seen(uint64_t id) {
    wire::ImageRequest found;
    EXPECT_TRUE(drawer_->poll_until([&] {
      for (const auto& [place, request] : drawer_->requests)
        if (request.id == id) found = request;
      return found.id == id;
    }));
    return found;
  }
  Image wait(uint64_t id, int expected = FIRE3DV_OK, uint32_t timeout_ms = 60'000) {
    fire3dv_image* image = nullptr;
    EXPECT_EQ(fire3dv_wait_image(stream_.get(), id, timeout_ms, &image), expected) << fire3dv_last_error();
    return Image(image);
  }
  void publish() {
    std::vector<float> poses;
    for (size_t node = 0; node < nodes_; ++node) poses.insert(poses.end(), kPose, kPose + 12);
    ASSERT_EQ(fire3dv_publish(stream_.get(), 0, poses.data(), nodes_, 0), FIRE3DV_OK) << fire3dv_last_error();
  }
  // The drawer's image of this frame, which is published first.
  bool answer(const wire::ImageRequest& request, uint64_t number, uint64_t shows) {
    for (uint64_t sequence = poll(stream_.get()).sequence; sequence < shows; ++sequence) publish();
    return drawer_->answer(request, number, shows);
  }

  std::optional<Drawer> drawer_;
  Stream stream_;
  size_t nodes_ = 1;  // described
};

INSTANTIATE_TEST_SUITE_P(Links, ClientImage, ::testing::Values("shm", "tcp"));

TEST_P(ClientImage, BatchReturnsAllViews) {
  nodes_ = 3;
  ASSERT_EQ(describe(stream_.get(), {"a", "b", "c"}), FIRE3DV_OK);
  std::vector<float> poses(2 * 2 * 12, 0.5f), cameras(3 * 12, 0.25f);
  const uint32_t nodes[2] = {2, 0}, views[3] = {1, 0, 1};
  const float projections[12] = {10, 11, 1, 2, 12, 13, 3, 4, 14, 15, 5, 6};
  const uint8_t active[2] = {1, 0};
  fire3dv_batch_request request{};
  request.struct_size = sizeof request;
  request.worlds = request.pose_worlds = request.node_count = 2;
  request.node_indices = nodes;
  request.poses = poses.data();
  request.world_of_view = views;
  request.views = request.pose_views = 3;
  request.parent_from_camera = cameras.data();
  request.projections = projections;
  request.active = active;
  request.width = 8;
  request.height = 4;
  request.outputs = FIRE3DV_IMAGE_COLOR_SRGB8 | FIRE3DV_IMAGE_DEPTH_F32;
  uint64_t id = 0;
  ASSERT_EQ(fire3dv_request_batch(stream_.get(), &request, &id), FIRE3DV_OK) << fire3dv_last_error();
  poses.assign(poses.size(), 9);  // they were copied
  const wire::ImageRequest got = seen(id);
  ASSERT_TRUE(got.batch);
  EXPECT_EQ(got.when, wire::ImageWhen::batch);
  EXPECT_EQ(got.sequence, 0u);
  EXPECT_EQ(got.batch->worlds, 2u);
  EXPECT_EQ(got.batch->node_indices, (std::vector<uint32_t>{2, 0}));
  ASSERT_EQ(got.batch->poses.size(), 4u);
  EXPECT_EQ(got.batch->poses[3].m[11], 0.5f);
  EXPECT_EQ(got.batch->world_of_view, (std::vector<uint32_t>{1, 0, 1}));
  EXPECT_EQ(got.batch->view_poses.size(), 3u);
  ASSERT_EQ(got.batch->view_projections.size(), 3u);
  EXPECT_EQ(got.batch->view_projections[2], (wire::Projection{14, 15, 5, 6}));
  EXPECT_EQ(got.batch->active, (std::vector<uint8_t>{1, 0}));
  EXPECT_EQ(got.intrinsics.fx, 10);
  ASSERT_TRUE(drawer_->answer(got, 1, 0, 2)) << "with too few views";
  EXPECT_EQ(wait(id, FIRE3DV_ERROR_TIMEOUT, 50), nullptr);
  EXPECT_NE(std::string(fire3dv_last_error()).find("it has 2 views instead of 3"), std::string::npos)
      << fire3dv_last_error();
  ASSERT_TRUE(drawer_->answer(got, 1, 0));
  EXPECT_EQ(wait(0, FIRE3DV_ERROR_STATE, 50), nullptr) << "a batch is not any image";
  const Image image = wait(id);
  ASSERT_NE(image, nullptr);
  EXPECT_EQ(image->views, 3u);
  EXPECT_EQ(image->height, 4u);
  ASSERT_EQ(image->plane_count, 2u);
  EXPECT_EQ(image->planes[1].height, 12u);
  EXPECT_EQ(image->planes[1].row_stride, 32u);

  request.node_indices = nullptr;  // all
  request.node_count = 0;
  request.pose_worlds = request.pose_views = 1;
  request.world_of_view = nullptr;
  request.views = 0;
  request.active = nullptr;
  request.projections = nullptr;
  request.fx = request.fy = 10;
  ASSERT_EQ(fire3dv_request_batch(stream_.get(), &request, &id), FIRE3DV_OK) << fire3dv_last_error();
  const wire::ImageRequest shared = seen(id);
  EXPECT_EQ(shared.batch->node_indices, (std::vector<uint32_t>{0, 1, 2}));
  EXPECT_EQ(shared.batch->poses.size(), 3u);
  EXPECT_EQ(shared.views(), 2u);
  EXPECT_EQ(shared.parent_from_camera.m[0], 0.25f);
  EXPECT_TRUE(shared.batch->view_poses.empty());
  EXPECT_EQ(fire3dv_cancel_image(stream_.get(), id), FIRE3DV_OK);

  fire3dv_batch_request one = request;
  one.worlds = 1;
  ASSERT_EQ(fire3dv_request_batch(stream_.get(), &one, &id), FIRE3DV_OK) << fire3dv_last_error();
  const wire::ImageRequest of_one = seen(id);
  ASSERT_TRUE(drawer_->answer(of_one, 1, 0, 0, 64)) << "with padded rows";
  EXPECT_EQ(wait(id, FIRE3DV_ERROR_TIMEOUT, 50), nullptr);
  EXPECT_NE(std::string(fire3dv_last_error()).find("it has rows of 96 bytes instead of 32"),
            std::string::npos)
      << fire3dv_last_error();
  ASSERT_TRUE(drawer_->answer(of_one, 1, 0));
  EXPECT_NE(wait(id), nullptr);

  const auto refuses = [&](const char* text, auto change) {
    fire3dv_batch_request bad = request;
    change(bad);
    EXPECT_EQ(fire3dv_request_batch(stream_.get(), &bad, &id), FIRE3DV_ERROR_ARGUMENT) << text;
    EXPECT_NE(std::string(fire3dv_last_error()).find(text), std::string::npos) << fire3dv_last_error();
  };
  refuses("struct_size is 8", [](auto& r) { r.struct_size = 8; });
  refuses("worlds is 0", [](auto& r) { r.worlds = 0; });
  refuses("worlds is 65536", [](auto& r) { r.worlds = 65'536; });
  refuses("poses is NULL", [](auto& r) { r.poses = nullptr; });
  refuses("pose_worlds is 3; the leading dimension of poses is 1 (shared) or 2",
          [](auto& r) { r.pose_worlds = 3; });
  refuses("node_indices is NULL", [](auto& r) { r.node_count = 2; });
  refuses("node_count is 4", [&](auto& r) {
    r.node_indices = nodes;
    r.node_count = 4;
  });
  const uint32_t beyond[2] = {0, 3}, twice[2] = {1, 1}, far_world[1] = {2};
  refuses("node_indices[1] is 3", [&](auto& r) {
    r.node_indices = beyond;
    r.node_count = 2;
  });
  refuses("node_indices has 1 twice", [&](auto& r) {
    r.node_indices = twice;
    r.node_count = 2;
  });
  refuses("world_of_view is NULL", [](auto& r) { r.views = 2; });
  refuses("world_of_view[0] is 2", [&](auto& r) {
    r.world_of_view = far_world;
    r.views = 1;
  });
  refuses("views is 65537", [&](auto& r) {
    r.world_of_view = far_world;
    r.views = 65'537;
  });
  refuses("pose_views is 7", [](auto& r) { r.pose_views = 7; });
  refuses("parent_from_camera is NULL", [](auto& r) { r.parent_from_camera = nullptr; });
  refuses("fx is 0", [](auto& r) { r.fx = r.fy = 0; });
  refuses("outputs is", [](auto& r) { r.outputs = 1u << 30; });
}

TEST_P(ClientImage, RequestReturnsItsImage) {
  publish();
  fire3dv_image_request request = small();
  request.node = "wrist";
  const float pose[12] = {1, 0, 0, 0.5f, 0, 1, 0, 0, 0, 0, 1, 2};
  request.parent_from_camera = pose;
  request.outputs = FIRE3DV_IMAGE_COLOR_SRGB8 | FIRE3DV_IMAGE_DEPTH_F32;
  const uint64_t id = send_request(request);
  const wire::ImageRequest got = seen(id);
  EXPECT_EQ(got.node, "wrist");
  EXPECT_EQ(got.epoch, drawer_->epoch);
  EXPECT_EQ(got.sequence, 1u) << "the newest that was published";
  EXPECT_EQ(got.outputs, wire::kColorSrgb8 | wire::kDepthF32);
  EXPECT_FALSE(got.markers);
  EXPECT_EQ(got.when, wire::ImageWhen::once);
  EXPECT_EQ(got.parent_from_camera.m[3], 0.5f);
  EXPECT_EQ(got.intrinsics, (wire::Intrinsics{8, 4, 10, 10, 3.5f, 1.5f, 0.01f, 0, {}}));
  EXPECT_EQ(wait(id, FIRE3DV_ERROR_TIMEOUT, 0), nullptr);
  EXPECT_NE(std::string(fire3dv_last_error()).find("; 1 renderer is reached"), std::string::npos)
      << fire3dv_last_error();
  ASSERT_TRUE(answer(got, 1, 1));
  const Image image = wait(id);
  ASSERT_NE(image, nullptr);
  EXPECT_EQ(image->request, id);
  EXPECT_EQ(image->sequence, 1u);
  EXPECT_EQ(image->sim_time_ns, 1000);
  EXPECT_EQ(image->width, 8u);
  ASSERT_EQ(image->plane_count, 2u);
  EXPECT_EQ(image->planes[0].output, uint32_t{FIRE3DV_IMAGE_COLOR_SRGB8});
  EXPECT_EQ(reinterpret_cast<uintptr_t>(image->planes[0].data) % 16, 0u);
  EXPECT_EQ(drawn_sequence(*image), 1u);
  EXPECT_EQ(image->f_number, 0);
  EXPECT_EQ(wait(id, FIRE3DV_ERROR_ARGUMENT), nullptr) << "once is once";
  request.markers = 1;
  EXPECT_TRUE(seen(send_request(request)).markers);
  EXPECT_EQ(image->hidden_streams, 0u);
}

TEST_P(ClientImage, CompleteImagesMayBeRequested) {
  fire3dv_image_request request = small();
  EXPECT_FALSE(seen(send_request(request)).complete);
  request.complete = 1;
  EXPECT_TRUE(seen(send_request(request)).complete);
  // `complete` lies behind the structure of programs that were built with 1.7, whose padding may hold
  // anything.
  request.reserved = 0xffffffff;
  request.struct_size = offsetof(fire3dv_image_request, complete);
  EXPECT_FALSE(seen(send_request(request)).complete);
}

TEST_P(ClientImage, ImageHasRequestedLens) {
  fire3dv_image_request request = small();
  request.f_number = 1.8f;
  request.focus_distance_m = 0.75f;
  const uint64_t id = send_request(request);
  const wire::ImageRequest got = seen(id);
  EXPECT_EQ(got.intrinsics.f_number, 1.8f);
  EXPECT_EQ(got.intrinsics.focus_distance_m, 0.75f);
  ASSERT_TRUE(answer(got, 1, 1));
  const Image image = wait(id);
  ASSERT_NE(image, nullptr);
  EXPECT_EQ(image->f_number, 1.8f);
  EXPECT_EQ(image->focus_distance_m, 0.75f);
  // Programs built before fields were appended pass smaller sizes; f_number lies where 1.6 had padding.
  request.markers = 1;
  request.struct_size = offsetof(fire3dv_image_request, markers) + 8;
  const wire::ImageRequest of_1_6 = seen(send_request(request));
  EXPECT_TRUE(of_1_6.markers);
  EXPECT_EQ(of_1_6.intrinsics.f_number, 0);
  request.struct_size = offsetof(fire3dv_image_request, markers);
  const wire::ImageRequest of_1_5 = seen(send_request(request));
  EXPECT_FALSE(of_1_5.markers);
  EXPECT_EQ(of_1_5.intrinsics.focus_distance_m, 0);
}

TEST_P(ClientImage, RandomDepthKeepsSequences) {
  constexpr uint64_t kRequests = 1000;
  std::atomic<bool> stop{false};
  std::thread draws([&] {
    std::mt19937 random(3);
    uint64_t answered = 0;
    while (!stop) {
      drawer_->poll();
      // Answers the due requests in random order.
      std::vector<wire::ImageRequest> open;
      for (const auto& [place, request] : drawer_->requests)
        if (request.id != 0 && request.sequence <= drawer_->sequence) open.push_back(request);
      std::shuffle(open.begin(), open.end(), random);
      for (const wire::ImageRequest& request : open) {
        if (random() % 3 == 0) continue;
        if (drawer_->answer(request, 1, drawer_->sequence)) ++answered;
        drawer_->requests[request.place].id = 0;
      }
    }
    EXPECT_GE(answered, kRequests);
  });
  std::mt19937 random(5);
  std::map<uint64_t, uint64_t> requested_at;  // of each open request
  uint64_t sent_requests = 0, published = 0;
  while (sent_requests < kRequests || !requested_at.empty()) {
    const size_t depth = sent_requests < kRequests ? random() % 40 : 0;
    while (sent_requests < kRequests && requested_at.size() <= depth) {
      publish();
      ++published;
      requested_at[send_request(small())] = published;
      ++sent_requests;
    }
    const Image image = wait(random() % 2 != 0 ? requested_at.begin()->first : 0);
    if (image == nullptr) break;
    EXPECT_EQ(drawn_sequence(*image), image->sequence);
    EXPECT_GE(image->sequence, requested_at.at(image->request)) << "older than its request";
    EXPECT_LE(image->sequence, published);
    requested_at.erase(image->request);
  }
  stop = true;
  draws.join();
  EXPECT_TRUE(requested_at.empty());
}

TEST_P(ClientImage, LostImagesAreCounted) {
  publish();
  const uint64_t id = send_request(small(FIRE3DV_IMAGE_EVERY_NTH));
  const wire::ImageRequest got = seen(id);
  EXPECT_EQ(got.every, 1u);
  for (const uint64_t number : {1u, 2u, 5u}) answer(got, number, number);
  uint64_t last = 0, lost = 0, taken = 0;
  while (last < 5) {
    const Image image = wait(id);
    ASSERT_NE(image, nullptr);
    EXPECT_GT(image->number, last);
    last = image->number;
    lost += image->lost;
    ++taken;
  }
  EXPECT_EQ(lost + taken, 5u);
}

TEST_P(ClientImage, RefusalIsReportedOnce) {
  const uint64_t id = send_request(small());
  const wire::ImageRequest got = seen(id);
  drawer_->link->send(drawer_->peer,
                      wire::encode(wire::ImageRefused{got.epoch, id, wire::ImageRefusal::unknown_camera,
                                                      "no node is called \"wrist\""}));
  EXPECT_EQ(wait(0, FIRE3DV_ERROR_REFUSED), nullptr);
  EXPECT_NE(std::string(fire3dv_last_error()).find("wrist"), std::string::npos);
  EXPECT_EQ(wait(id, FIRE3DV_ERROR_ARGUMENT), nullptr);
  EXPECT_EQ(wait(0, FIRE3DV_ERROR_STATE), nullptr);
}

TEST_P(ClientImage, CancelTakesBack) {
  const uint64_t id = send_request(small(FIRE3DV_IMAGE_EVERY_NTH));
  const wire::ImageRequest got = seen(id);
  answer(got, 1, 1);
  ASSERT_NE(wait(id), nullptr);
  ASSERT_EQ(fire3dv_cancel_image(stream_.get(), id), FIRE3DV_OK);
  EXPECT_EQ(wait(id, FIRE3DV_ERROR_ARGUMENT), nullptr);
  EXPECT_TRUE(
      drawer_->poll_until([&] { return drawer_->requests[got.place].when == wire::ImageWhen::never; }));
  const uint64_t next = send_request(small());
  EXPECT_EQ(seen(next).place, got.place) << "places are used again";
  answer(got, 2, 2);  // too late
  answer(seen(next), 1, 3);
  const Image image = wait(0);
  ASSERT_NE(image, nullptr);
  EXPECT_EQ(image->request, next);
  EXPECT_EQ(fire3dv_cancel_image(stream_.get(), 12345), FIRE3DV_OK);
}

TEST_P(ClientImage, NewDescriptionKeepsStandingRequests) {
  const uint64_t standing = send_request(small(FIRE3DV_IMAGE_EVERY_NTH)), once = send_request(small());
  seen(once);
  const uint64_t first_epoch = drawer_->epoch;
  ASSERT_EQ(describe(stream_.get(), {"node", "other"}), FIRE3DV_OK);
  nodes_ = 2;
  EXPECT_EQ(wait(once, FIRE3DV_ERROR_REFUSED), nullptr);
  EXPECT_NE(std::string(fire3dv_last_error()).find("described again"), std::string::npos);
  ASSERT_TRUE(drawer_->poll_until([&] { return drawer_->epoch != first_epoch; }));
  const wire::ImageRequest again = seen(standing);
  EXPECT_EQ(again.epoch, drawer_->epoch);
  answer(again, 1, 1);
  EXPECT_NE(wait(standing), nullptr);
}

TEST_P(ClientImage, LateRendererGetsRequest) {
  const uint64_t id = send_request(small(FIRE3DV_IMAGE_EVERY_NTH));
  const wire::ImageRequest got = seen(id);
  for (uint64_t number = 1; number <= 3; ++number) {
    answer(got, number, number);
    ASSERT_NE(wait(id), nullptr);
  }
  const std::string uri = drawer_->link->uri();
  drawer_.reset();
  drawer_.emplace(uri);
  answer(seen(id), 1, 4);  // the next renderer counts its own images
  const Image image = wait(id);
  ASSERT_NE(image, nullptr);
  EXPECT_EQ(drawn_sequence(*image), 4u);
  EXPECT_EQ(image->lost, 0u);
}

TEST_P(ClientImage, ClosedRequestsFreeMemory) {
  std::vector<Image> kept;
  for (int i = 0; i < 40; ++i) {
    const uint64_t id = send_request(small());
    answer(seen(id), 1, static_cast<uint64_t>(i) + 1);
    kept.push_back(wait(id));
    ASSERT_NE(kept.back(), nullptr) << "image " << i;
  }
  for (int i = 0; i < 40; ++i)
    EXPECT_EQ(drawn_sequence(*kept[static_cast<size_t>(i)]), static_cast<uint64_t>(i) + 1);
}

// A program that collects images: the link lends the first ones, and copies once its slots run short.
TEST_P(ClientImage, KeptImagesDoNotEndTheirRequest) {
  const uint64_t id = send_request(small(FIRE3DV_IMAGE_EVERY_NTH));
  const wire::ImageRequest request = seen(id);
  std::vector<Image> kept;
  for (uint64_t i = 1; i <= 40; ++i) {
    publish();
    ASSERT_TRUE(drawer_->poll_until([&] { return drawer_->sequence == i; }));
    ASSERT_TRUE(answer(request, i, i)) << "no slot for image " << i;
    kept.push_back(wait(id));
    ASSERT_NE(kept.back(), nullptr) << "image " << i;
  }
  for (uint64_t i = 1; i <= 40; ++i) EXPECT_EQ(drawn_sequence(*kept[i - 1]), i);
  kept.clear();
  publish();
  EXPECT_TRUE(answer(request, 41, 41));
  EXPECT_NE(wait(id), nullptr);
}

// One thread waits for images, one publishes, two edit.
TEST_P(ClientImage, ThreadsShareTheStream) {
  const uint64_t id = send_request(small(FIRE3DV_IMAGE_EVERY_NTH));
  const wire::ImageRequest request = seen(id);
  constexpr uint64_t kFrames = 300;
  std::atomic<int> faults{0};
  std::vector<std::thread> threads;
  threads.emplace_back([&] {
    for (uint64_t shown = 0; shown < kFrames;) {
      fire3dv_image* image = nullptr;
      if (fire3dv_wait_image(stream_.get(), id, 60'000, &image) != FIRE3DV_OK) return void(++faults);
      shown = image->sequence;
      fire3dv_release_image(&image);
    }
  });
  for (int editor = 0; editor < 2; ++editor)
    threads.emplace_back([&, editor] {
      for (uint64_t i = 0; i < kFrames; ++i) {
        const std::string node = "node " + std::to_string(editor) + " " + std::to_string(i % 50);
        const float rgba[4] = {0.5f, 0.5f, 0.5f, 1};
        if (fire3dv_set_base_color(stream_.get(), node.c_str(), rgba) != FIRE3DV_OK) ++faults;
        fire3dv_status status{};
        status.struct_size = sizeof status;
        if (fire3dv_poll(stream_.get(), &status) != FIRE3DV_OK) ++faults;
      }
    });
  for (uint64_t i = 1; i <= kFrames; ++i) {
    publish();
    ASSERT_TRUE(drawer_->poll_until([&] { return drawer_->sequence == i; }));
    drawer_->answer(request, i, i);
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(faults, 0);
}

TEST_P(ClientImage, CloseEndsWaitsOfOtherThreads) {
  stream_.reset();  // one publisher at a time may have a name of shm://
  for (int run = 0; run < 20; ++run) {
    Stream stream(fire3dv_open(drawer_->link->uri().c_str(), nullptr));
    ASSERT_NE(stream, nullptr) << fire3dv_last_error();
    ASSERT_EQ(describe(stream.get(), {"node"}), FIRE3DV_OK);
    ASSERT_EQ(fire3dv_publish(stream.get(), 0, kPose, 1, 0), FIRE3DV_OK);
    const fire3dv_image_request request = small(FIRE3DV_IMAGE_EVERY_NTH);
    uint64_t id = 0;
    ASSERT_EQ(fire3dv_request_image(stream.get(), &request, &id), FIRE3DV_OK);
    std::atomic<int> begun{0}, closed{0};
    const auto waits = [&](auto&& wait) {
      ++begun;
      if (wait() == FIRE3DV_ERROR_STATE && std::string(fire3dv_last_error()) == "the stream is closed")
        ++closed;
    };
    fire3dv_stream* const raw = stream.get();
    std::thread image_waiter([&] {
      waits([&] {
        fire3dv_image* image = nullptr;
        return fire3dv_wait_image(raw, id, 600'000, &image);
      });
    });
    std::thread ack_waiter([&] { waits([&] { return fire3dv_wait_ack(raw, 1, 600'000); }); });
    while (begun != 2) std::this_thread::yield();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));  // so that both are inside
    stream.reset();
    image_waiter.join();
    ack_waiter.join();
    EXPECT_EQ(closed, 2);
  }
}

TEST_P(ClientImage, UntakenImagesFreeMemory) {
  for (int i = 0; i < 40; ++i) {
    const uint64_t id = send_request(small());
    answer(seen(id), 1, 1);
  }
  const uint64_t id = send_request(small());
  answer(seen(id), 1, 1);
  EXPECT_NE(wait(id), nullptr);
}

TEST_P(ClientImage, NonsenseFromRendererIsDropped) {
  const uint64_t id = send_request(small());
  const wire::ImageRequest got = seen(id);
  const auto fill = [](std::span<std::byte>) {};
  const auto peer = drawer_->peer;
  drawer_->link->send_image(peer, id, wire::encode(wire::Ack{1, 2}), 64, fill);
  drawer_->link->send_image(peer, id + 1, std::vector<std::byte>(100), 64, fill);
  wire::ImageRequest stranger = got;
  stranger.id = 999;
  answer(stranger, 1, 1);
  stranger = got;
  stranger.epoch ^= 1;
  answer(stranger, 1, 1);
  wire::ImageFrame beyond;  // its planes lie beyond the received pixels
  beyond.request = id;
  beyond.number = 1;
  beyond.epoch = got.epoch;
  beyond.intrinsics = got.intrinsics;
  beyond.planes = {{0, wire::ImageFormat::rgba8, 8, 4, 32, 64, 128}};
  beyond.pixel_bytes = 192;
  drawer_->link->send_image(peer, id, wire::encode(beyond), 64, fill);
  drawer_->link->send(peer,
                      wire::encode(wire::ImageRefused{got.epoch ^ 1, id, wire::ImageRefusal::too_many, "x"}));
  // The link keeps the newest message only, so the valid answer follows after the others were read.
  EXPECT_EQ(wait(id, FIRE3DV_ERROR_TIMEOUT, 50), nullptr);
  answer(got, 1, 7);
  const Image image = wait(id);
  ASSERT_NE(image, nullptr);
  EXPECT_EQ(drawn_sequence(*image), 7u);
}

size_t count_lines(const char* file, const char* text) {
  std::ifstream lines(file);
  size_t count = 0;
  for (std::string line; std::getline(lines, line);) count += line.find(text) != std::string::npos;
  return count;
}

size_t count_descriptors() {
  const std::filesystem::directory_iterator files("/proc/self/fd");
  return static_cast<size_t>(std::distance(begin(files), end(files)));
}

// Larger requests replace the shared memory. Images that nobody takes keep none of it.
TEST_P(ClientImage, UntakenImagesKeepNoReplacedMemory) {
  const size_t descriptors = count_descriptors();
  std::vector<uint64_t> untaken;
  for (const uint32_t side : {8u, 32u, 128u, 512u}) {
    fire3dv_image_request request = small();
    request.width = request.height = side;
    for (int i = 0; i < 2; ++i) {
      untaken.push_back(send_request(request));
      ASSERT_TRUE(answer(seen(untaken.back()), 1, 1));
    }
    wait(untaken.back());  // the first one of each size stays
    untaken.pop_back();
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(2100));  // replaced memory is kept for 2 s
  poll(stream_.get());
  EXPECT_LE(count_descriptors(), descriptors + 2);  // of the segment, or of the connection
  EXPECT_LE(count_lines("/proc/self/maps", "(deleted)"), 1u);
  for (const uint64_t id : untaken) {
    const Image image = wait(id);
    ASSERT_NE(image, nullptr);
    EXPECT_EQ(drawn_sequence(*image), 1u);
  }
}

// A renderer that lies: programs copy the size that they have requested.
TEST_P(ClientImage, AnswersToNoRequestAreDropped) {
  publish();
  fire3dv_image_request wanted = small(FIRE3DV_IMAGE_EVERY_NTH);
  wanted.outputs = FIRE3DV_IMAGE_COLOR_SRGB8 | FIRE3DV_IMAGE_BOXES2D;
  const uint64_t id = send_request(wanted);
  const wire::ImageRequest got = seen(id);
  wire::BoxRecord2d box{1, 0, 0, 0, 8, 4, 32, 0};
  uint64_t sent_bytes = 0;  // 0: those of the head
  const auto answer_after = [&](const std::function<void(wire::ImageFrame&)>& lie) {
    wire::ImageFrame frame;
    frame.request = id;
    frame.number = 1;
    frame.epoch = got.epoch;
    frame.sequence = 1;
    frame.intrinsics = got.intrinsics;
    frame.planes = {{0, wire::ImageFormat::rgba8, 8, 4, 32, 0, 128},
                    {7, wire::ImageFormat::box2d, 1, 1, 32, 128, 32}};
    frame.pixel_bytes = 192;
    if (lie) lie(frame);
    return drawer_->link->send_image(drawer_->peer, id, wire::encode(frame),
                                     sent_bytes != 0 ? sent_bytes : frame.pixel_bytes,
                                     [&](std::span<std::byte> pixels) {
                                       if (pixels.size() >= 160) std::memcpy(&pixels[128], &box, sizeof box);
                                     });
  };
  struct Lie {
    const char* why;
    std::function<void(wire::ImageFrame&)> tell;
  };
  const Lie lies[] = {
      {"it has no outputs instead of color_srgb8,boxes2d", [](auto& frame) { frame.planes.clear(); }},
      {"it has color_srgb8 instead of color_srgb8,boxes2d", [](auto& frame) { frame.planes.pop_back(); }},
      {"it has color_srgb8,depth_f32,boxes2d instead of",
       [](auto& frame) {
         frame.planes.insert(frame.planes.begin() + 1, {2, wire::ImageFormat::r32f, 8, 4, 32, 0, 128});
       }},
      {"it has 1 x 1 pixels instead of 8 x 4 pixels",
       [](auto& frame) {
         frame.intrinsics.width = frame.intrinsics.height = 1;
         frame.planes[0] = {0, wire::ImageFormat::rgba8, 1, 1, 4, 0, 4};
       }},
      {"it has another lens", [](auto& frame) { frame.intrinsics.lens.model = wire::LensModel{9}; }},
      {"it has another lens", [](auto& frame) { frame.intrinsics.lens.coefficients[0] = 1; }},
      {"it shows frame 18446744073709551615, but 1 is the newest",
       [](auto& frame) { frame.sequence = UINT64_MAX; }},
      {"it shows frame 2, but 1 is the newest", [](auto& frame) { frame.sequence = 2; }},
      {"it shows frame 0 instead of 1 or a later one", [](auto& frame) { frame.sequence = 0; }},
      {"it has 192 bytes of pixels instead of 256",
       [&](auto& frame) {
         frame.pixel_bytes = 256;
         sent_bytes = 192;
       }},
      {"its boxes are not inside the image", [&](auto&) { box.max_x = 9; }},
      {"it has 33 boxes of 32 pixels",
       [](auto& frame) {
         frame.planes[1] = {7, wire::ImageFormat::box2d, 33, 1, 33 * 32, 128, 33 * 32};
         frame.pixel_bytes = 1216;
       }},
  };
  uint64_t dropped = 0;
  for (const Lie& lie : lies) {
    ASSERT_TRUE(answer_after(lie.tell)) << lie.why;
    EXPECT_TRUE(repeat_until([&] {
      EXPECT_EQ(wait(id, FIRE3DV_ERROR_TIMEOUT, 1), nullptr) << lie.why;
      return poll(stream_.get()).images_dropped > dropped;
    })) << lie.why;
    ++dropped;
    const std::string text = fire3dv_last_error();
    EXPECT_NE(text.find(lie.why), std::string::npos) << text;
    box = {1, 0, 0, 0, 8, 4, 32, 0};
    sent_bytes = 0;
  }
  EXPECT_EQ(poll(stream_.get()).images_dropped, dropped);
  ASSERT_TRUE(answer_after({}));
  const Image image = wait(id);
  ASSERT_NE(image, nullptr) << "the request stays open";
  ASSERT_NE(fire3dv_plane_of(image.get(), FIRE3DV_IMAGE_COLOR_SRGB8), nullptr);
  EXPECT_EQ(fire3dv_plane_of(image.get(), FIRE3DV_IMAGE_DEPTH_F32), nullptr);
  EXPECT_EQ(fire3dv_plane_of(nullptr, FIRE3DV_IMAGE_DEPTH_F32), nullptr);
}

// A lying number of lost images is bounded by the frames that have passed.
TEST_P(ClientImage, LostImagesAreNoMoreThanFrames) {
  publish();
  const uint64_t id = send_request(small(FIRE3DV_IMAGE_EVERY_NTH));
  ASSERT_TRUE(answer(seen(id), UINT64_MAX, 5));
  const Image image = wait(id);
  ASSERT_NE(image, nullptr);
  EXPECT_LE(image->lost, 5u);
}

TEST_P(ClientImage, RequestsBeyondLimitAreRefused) {
  std::vector<uint64_t> ids;
  for (uint32_t i = 0; i < wire::kMaxImageRequests; ++i) ids.push_back(send_request(small()));
  fire3dv_image_request request = small();
  uint64_t id = 0;
  EXPECT_EQ(fire3dv_request_image(stream_.get(), &request, &id), FIRE3DV_ERROR_SYSTEM);
  EXPECT_NE(std::string(fire3dv_last_error()).find("4096"), std::string::npos) << fire3dv_last_error();
  ASSERT_TRUE(drawer_->poll_until([&] { return drawer_->requests.size() == wire::kMaxImageRequests; }));
  for (const auto& [place, one] : drawer_->requests) EXPECT_TRUE(answer(one, 1, 1)) << place;
  for (const uint64_t open : ids) ASSERT_NE(wait(open), nullptr);
}

TEST(ClientImageArguments, ChecksPrecedeSending) {
  Stream stream(fire3dv_open(unique_shm_uri().c_str(), nullptr));
  fire3dv_image_request request = small();
  uint64_t id = 0;
  const auto expect = [&](int code, const char* text) {
    EXPECT_EQ(fire3dv_request_image(stream.get(), &request, &id), code);
    EXPECT_NE(std::string(fire3dv_last_error()).find(text), std::string::npos) << fire3dv_last_error();
    request = small();
  };
  expect(FIRE3DV_ERROR_STATE, "fire3dv_describe");
  ASSERT_EQ(describe(stream.get(), {"node"}), FIRE3DV_OK);
  EXPECT_EQ(fire3dv_request_image(nullptr, &request, &id), FIRE3DV_ERROR_ARGUMENT);
  EXPECT_EQ(fire3dv_request_image(stream.get(), nullptr, &id), FIRE3DV_ERROR_ARGUMENT);
  EXPECT_EQ(fire3dv_request_image(stream.get(), &request, nullptr), FIRE3DV_ERROR_ARGUMENT);
  request.struct_size = 8;
  expect(FIRE3DV_ERROR_ARGUMENT, "struct_size is 8");
  request.width = 0;
  expect(FIRE3DV_ERROR_ARGUMENT, "width is 0");
  request.height = 1u << 30;
  expect(FIRE3DV_ERROR_ARGUMENT, "height");
  request.fx = NAN;
  expect(FIRE3DV_ERROR_ARGUMENT, "fx is nan");
  request.fx = request.fy = 0;
  expect(FIRE3DV_ERROR_ARGUMENT, "names no camera");
  request.far_m = 0.001f;
  expect(FIRE3DV_ERROR_ARGUMENT, "far_m");
  request.when = 5;
  expect(FIRE3DV_ERROR_ARGUMENT, "when is 5");
  request.when = FIRE3DV_IMAGE_RATE;
  expect(FIRE3DV_ERROR_ARGUMENT, "rate_hz is 0");
  request.when = FIRE3DV_IMAGE_EXACTLY;
  expect(FIRE3DV_ERROR_ARGUMENT, "sequence is 0");
  request.outputs = wire::kAmodal;
  expect(FIRE3DV_ERROR_ARGUMENT, "outputs is 16384");
  request.markers = 2;
  expect(FIRE3DV_ERROR_ARGUMENT, "markers is 2");
  request.markers = 1;
  request.outputs = FIRE3DV_IMAGE_DEPTH_F32;
  expect(FIRE3DV_ERROR_ARGUMENT, "markers is set");
  request.f_number = 2;
  expect(FIRE3DV_ERROR_ARGUMENT, "focus_distance_m is 0 beside f_number 2; a lens needs both");
  request.f_number = 2;
  request.focus_distance_m = NAN;
  expect(FIRE3DV_ERROR_ARGUMENT, "focus_distance_m is nan");
  request.lens = 3;
  expect(FIRE3DV_ERROR_ARGUMENT, "lens is 3");
  request.node = "a\nb";
  expect(FIRE3DV_ERROR_ARGUMENT, "node");
  request.width = request.height = 8192;
  expect(FIRE3DV_ERROR_SYSTEM, "8192 x 8192");
  fire3dv_image* image = nullptr;
  EXPECT_EQ(fire3dv_wait_image(stream.get(), 0, 0, &image), FIRE3DV_ERROR_STATE);
  EXPECT_EQ(fire3dv_wait_image(nullptr, 0, 0, &image), FIRE3DV_ERROR_ARGUMENT);
  EXPECT_EQ(fire3dv_wait_image(stream.get(), 0, 0, nullptr), FIRE3DV_ERROR_ARGUMENT);
  fire3dv_release_image(nullptr);
  fire3dv_release_image(&image);
}

TEST(ClientImageArguments, TimeoutNamesUnknownHost) {
  const Stream stream(fire3dv_open("tcp://no-such-host.invalid:7345", nullptr));
  ASSERT_NE(stream, nullptr) << fire3dv_last_error();
  ASSERT_EQ(describe(stream.get(), {"node"}), FIRE3DV_OK);
  const fire3dv_image_request request = small();
  uint64_t id = 0;
  ASSERT_EQ(fire3dv_request_image(stream.get(), &request, &id), FIRE3DV_OK);
  EXPECT_TRUE(repeat_until([&] {
    fire3dv_image* image = nullptr;
    EXPECT_EQ(fire3dv_wait_image(stream.get(), id, 50, &image), FIRE3DV_ERROR_TIMEOUT);
    return std::string(fire3dv_last_error()).find("'no-such-host.invalid'") != std::string::npos;
  })) << fire3dv_last_error();
}

TEST(ClientImageArguments, TimeoutNamesUriWithoutRenderer) {
  for (const char* scheme : {"shm", "tcp"}) {
    const std::string uri = silent_uri(scheme);
    const Stream stream(fire3dv_open(uri.c_str(), nullptr));
    ASSERT_NE(stream, nullptr) << fire3dv_last_error();
    ASSERT_EQ(describe(stream.get(), {"node"}), FIRE3DV_OK);
    const fire3dv_image_request request = small();
    uint64_t id = 0;
    ASSERT_EQ(fire3dv_request_image(stream.get(), &request, &id), FIRE3DV_OK);
    fire3dv_image* image = nullptr;
    EXPECT_EQ(fire3dv_wait_image(stream.get(), id, 1, &image), FIRE3DV_ERROR_TIMEOUT);
    const std::string text = fire3dv_last_error();
    EXPECT_NE(text.find("no renderer is reached: "), std::string::npos) << text;
    EXPECT_NE(text.find("start `fire3dv SCENE --listen " + uri + "`"), std::string::npos) << text;
    if (scheme == std::string("shm")) continue;
    EXPECT_TRUE(repeat_until([&] {
      EXPECT_EQ(fire3dv_wait_image(stream.get(), id, 1, &image), FIRE3DV_ERROR_TIMEOUT);
      return std::string(fire3dv_last_error()).find("Connection refused") != std::string::npos;
    })) << fire3dv_last_error();
    // A wait for a frame says the same.
    const float pose[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    ASSERT_EQ(fire3dv_publish(stream.get(), 0, pose, 1, 0), FIRE3DV_OK);
    EXPECT_EQ(fire3dv_wait_ack(stream.get(), 1, 1), FIRE3DV_ERROR_TIMEOUT);
    EXPECT_NE(std::string(fire3dv_last_error()).find("Connection refused"), std::string::npos);
  }
}

TEST(ClientImageArguments, UdpHasNoImages) {
  Stream stream(fire3dv_open(silent_uri("udp").c_str(), nullptr));
  ASSERT_EQ(describe(stream.get(), {"node"}), FIRE3DV_OK);
  const fire3dv_image_request request = small();
  uint64_t id = 0;
  EXPECT_EQ(fire3dv_request_image(stream.get(), &request, &id), FIRE3DV_ERROR_SYSTEM);
  EXPECT_NE(std::string(fire3dv_last_error()).find("tcp://"), std::string::npos) << fire3dv_last_error();
}

}  // namespace
}  // namespace fire3dv::test
