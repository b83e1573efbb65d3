// Transform trees against tf2::BufferCore of ROS 1 (Debian's libtf2), whose rules ROS 2 has kept:
// composition, interpolation, newest common time, and what can be looked up at all.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "adapters/ros2/tf/frames.h"
#include "tests/unit/adapters/ros2/tf/tf2_oracle.h"

namespace fire3dv::ros2 {
namespace {

constexpr double kTolerance = 1e-6;

class Trees {
 public:
  explicit Trees(unsigned seed) : random_(seed) {}

  int below(int limit) { return std::uniform_int_distribution<int>(0, limit - 1)(random_); }
  double number(double most) { return std::uniform_real_distribution<double>(-most, most)(random_); }

  Transform random_transform() {
    Transform t{{number(5), number(5), number(5)}, {number(1), number(1), number(1), number(1)}};
    t.rotation = normalized(t.rotation);
    return t;
  }

  void insert(int parent, int child, int64_t stamp_ns, bool is_static) {
    const Transform t = random_transform();
    const bool taken = oracle_.set(name(parent), name(child), stamp_ns, t.translation, t.rotation, is_static);
    const Insertion ours =
        buffer_.insert(name(parent), name(child), stamp_ns, t, is_static, 1, ++arrival_ns_);
    EXPECT_EQ(ours == Insertion::accepted, taken) << insertion_text(ours);
  }

  static std::string name(int frame) { return "f" + std::to_string(frame); }

