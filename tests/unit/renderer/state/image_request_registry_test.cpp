// Test of the image request queue: due times, refusals, and limits per stream.
#include "renderer/state/image_request_registry.h"

#include <gtest/gtest.h>

#include <map>

namespace fire3dv::state {
namespace {

constexpr uint64_t kRequestsEpoch = 77;
constexpr int64_t kMillisecondNs = 1'000'000;

class ImageBookTest : public ::testing::Test {
 protected:
  static wire::ImageRequest request(uint64_t id, wire::ImageWhen when, uint64_t sequence = 0) {
    wire::ImageRequest r;
    r.epoch = kRequestsEpoch;
    r.id = id;
    r.place = static_cast<uint32_t>(id);
    r.intrinsics = {64, 48, 50, 50, 31.5f, 23.5f, 0.01f, 0, {}};
    r.when = when;
    r.sequence = sequence;
    return r;
  }
  // Returns the requests that are due while `sequence` of stream 1 is shown.
  std::vector<uint64_t> due(uint64_t sequence, int64_t now_ns = 0) {
    refused_.clear();
    std::vector<uint64_t> ids;
    const auto shown = [&](RequesterId requester) -> std::optional<ImageRequestRegistry::Shown> {
      if (requester != 1) return {};
      return ImageRequestRegistry::Shown{kRequestsEpoch, sequence, static_cast<int64_t>(sequence) * 10};
    };
    last_.clear();
    for (const ImageDemand& demand : requests_.demands(shown, now_ns, refused_)) {
      const std::vector<ImageRequestRegistry::Due> due =
          requests_.due(demand.requester, *shown(demand.requester), now_ns);
      last_.insert(last_.end(), due.begin(), due.end());
    }
    for (const ImageRequestRegistry::Due& one : last_) requests_.mark_rendered(one);
    for (const ImageRequestRegistry::Due& one : last_) {
      ids.push_back(one.request.id);
      EXPECT_EQ(one.sequence, sequence);
      EXPECT_EQ(one.sim_time_ns, static_cast<int64_t>(sequence) * 10);
    }
    return ids;
  }

