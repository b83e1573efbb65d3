// Test of the motion of a view: what moves it, and when an image at rest is due.
#include "renderer/app/loop/view_motion.h"

#include <gtest/gtest.h>

#include <chrono>

#include "renderer/scene/model/scene.h"

namespace fire3dv::app {
namespace {

using std::chrono::milliseconds;

class ViewMotionTest : public ::testing::Test {
 protected:
  ViewMotionTest() {
    scene_.nodes.resize(1);
    poses_.emplace(scene_);
  }
  bool update(int at_ms) {
    const bool moves = motion_.update(*poses_, edits_, view_, begin_ + milliseconds(at_ms));
    motion_.note_image(moves);
    return moves;
  }
  bool needs_image_at_rest(int at_ms) const {
    return motion_.needs_image_at_rest(begin_ + milliseconds(at_ms));
  }

  scene::Scene scene_;
  std::optional<state::PoseState> poses_;
  scene::EditRevisions edits_;
  glm::mat4 view_{1};
  ViewMotion motion_;
  const ViewMotion::Clock::time_point begin_{};
};

TEST_F(ViewMotionTest, FirstViewStands) {
  EXPECT_FALSE(update(0));
  EXPECT_FALSE(update(10));
  EXPECT_FALSE(needs_image_at_rest(1000));
}

TEST_F(ViewMotionTest, MotionIsFollowedByOneImageAtRest) {
  (void)update(0);
  view_[3].x = 1;
  EXPECT_TRUE(update(100));
  EXPECT_TRUE(update(399)) << "a short time ago";
  EXPECT_FALSE(needs_image_at_rest(399));
  EXPECT_TRUE(needs_image_at_rest(400));
  EXPECT_FALSE(update(400));
  EXPECT_FALSE(needs_image_at_rest(401)) << "it was drawn";
  ++edits_.light;
  EXPECT_TRUE(update(500));
}

TEST_F(ViewMotionTest, PosesMoveAndRepeatedOnesStand) {
  (void)update(0);
  state::RestPose rest = state::rest_pose(scene_);
  rest.world_from_node[0][3].x = 1;
  poses_->set_rest(rest);
  EXPECT_TRUE(update(100));
  poses_->set_rest(rest);
  EXPECT_FALSE(update(500));
}

// A screenshot in motion is drawn in full.
TEST_F(ViewMotionTest, FullImageInMotionNeedsNoOther) {
  (void)update(0);
  view_[3].x = 1;
  (void)update(100);
  motion_.note_image(false);
  EXPECT_FALSE(needs_image_at_rest(1000));
}

}  // namespace
}  // namespace fire3dv::app
