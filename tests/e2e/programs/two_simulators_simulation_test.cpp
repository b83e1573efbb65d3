// Tests of the simulations of examples/two_simulators: the motion of the heap and of the carousel, each
// within its own region.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "examples/two_simulators/heap.h"
#ifdef FIRE3DV_HAS_MUJOCO
#include "examples/two_simulators/carousel.h"
#include "examples/two_simulators/carousel_model.h"
#endif

namespace two_simulators {
namespace {

examples::Vec3 place(const Simulator& simulator, size_t body) {
  const float* pose = &simulator.poses()[body * 12];
  return {pose[3], pose[7], pose[11]};
}

void expect_finite(const Simulator& simulator) {
  for (const float element : simulator.poses()) ASSERT_TRUE(std::isfinite(element));
}

TEST(Heap, StirredBodiesStayInTray) {
  Heap heap;
  const std::vector<float> first = heap.poses();
  ASSERT_EQ(first.size(), heap.names().size() * 12);
  EXPECT_EQ(std::set<std::string>(heap.names().begin(), heap.names().end()).size(), heap.names().size());
  float farthest_cm = 0, lowest_cm = 1;
  size_t moved = 0;
  int steps = 1;
  for (; heap.step(); ++steps) {
    expect_finite(heap);
    moved = 0;
    for (size_t body = 0; body < heap.names().size(); ++body) {
      const examples::Vec3 at = place(heap, body);
      farthest_cm = std::max(farthest_cm, std::hypot(at.x, at.y));
      lowest_cm = std::min(lowest_cm, at.z);
      moved += std::hypot(at.x - first[body * 12 + 3], at.y - first[body * 12 + 7]) > 3;
    }
    if (steps == 120) {
      EXPECT_EQ(moved, 0u) << "before the blade turns, all stands";
    }
  }
  EXPECT_EQ(steps, 2400) << "a cycle";
  EXPECT_GT(moved, heap.names().size() / 2) << "hardly anything was stirred";
  EXPECT_LT(farthest_cm, 31) << "something left the tray";
  EXPECT_GT(lowest_cm, 0) << "something fell through";
  EXPECT_EQ(heap.poses(), first) << "a cycle begins as the one before did";
}

#ifdef FIRE3DV_HAS_MUJOCO
TEST(Carousel, SwingsOutAndComesToRest) {
  std::string error;
  const std::unique_ptr<CarouselModel> carousel = CarouselModel::make(&error);
  ASSERT_NE(carousel, nullptr) << error;
  const std::vector<CarouselBody> bodies = carousel_bodies();
  ASSERT_EQ(bodies.size(), carousel->names().size());
  std::vector<size_t> gondolas;
  for (size_t body = 0; body < bodies.size(); ++body) {
    EXPECT_EQ(carousel->names()[body], bodies[body].name);
    const examples::Vec3 off = place(*carousel, body) - bodies[body].at_m;
    EXPECT_LT(std::sqrt(dot(off, off)), 1e-5f)
        << bodies[body].name << " does not begin where the scene has it";
    for (int chain = 0; chain < kChains; ++chain)
      if (bodies[body].name == gondola_name(chain)) gondolas.push_back(body);
  }
  ASSERT_EQ(gondolas.size(), static_cast<size_t>(kChains));
  const float hangs_at = place(*carousel, gondolas[0]).z;
  float highest = 0, lowest = 1, widest = 0;
  for (int step = 0; step < 9 * 240; ++step) {
    ASSERT_TRUE(carousel->step());
    expect_finite(*carousel);
    for (const size_t body : gondolas) {
      const examples::Vec3 at = place(*carousel, body);
      highest = std::max(highest, at.z);
      lowest = std::min(lowest, at.z);
      widest = std::max(widest, std::hypot(at.x, at.y));
    }
  }
  EXPECT_GT(widest, kArm_m + 0.10f) << "no gondola swung out";
  EXPECT_LT(widest, kArm_m + 0.21f) << "a chain came apart";
  EXPECT_GT(highest, hangs_at + 0.05f);
  EXPECT_GT(lowest, hangs_at - 0.01f) << "a chain was stretched";
  for (int step = 0; step < 9 * 240; ++step) carousel->step();
  for (const size_t body : gondolas) EXPECT_LT(place(*carousel, body).z, hangs_at + 0.02f) << "still turning";
}
#endif

}  // namespace
}  // namespace two_simulators
