// Test of the detection of idle runs.
#include "renderer/app/loop/idle_detection.h"

#include <gtest/gtest.h>

namespace fire3dv::app {
namespace {

int due_images(IdleDetection& idle) {
  int count = 0;
  while (idle.take_due_image()) ++count;
  return count;
}

TEST(IdleDetection, ThreeImagesFollowAChange) {
  IdleDetection idle;
  EXPECT_FALSE(idle.take_due_image()) << "nothing to draw yet";
  idle.update({1, 2, 3}, false);
  EXPECT_TRUE(idle.is_busy());
  EXPECT_EQ(due_images(idle), 3);
  idle.update({1, 2, 3}, false);
  EXPECT_EQ(due_images(idle), 0) << "the same revisions";
  idle.update({1, 2, 4}, false);
  EXPECT_EQ(due_images(idle), 3);
}

TEST(IdleDetection, ActivityIsDrawnWithoutAChange) {
  IdleDetection idle;
  idle.update({1, 1, 1}, false);
  EXPECT_EQ(due_images(idle), 3);
  idle.update({1, 1, 1}, true);
  EXPECT_EQ(due_images(idle), 3);
}

}  // namespace
}  // namespace fire3dv::app