  using Ids = std::vector<uint64_t>;
  ImageRequestRegistry requests_;
  std::vector<ImageRequestRegistry::Refused> refused_;
  std::vector<ImageRequestRegistry::Due> last_;
};

wire::ImageRequest batch_of(wire::ImageRequest request, uint32_t worlds, uint32_t views) {
  wire::ImageBatch batch;
  batch.worlds = worlds;
  batch.node_indices = {0};
  batch.poses.resize(worlds);
  batch.world_of_view.resize(views);
  request.when = wire::ImageWhen::batch;
  request.batch = std::move(batch);
  return request;
}

// A batch is one image, due once, of the cost and bytes of all its views.
TEST_F(ImageBookTest, BatchesCountAllViews) {
  const wire::ImageRequest single = request(5, wire::ImageWhen::once);
  const wire::ImageRequest batch = batch_of(single, 3, 1000);
  EXPECT_EQ(requests_.cost(batch), 1000 * requests_.cost(single));
  EXPECT_EQ(drawn_bytes(batch), 1000 * drawn_bytes(single));
  ASSERT_FALSE(requests_.add(1, batch));
  ASSERT_FALSE(requests_.add(1, batch_of(single, 3, 1000))) << "links may deliver a message twice";
  ASSERT_TRUE(requests_.add(1, batch_of(single, 4, 1000))) << "an id is used once";
  EXPECT_EQ(due(0), Ids{5}) << "without a published frame";
  EXPECT_EQ(due(1), Ids{});
}

TEST_F(ImageBookTest, BatchesAreRefusedWhatTheyLack) {
  ImageAbilities abilities;
  abilities.outputs = wire::kRequestableOutputs;
  abilities.lenses = abilities.thin_lenses = true;
  ImageRequestRegistry requests(abilities);
  const auto refusal = [&](auto change) {
    wire::ImageRequest asked = batch_of(request(5, wire::ImageWhen::once), 2, 2);
    change(asked);
    const auto refused = requests.add(1, asked);
    return refused ? refused->answer.message : std::string("accepted");
  };
  EXPECT_EQ(refusal([](auto& r) { r.outputs = wire::kColorSrgb8 | wire::kMotion; }),
            "the output motion is not available in batches; request single images");
  EXPECT_NE(refusal([](auto& r) { r.outputs = wire::kBoxes2d; }).find("boxes2d"), std::string::npos);
  EXPECT_NE(refusal([](auto& r) { r.intrinsics.lens.model = wire::LensModel::fisheye; }).find("lens"),
            std::string::npos);
  EXPECT_NE(
      refusal([](auto& r) { r.intrinsics.f_number = r.intrinsics.focus_distance_m = 1; }).find("depth of"),
      std::string::npos);
  EXPECT_NE(refusal([](auto& r) { r.markers = true; }).find("markers"), std::string::npos);
  EXPECT_NE(refusal([](auto& r) { r.complete = true; }).find("complete"), std::string::npos);
  EXPECT_NE(refusal([](auto& r) {
              wire::ImageBatch many = *r.batch;
              many.world_of_view.resize(65'536);
              r.batch = std::move(many);
            }).find("65536 views have"),
            std::string::npos);
  EXPECT_EQ(refusal([](auto&) {}), "accepted");

  // One view is limited as a single image.
  const wire::ImageRequest single = request(5, wire::ImageWhen::once);
  abilities.max_pixel_bytes = drawn_bytes(single);
  ImageRequestRegistry exact(abilities);
  EXPECT_FALSE(exact.add(1, batch_of(single, 2, 2)));
  --abilities.max_pixel_bytes;
  ImageRequestRegistry less(abilities);
  const auto refused = less.add(1, batch_of(single, 2, 2));
  ASSERT_TRUE(refused);
  EXPECT_NE(refused->answer.message.find("an image of 64 x 48 has"), std::string::npos)
      << refused->answer.message;
}

TEST_F(ImageBookTest, BatchesAreChargedForTheirPoses) {
  PeerLimits limits;
  limits.of(Resource::pose_bytes) = 100 * sizeof(wire::Affine3x4);
  const auto pool = BudgetPool::create(limits);
  const std::shared_ptr<PeerBudget> peer = pool->add_peer("batches");
  const auto refused = requests_.add(1, batch_of(request(5, wire::ImageWhen::once), 101, 1), peer);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->over, Resource::pose_bytes);
  ASSERT_FALSE(requests_.add(1, batch_of(request(6, wire::ImageWhen::once), 50, 1), peer));
  EXPECT_GE(peer->used(Resource::pose_bytes), 50 * sizeof(wire::Affine3x4));
  EXPECT_EQ(due(0), Ids{6});
  EXPECT_EQ(peer->used(Resource::pose_bytes), 0u);
}

// An image that was drawn and not sent is due again, with its number.
TEST_F(ImageBookTest, UndrawnImagesAreDueAgain) {
  wire::ImageRequest each = request(6, wire::ImageWhen::every_nth);
  each.every = 2;
  ASSERT_FALSE(requests_.add(1, request(5, wire::ImageWhen::once)));
  ASSERT_FALSE(requests_.add(1, each));
  EXPECT_EQ(due(3), (Ids{5, 6}));
  const std::vector<ImageRequestRegistry::Due> undrawn = last_;
  EXPECT_EQ(due(3), Ids{});
  for (const ImageRequestRegistry::Due& one : undrawn) requests_.mark_undrawn(one);
  EXPECT_EQ(due(3), (Ids{5, 6}));
  for (const ImageRequestRegistry::Due& one : last_) EXPECT_EQ(one.number, 1u);
  EXPECT_EQ(due(4), Ids{});
  EXPECT_EQ(due(5), Ids{6});
  EXPECT_EQ(last_[0].number, 2u);
  const ImageRequestRegistry::Due last = last_[0];
  requests_.remove_all(1);
  requests_.mark_undrawn(last);
  EXPECT_EQ(due(6), Ids{}) << "the requester is gone";
}

TEST_F(ImageBookTest, WithdrawnImagesAreNotDueAgain) {
  ASSERT_FALSE(requests_.add(1, request(5, wire::ImageWhen::every_nth)));
  ASSERT_FALSE(requests_.add(1, request(6, wire::ImageWhen::every_nth)));
  EXPECT_EQ(due(3), (Ids{5, 6}));
  const std::vector<ImageRequestRegistry::Due> undrawn = last_;
  ASSERT_FALSE(requests_.add(1, request(5, wire::ImageWhen::never)));
  for (const ImageRequestRegistry::Due& one : undrawn) requests_.mark_undrawn(one);
  EXPECT_EQ(due(3), Ids{6});
}

TEST_F(ImageBookTest, OnceIsFirstFrameAfter) {
  ASSERT_FALSE(requests_.add(1, request(5, wire::ImageWhen::once, 3)));
  EXPECT_EQ(due(2), Ids{});
  EXPECT_EQ(due(4), Ids{5});
  EXPECT_EQ(last_[0].number, 1u);
  EXPECT_EQ(due(5), Ids{});
  EXPECT_EQ(requests_.count(), 0u);
}

TEST_F(ImageBookTest, UnsequencedOnceNeedsNothing) {
  ASSERT_FALSE(requests_.add(1, request(5, wire::ImageWhen::once)));
  EXPECT_EQ(due(0), Ids{5});
}

TEST_F(ImageBookTest, EveryNthCountsPublished) {
  wire::ImageRequest r = request(1, wire::ImageWhen::every_nth, 2);
  r.every = 3;
  ASSERT_FALSE(requests_.add(1, r));
  std::vector<uint64_t> made;
  for (const uint64_t sequence : {0u, 1u, 2u, 2u, 3u, 4u, 5u, 9u, 10u, 12u})
    if (!due(sequence).empty()) made.push_back(sequence);
  EXPECT_EQ(made, (std::vector<uint64_t>{2, 5, 9, 12}));
  EXPECT_EQ(last_[0].number, 4u);
}

TEST_F(ImageBookTest, RateUsesRenderersClock) {
  wire::ImageRequest r = request(1, wire::ImageWhen::rate);
  r.rate_hz = 100;
  ASSERT_FALSE(requests_.add(1, r));
  EXPECT_EQ(due(1, 0), Ids{1});
  EXPECT_EQ(due(2, 9 * kMillisecondNs), Ids{});
  EXPECT_EQ(due(3, 10 * kMillisecondNs), Ids{1});
  EXPECT_EQ(due(3, 40 * kMillisecondNs), Ids{}) << "the same frame twice";
  EXPECT_EQ(due(4, 40 * kMillisecondNs), Ids{1});
}

TEST_F(ImageBookTest, ExactlyOrNever) {
  ASSERT_FALSE(requests_.add(1, request(1, wire::ImageWhen::exactly, 5)));
  ASSERT_FALSE(requests_.add(1, request(2, wire::ImageWhen::exactly, 7)));
  EXPECT_EQ(due(4), Ids{});
  EXPECT_EQ(due(5), Ids{1});
  EXPECT_TRUE(refused_.empty());
  EXPECT_EQ(due(8), Ids{});
  ASSERT_EQ(refused_.size(), 1u);
  EXPECT_EQ(refused_[0].answer.request, 2u);
  EXPECT_EQ(refused_[0].answer.reason, wire::ImageRefusal::overtaken);
  EXPECT_EQ(requests_.count(), 0u);
}

TEST_F(ImageBookTest, PlaceHasOneRequest) {
  ASSERT_FALSE(requests_.add(1, request(1, wire::ImageWhen::every_nth)));
  wire::ImageRequest other = request(2, wire::ImageWhen::every_nth);
  other.place = 1;
  ASSERT_FALSE(requests_.add(1, other));
  EXPECT_EQ(due(1), Ids{2});
  ASSERT_FALSE(requests_.add(1, other)) << "a link may repeat it";
  EXPECT_EQ(due(1), Ids{}) << "and that begins nothing anew";
  other.when = wire::ImageWhen::never;
  ASSERT_FALSE(requests_.add(1, other));
  EXPECT_EQ(requests_.count(), 0u);
}

TEST_F(ImageBookTest, StreamsAreApart) {
  ASSERT_FALSE(requests_.add(1, request(1, wire::ImageWhen::once)));
  ASSERT_FALSE(requests_.add(2, request(1, wire::ImageWhen::once)));
  EXPECT_EQ(due(1), Ids{1});
  EXPECT_EQ(requests_.count(), 1u) << "of the other stream nothing is shown";
  requests_.remove_all(2);
  EXPECT_EQ(requests_.count(), 0u);
}

TEST_F(ImageBookTest, EarlierEpochIsNeverDue) {
  wire::ImageRequest old = request(1, wire::ImageWhen::once);
  old.epoch = kRequestsEpoch - 1;
  ASSERT_FALSE(requests_.add(1, old));
  EXPECT_EQ(due(1), Ids{});
}

TEST_F(ImageBookTest, UnmadeImageIsRefused) {
  const auto expect_refused = [&](const wire::ImageRequest& r, wire::ImageRefusal reason, const char* text) {
    const auto refused = requests_.add(1, r);
    ASSERT_TRUE(refused);
    EXPECT_EQ(refused->answer.request, r.id);
    EXPECT_EQ(refused->answer.epoch, kRequestsEpoch);
    EXPECT_EQ(refused->answer.reason, reason);
    EXPECT_NE(refused->answer.message.find(text), std::string::npos) << refused->answer.message;
  };
  wire::ImageRequest r = request(1, wire::ImageWhen::once);
  r.outputs = wire::kColorSrgb8 | 1u << 20;
  expect_refused(r, wire::ImageRefusal::not_supported, "bit 20");
  r = request(1, static_cast<wire::ImageWhen>(9));
  expect_refused(r, wire::ImageRefusal::not_supported, "when is 9");
  r = request(1, wire::ImageWhen::once);
  r.intrinsics.lens.model = static_cast<wire::LensModel>(3);
  expect_refused(r, wire::ImageRefusal::not_supported, "lens 3");
  r = request(1, wire::ImageWhen::once);
  r.intrinsics.width = r.intrinsics.height = wire::kMaxRequestedImageSide;
  expect_refused(r, wire::ImageRefusal::too_large, "8192 x 8192");
  EXPECT_EQ(requests_.count(), 0u);
  EXPECT_EQ(requests_.refused(), 4u);
  requests_ = ImageRequestRegistry({.outputs = wire::kBoxes2d});
  r.outputs = wire::kBoxes2d;  // boxes are computed from labels of the same size
  r.intrinsics.width = r.intrinsics.height = wire::kMaxRequestedImageSide;
  expect_refused(r, wire::ImageRefusal::too_large, "8192 x 8192");
}

TEST_F(ImageBookTest, RefusedRequestFreesSlot) {
  ASSERT_FALSE(requests_.add(1, request(1, wire::ImageWhen::every_nth)));
  wire::ImageRequest bad = request(2, wire::ImageWhen::once);
  bad.place = 1;
  bad.outputs = 1u << 31;
  ASSERT_TRUE(requests_.add(1, bad));
  EXPECT_EQ(due(1), Ids{});
}

TEST_F(ImageBookTest, IdIsUsedOnce) {
  ASSERT_FALSE(requests_.add(1, request(1, wire::ImageWhen::every_nth)));
  EXPECT_FALSE(requests_.add(1, request(1, wire::ImageWhen::every_nth))) << "a link may say it twice";
  wire::ImageRequest other = request(1, wire::ImageWhen::every_nth);
  other.intrinsics.width = wire::kMaxRequestedImageSide;
  const auto refused = requests_.add(1, other);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->answer.reason, wire::ImageRefusal::bad_request);
  EXPECT_EQ(due(1), Ids{1});
  EXPECT_EQ(last_[0].request.intrinsics.width, 64u);
}

TEST_F(ImageBookTest, StreamsImagesAreBounded) {
  const auto sized = [&](uint64_t id, uint32_t side) {
    wire::ImageRequest r = request(id, wire::ImageWhen::every_nth);
    r.intrinsics.width = r.intrinsics.height = side;
    return r;
  };
  for (uint64_t id = 1; id <= 4; ++id) ASSERT_FALSE(requests_.add(1, sized(id, id % 2 == 0 ? 64 : 32)));
  EXPECT_EQ(due(1), (Ids{1, 3, 2, 4}));
  uint64_t id = 5;
  while (id < 100 && !requests_.add(1, sized(id, 4096))) ++id;
  EXPECT_GT(id, 10u);
  EXPECT_LT(id, 100u);
  EXPECT_FALSE(requests_.add(2, sized(1, 4096))) << "one stream does not take another's room";
  EXPECT_FALSE(requests_.add(1, sized(id, 64))) << "small ones still fit";
}

TEST_F(ImageBookTest, ImagesStayDue) {
  ASSERT_FALSE(requests_.add(1, request(1, wire::ImageWhen::once)));
  ASSERT_FALSE(requests_.add(1, request(2, wire::ImageWhen::exactly, 5)));
  ASSERT_FALSE(requests_.add(1, request(3, wire::ImageWhen::every_nth)));
  const auto due_of = [&](uint64_t sequence) {
    Ids ids;
    for (const ImageRequestRegistry::Due& one : last_ = requests_.due(1, {kRequestsEpoch, sequence, 0}, 0)) {
      ids.push_back(one.request.id);
      EXPECT_EQ(one.sequence, sequence) << "the tag names the frame that is shown now";
    }
    return ids;
  };
  EXPECT_EQ(due_of(5), (Ids{1, 2, 3}));
  requests_.mark_rendered(last_[2]);
  EXPECT_EQ(due_of(5), (Ids{1, 2}));
  EXPECT_EQ(due_of(6), (Ids{1, 3})) << "frame 5 of request 2 is not shown any more";
  EXPECT_EQ(last_[1].number, 2u);
  requests_.mark_rendered(last_[0]);
  EXPECT_EQ(due_of(6), Ids{3});
  EXPECT_EQ(due(6), Ids{3});
  ASSERT_EQ(refused_.size(), 1u) << "request 2 is overtaken";
  EXPECT_EQ(refused_[0].answer.request, 2u);
}

// A turn may end before all images are drawn: those that wait longest are the first of the next one.
TEST_F(ImageBookTest, ImagesThatWaitLongestAreFirst) {
  for (uint64_t id = 1; id <= 4; ++id) {
    wire::ImageRequest r = request(id, wire::ImageWhen::every_nth);
    r.intrinsics.width = id == 4 ? 16 : 64;
    r.every = 1;
    ASSERT_FALSE(requests_.add(1, r));
  }
  const auto draw_two = [&](uint64_t sequence, int64_t now_ns) {
    Ids ids;
    for (const auto& one : requests_.due(1, {kRequestsEpoch, sequence, 0}, now_ns)) {
      if (ids.size() == 2) break;
      ids.push_back(one.request.id);
      requests_.mark_rendered(one);
    }
    return ids;
  };
  EXPECT_EQ(draw_two(1, 10), (Ids{4, 1})) << "the small one is a group of its own";
  EXPECT_EQ(draw_two(2, 20), (Ids{2, 3}));
  EXPECT_EQ(draw_two(3, 30), (Ids{4, 1}));
}

TEST_F(ImageBookTest, DemandCostsDueImages) {
  ASSERT_FALSE(requests_.add(1, request(1, wire::ImageWhen::once)));
  ASSERT_FALSE(requests_.add(1, request(2, wire::ImageWhen::once)));
  ASSERT_FALSE(requests_.add(1, request(3, wire::ImageWhen::once, 9)));
  const auto shown = [](RequesterId) { return ImageRequestRegistry::Shown{kRequestsEpoch, 1, 0}; };
  const std::vector<ImageDemand> demands = requests_.demands(shown, 0, refused_);
  ASSERT_EQ(demands.size(), 1u);
  EXPECT_EQ(demands[0].cost, 2 * image_cost(64, 48));
  EXPECT_EQ(demands[0].first, image_cost(64, 48));
}

TEST_F(ImageBookTest, MemoryOfDrawingFitsTheBudget) {
  PeerLimits limits;
  limits.of(Resource::gpu_bytes) = 1000;
  const auto budget = BudgetPool::create(limits)->add_peer("peer");
  ASSERT_FALSE(requests_.add(1, request(5, wire::ImageWhen::every_nth), budget));
  ASSERT_EQ(due(1), Ids{5});
  EXPECT_TRUE(requests_.check_memory(last_[0], 1000).ok());
  EXPECT_EQ(budget->used(Resource::gpu_bytes), 0u) << "images are drawn one after the other";
  const Result<void> fits = requests_.check_memory(last_[0], 1001);
  ASSERT_FALSE(fits.ok());
  EXPECT_NE(fits.error().message.find("--peer-limit gpu-bytes=VALUE"), std::string::npos);
  ASSERT_TRUE(budget->try_take(Resource::gpu_bytes, 500)) << "content";
  EXPECT_FALSE(requests_.check_memory(last_[0], 501).ok());
}

// Planes that outputs follow from count, and the depth that occlusion keeps for the next image.
TEST_F(ImageBookTest, SourcesOfOutputsAreCharged) {
  ImageAbilities abilities;
  abilities.outputs = wire::kRequestableOutputs;
  ImageRequestRegistry registry(abilities);
  const auto budget = BudgetPool::create(PeerLimits{})->add_peer("peer");
  const uint64_t plane = uint64_t{4} * 64 * 48;
  const auto charged = [&](uint64_t id, uint32_t outputs, wire::ImageWhen when) {
    wire::ImageRequest r = request(id, when);
    r.outputs = outputs;
    const uint64_t before = budget->used(Resource::request_bytes);
    EXPECT_FALSE(registry.add(1, r, budget));
    return budget->used(Resource::request_bytes) - before;
  };
  EXPECT_EQ(charged(1, wire::kBoxes2d, wire::ImageWhen::every_nth), plane);
  EXPECT_EQ(charged(2, wire::kOcclusionU32, wire::ImageWhen::once), 2 * plane);
  EXPECT_EQ(charged(3, wire::kOcclusionU32, wire::ImageWhen::every_nth), 3 * plane);
  EXPECT_EQ(charged(4, wire::kOcclusionU32 | wire::kDepthF32, wire::ImageWhen::every_nth), 3 * plane);
  wire::ImageRequest files_only = request(5, wire::ImageWhen::once);
  files_only.outputs = wire::kAmodal | wire::kDepthF32;
  const auto refused = registry.add(1, files_only, budget);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->answer.reason, wire::ImageRefusal::not_supported);
  EXPECT_NE(refused->answer.message.find("the output amodal; ask for"), std::string::npos)
      << refused->answer.message;
}

