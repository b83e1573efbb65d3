// Tests of the bullet_arm simulation: the scripted sweep and grip succeed, and runs are deterministic per
// seed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "examples/bullet_arm/arm.h"
#include "examples/bullet_arm/simulation.h"

namespace bullet_arm {
namespace {

constexpr uint64_t kSeed = 7;
constexpr double kRate_hz = 240;

struct Track {
  std::vector<float> first, last;
  std::set<size_t> moved_early;  // before the sweep, except for bodies that the arm touches on purpose
  float lowest_m = 1;
  float farthest_m = 0;
  uint64_t hash = 0;
};

bool starts_with(const std::string& text, const char* prefix) {
  return text.rfind(prefix, 0) == 0;
}

float distance(const std::vector<float>& a, const std::vector<float>& b, size_t body) {
  const float* p = &a[body * 12];
  const float* q = &b[body * 12];
  return std::hypot(p[3] - q[3], p[7] - q[7], p[11] - q[11]);
}

Track run(Simulation& simulation, uint64_t steps) {
  Track track;
  track.first = simulation.poses();
  PoseHash hash;
  hash.add(simulation.poses());
  for (uint64_t step = 1; step <= steps; ++step) {
    simulation.step();
    hash.add(simulation.poses());
    for (size_t i = 0; i < simulation.names().size(); ++i) {
      const float* pose = &simulation.poses()[i * 12];
      for (size_t k = 0; k < 12; ++k) EXPECT_TRUE(std::isfinite(pose[k]));
      track.lowest_m = std::min(track.lowest_m, pose[11]);
      track.farthest_m = std::max(track.farthest_m, std::hypot(pose[3], pose[7]));
      const std::string& name = simulation.names()[i];
      const bool stacked =
          starts_with(name, "block_") || starts_with(name, "can_") || starts_with(name, "plank_");
      if (step == 1000 && stacked && distance(track.first, simulation.poses(), i) > 0.02f)
        track.moved_early.insert(i);
    }
  }
  track.last = simulation.poses();
  track.hash = hash.value();
  return track;
}

TEST(BulletArm, ScriptPlaysOut) {
  Simulation simulation(kSeed, kRate_hz);
  const auto steps = static_cast<uint64_t>(kScriptSeconds * kRate_hz);
  const Track track = run(simulation, steps);
  EXPECT_EQ(simulation.sim_time_ns(), 8'000'000'000);

  std::map<std::string, int> displaced;  // by kind
  int all = 0, fallen_dominoes = 0, dominoes = 0;
  for (size_t i = kArmNames.size(); i < simulation.names().size(); ++i) {
    const std::string& name = simulation.names()[i];
    const std::string kind = name.substr(0, name.rfind('_'));
    if (distance(track.first, track.last, i) > 0.05f) ++displaced[kind], ++all;
    if (kind == "domino") {
      ++dominoes;
      if (track.last[i * 12 + 10] < 0.8f) ++fallen_dominoes;  // Z component of the body's up axis
    }
  }
  EXPECT_TRUE(track.moved_early.empty())
      << simulation.names()[*track.moved_early.begin()] << " fell by itself";
  EXPECT_GE(all, 60);
  EXPECT_GE(displaced["block"], 10) << "the tower still stands";
  EXPECT_GE(displaced["can"], 5) << "the cans still stand";
  EXPECT_GE(displaced["box"], 5) << "the wall still stands";
  EXPECT_EQ(fallen_dominoes, dominoes);
  EXPECT_GE(dominoes, 30);
  EXPECT_GT(track.lowest_m, -0.01f) << "something fell through the floor";
  EXPECT_LT(track.farthest_m, 4.0f) << "something left the scene";
  // The arm returns to its start pose.
  for (size_t i = 0; i < kArmNames.size(); ++i)
    EXPECT_LT(distance(track.first, track.last, i), 0.02f) << kArmNames[i];
}

TEST(BulletArm, GripsAndCarriesTheBox) {
  Simulation simulation(kSeed, kRate_hz);
  size_t box = 0;
  for (size_t i = 0; i < simulation.names().size(); ++i) {
    if (simulation.names()[i] == "box_000") box = i;
  }
  ASSERT_GT(box, 0u);
  const float rest_m = simulation.poses()[box * 12 + 11];
  while (simulation.sim_time_ns() < 1'950'000'000) simulation.step();
  EXPECT_GT(simulation.poses()[box * 12 + 11], rest_m + 0.1f);
}

// Velocities are those of the positions, and the motors keep near their targets.
TEST(BulletArm, JointsMoveAtTheirVelocities) {
  Simulation simulation(kSeed, kRate_hz);
  double largest = 0;
  std::vector<JointState> before = simulation.joints();
  ASSERT_EQ(before.size(), static_cast<size_t>(kJoints));
  EXPECT_STREQ(before[0].name, "turret");
  for (int step = 0; step < 200; ++step) {
    simulation.step();
    const std::vector<JointState> now = simulation.joints();
    const JointTargets targets =
        joint_targets(static_cast<float>(static_cast<double>(simulation.steps()) / kRate_hz));
    for (size_t i = 0; i < now.size(); ++i) {
      EXPECT_EQ(now[i].slides, i >= kFirstFinger);
      EXPECT_NEAR((now[i].position - before[i].position) * kRate_hz, now[i].velocity, 1e-2) << now[i].name;
      if (!now[i].slides) {
        EXPECT_NEAR(now[i].position, targets.position[i], 0.1) << now[i].name;
      }
      largest = std::max(largest, std::abs(now[i].velocity));
    }
    before = now;
  }
  EXPECT_GT(largest, 0.5) << "the arm rests";
}

TEST(BulletArm, SeedDeterminesPoses) {
  Simulation first(kSeed, kRate_hz), second(kSeed, kRate_hz), other(kSeed + 1, kRate_hz), slower(kSeed, 239);
  const uint64_t hash = run(first, 400).hash;
  EXPECT_EQ(hash, run(second, 400).hash);
  EXPECT_NE(hash, run(other, 400).hash);
  EXPECT_NE(hash, run(slower, 400).hash);
}

// The floor bears every standing domino, at points on the floor below it.
TEST(BulletArm, ContactsAreWhereBodiesStand) {
  Simulation simulation(kSeed, kRate_hz);
  EXPECT_TRUE(simulation.contact_points().empty()) << "before the first step";
  for (int step = 0; step < 120; ++step) simulation.step();
  const auto points = simulation.contact_points();
  for (const auto& point : points) EXPECT_GT(point[2], -0.01f) << "below the floor";
  int dominoes = 0;
  for (size_t i = 0; i < simulation.names().size(); ++i) {
    if (!starts_with(simulation.names()[i], "domino_")) continue;
    ++dominoes;
    const float* pose = &simulation.poses()[i * 12];
    const auto below = std::count_if(points.begin(), points.end(), [&](const auto& point) {
      const bool is_under = std::hypot(point[0] - pose[3], point[1] - pose[7]) < 0.036f;  // half diagonal
      return is_under && std::fabs(point[2]) < 0.003f;
    });
    EXPECT_GE(below, 2) << simulation.names()[i] << " stands on nothing";
    EXPECT_LE(below, 4) << simulation.names()[i];
  }
  EXPECT_GE(dominoes, 30);
}

TEST(BulletArm, NodeNamesAreUnique) {
  const Simulation simulation(kSeed, kRate_hz);
  const std::set<std::string> names(simulation.names().begin(), simulation.names().end());
  EXPECT_EQ(names.size(), simulation.names().size());
  EXPECT_EQ(simulation.poses().size(), names.size() * 12);
  EXPECT_GE(names.size(), 60u);
  EXPECT_LE(names.size(), 200u);
}

}  // namespace
}  // namespace bullet_arm