  std::mt19937 random_;
  Tf2Oracle oracle_;
  FrameBuffer buffer_;
  int64_t arrival_ns_ = 0;
};

void expect_equal(const Transform& ours, const Tf2Oracle::Result& theirs) {
  for (size_t i = 0; i < 3; ++i) ASSERT_NEAR(ours.translation[i], theirs.translation[i], kTolerance);
  const std::array<double, 4>& rotation = theirs.rotation;
  double cosine = 0;
  for (size_t i = 0; i < 4; ++i) cosine += ours.rotation[i] * rotation[i];
  for (size_t i = 0; i < 4; ++i)
    ASSERT_NEAR(ours.rotation[i], (cosine < 0 ? -1 : 1) * rotation[i], kTolerance);
}

// True when each frame between `frame` and the top has a transform at this time.
bool has_time(const FrameBuffer& buffer, FrameId frame, FrameId top, int64_t time_ns) {
  while (frame != top) {
    if (buffer.frames()[frame].is_root()) return false;
    const std::optional<FrameSample> sample = FrameBuffer::at(buffer.frames()[frame], time_ns);
    if (!sample) return false;
    frame = sample->parent;
  }
  return true;
}

TEST(Ros2TfOracle, RandomTrees) {
  int compared = 0, common = 0, refused = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    Trees trees(seed);
    const int frames = 3 + trees.below(25);
    std::vector<bool> is_static(static_cast<size_t>(frames));
    for (int child = 1; child < frames; ++child) {
      is_static[static_cast<size_t>(child)] = trees.below(4) == 0;
      if (is_static[static_cast<size_t>(child)]) {
        trees.insert(trees.below(child), child, 1, true);
        continue;
      }
      int parent = trees.below(child);
      int64_t stamp = 100'000'000'000 + trees.below(1'000'000'000);
      for (int samples = 1 + trees.below(12); samples > 0; --samples) {
        if (trees.below(6) == 0) parent = trees.below(child);  // moves to another parent
        trees.insert(parent, child, stamp, false);
        const int64_t step = 1 + trees.below(1'000'000'000);
        // Some arrive late, some twice, some too late.
        if (trees.below(5) == 0)
          trees.insert(parent, child, stamp - 3 * step - trees.below(2) * 12'000'000'000, false);
        if (trees.below(8) == 0) trees.insert(parent, child, stamp, false);
        stamp += step;
      }
    }
    FrameTree tree;
    for (int query = 0; query < 200; ++query) {
      const int target = trees.below(frames), source = trees.below(frames);
      const std::string target_name = Trees::name(target), source_name = Trees::name(source);
      const FrameId fixed = trees.buffer_.find(target_name), frame = trees.buffer_.find(source_name);
      // At the newest common time. There is none if a frame has moved to another parent in between.
      if (const auto theirs = trees.oracle_.look_up(target_name, source_name, 0)) {
        tree.begin(trees.buffer_, fixed, std::nullopt);
        ASSERT_NE(tree.find(frame), nullptr);
        int64_t time_ns = INT64_MAX;
        for (const FrameId moving : tree.moving_frames({frame}))
          time_ns = std::min(time_ns, trees.buffer_.frames()[moving].samples.back().stamp_ns);
        if (time_ns == INT64_MAX) time_ns = target == source ? theirs->stamp_ns : 0;
        ASSERT_EQ(time_ns, theirs->stamp_ns);
        tree.begin(trees.buffer_, fixed, time_ns);
        const Transform* ours = tree.find(frame);
        ASSERT_NE(ours, nullptr);
        expect_equal(*ours, *theirs);
        ++common;
      }
      // At a random time.
      const int64_t time_ns = 99'000'000'000 + trees.below(2'000'000'000) * int64_t{4};
      if (const auto theirs = trees.oracle_.look_up(target_name, source_name, time_ns)) {
        tree.begin(trees.buffer_, fixed, time_ns);
        const Transform* ours = tree.find(frame);
        ASSERT_NE(ours, nullptr);
        expect_equal(*ours, *theirs);
        ++compared;
      } else {
        // Frames are in the order of the tree: frame 0 is above all.
        const FrameId top = trees.buffer_.find("f0");
        EXPECT_FALSE(has_time(trees.buffer_, fixed, top, time_ns) &&
                     has_time(trees.buffer_, frame, top, time_ns));
        ++refused;
      }
    }
  }
  EXPECT_GT(compared, 1000);
  EXPECT_GT(common, 3000);
  EXPECT_GT(refused, 1000);
}

TEST(Ros2TfOracle, RefusesWhatTf2Refuses) {
  const double nan = std::nan("");
  struct Case {
    const char *parent, *child;
    Transform transform;
  };
  const Case cases[] = {
      {"a", "b", {{0, 0, 0}, {0, 0, 0, 1}}},     {"a", "a", {{0, 0, 0}, {0, 0, 0, 1}}},
      {"/a", "a", {{0, 0, 0}, {0, 0, 0, 1}}},    {"", "b", {{0, 0, 0}, {0, 0, 0, 1}}},
      {"a", "", {{0, 0, 0}, {0, 0, 0, 1}}},      {"/", "b", {{0, 0, 0}, {0, 0, 0, 1}}},
      {"a", "b", {{nan, 0, 0}, {0, 0, 0, 1}}},   {"a", "b", {{0, 0, 0}, {0, 0, nan, 1}}},
      {"a", "b", {{0, 0, 0}, {0, 0, 0, 0}}},     {"a", "b", {{0, 0, 0}, {0, 0, 0, 1.004}}},
      {"a", "b", {{0, 0, 0}, {0, 0, 0, 1.006}}}, {"a", "b", {{0, 0, 0}, {0, 0, 0, 0.996}}},
      {"a", "b", {{0, 0, 0}, {0, 0, 0, 0.994}}}, {"/a", "/b", {{0, 0, 0}, {0, 0, 0, -1}}},
  };
  for (const Case& c : cases) {
    Tf2Oracle oracle;
    FrameBuffer buffer;
    const bool theirs =
        oracle.set(c.parent, c.child, 5'000'000'000, c.transform.translation, c.transform.rotation, false);
    const bool ours =
        buffer.insert(c.parent, c.child, 5'000'000'000, c.transform, false, 1, 1) == Insertion::accepted;
    EXPECT_EQ(ours, theirs) << c.parent << " " << c.child << " " << c.transform.rotation[3];
  }
}

}  // namespace
}  // namespace fire3dv::ros2
