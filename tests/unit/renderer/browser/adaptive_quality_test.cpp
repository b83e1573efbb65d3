// Size and quality of a viewer's images, by the time that they take.
#include "renderer/browser/adaptive_quality.h"

#include <gtest/gtest.h>

namespace fire3dv::app {
namespace {

TEST(AdaptiveQuality, SlowImagesShrinkAndRecover) {
  AdaptiveQuality quality;
  EXPECT_EQ(quality.step().scale, 1);
  for (int i = 0; i < 20; ++i) quality.on_shown(1);
  EXPECT_EQ(quality.step().scale, 0.5f) << "a slow renderer does not blur the image further";
  EXPECT_EQ(quality.step().quality, AdaptiveQuality::kSteps.back().quality);
  for (int i = 0; i < 1000; ++i) quality.on_shown(0.01);
  EXPECT_EQ(quality.step().scale, 1);
  EXPECT_EQ(quality.step().quality, AdaptiveQuality::kSteps.front().quality);
}

TEST(AdaptiveQuality, StaysBetweenTheLimits) {
  AdaptiveQuality quality;
  quality.on_shown(1);
  const int chosen = quality.step().quality;
  for (int i = 0; i < 1000; ++i) quality.on_shown(0.1);
  EXPECT_EQ(quality.step().quality, chosen);
}

// A connection at its limit: each better step is too slow. Attempts become rarer.
TEST(AdaptiveQuality, RelapsesBecomeRare) {
  AdaptiveQuality quality;
  int slow_early = 0, slow_late = 0;
  for (int i = 0; i < 1000; ++i) {
    const bool is_slow = quality.step().quality == AdaptiveQuality::kSteps.front().quality;
    (i < 200 ? slow_early : slow_late) += is_slow ? 1 : 0;
    quality.on_shown(is_slow ? 1 : 0.01);
  }
  EXPECT_GT(slow_early, 2);
  EXPECT_LT(slow_late, 12);
}

TEST(AdaptiveQuality, RefusedSizeIsFinal) {
  AdaptiveQuality quality;
  float scale = quality.step().scale;
  int sizes = 1;
  for (; quality.on_refused(); ++sizes) {
    EXPECT_LT(quality.step().scale, scale);
    scale = quality.step().scale;
  }
  EXPECT_EQ(sizes, 4);
  EXPECT_EQ(scale, AdaptiveQuality::kSteps.back().scale);
}

TEST(AdaptiveQuality, SharpImagesKeepTheirSize) {
  AdaptiveQuality quality;
  for (int i = 0; i < 20; ++i) quality.on_shown(1);
  quality.prefer_sharp(true);
  EXPECT_EQ(quality.step().scale, 1);
  for (int i = 0; i < 20; ++i) quality.on_shown(1);
  EXPECT_EQ(quality.step().scale, 1);
  EXPECT_TRUE(quality.on_refused()) << "no memory for the size";
  EXPECT_LT(quality.step().scale, 1);
  quality.prefer_sharp(false);
  for (int i = 0; i < 20; ++i) quality.on_shown(1);
  EXPECT_EQ(quality.step().scale, 0.5f);
}

}  // namespace
}  // namespace fire3dv::app