TEST_F(ImageBookTest, BudgetBoundsOpenRequests) {
  PeerLimits limits;
  ASSERT_TRUE(set_limit("requests=3", limits).ok());
  ASSERT_TRUE(set_limit("request-bytes=40KiB", limits).ok());
  const auto pool = BudgetPool::create(limits);
  const auto budget = pool->add_peer("greedy"), other = pool->add_peer("other");
  const auto ask = [&](RequesterId requester, uint64_t id, uint32_t side, const auto& charged) {
    wire::ImageRequest r = request(id, wire::ImageWhen::every_nth);
    r.intrinsics.width = r.intrinsics.height = side;
    return requests_.add(requester, r, charged);
  };
  for (uint64_t id = 1; id <= 3; ++id) ASSERT_FALSE(ask(1, id, 32, budget));
  EXPECT_EQ(budget->used(Resource::requests), 3u);
  EXPECT_EQ(budget->used(Resource::request_bytes), 3u * 4 * 32 * 32);
  const auto fourth = ask(1, 4, 32, budget);
  ASSERT_TRUE(fourth);
  EXPECT_EQ(fourth->answer.reason, wire::ImageRefusal::too_many);
  EXPECT_EQ(fourth->over, Resource::requests);
  EXPECT_NE(fourth->answer.message.find("--peer-limit requests="), std::string::npos)
      << fourth->answer.message;
  EXPECT_FALSE(ask(2, 1, 32, other)) << "another peer has a budget of its own";
  requests_.remove(1, 3);
  const auto large = ask(1, 5, 128, budget);
  ASSERT_TRUE(large);
  EXPECT_EQ(large->over, Resource::request_bytes);
  EXPECT_NE(large->answer.message.find("--peer-limit request-bytes="), std::string::npos)
      << large->answer.message;
  EXPECT_EQ(budget->used(Resource::requests), 2u) << "a refused request is not charged";
  EXPECT_EQ(budget->refused(Resource::requests), 1u);
  wire::ImageRequest back = request(2, wire::ImageWhen::never);
  ASSERT_FALSE(requests_.add(1, back, budget));
  EXPECT_EQ(budget->used(Resource::requests), 1u);
  requests_.remove_all(1);
  EXPECT_EQ(budget->used(Resource::requests), 0u);
  EXPECT_EQ(budget->used(Resource::request_bytes), 0u);
}

}  // namespace
}  // namespace fire3dv::state
