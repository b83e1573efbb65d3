// Test of the memory limits of flow: a run that would exceed them is refused before it begins.
#include <gtest/gtest.h>

#include <string>

#include "renderer/offline/flow_images.h"

namespace fire3dv::offline {
namespace {

constexpr uint64_t kPoses = 1 << 10;  // bytes

FlowPlan made_plan() {
  FlowPlan plan;
  plan.frames = 10;
  plan.extent = {640, 480};
  plan.outputs = wire::ImageOutputs(wire::kColorSrgb8 | wire::kDepthF32 | wire::kAmodal);
  return plan;
}

std::string fault_of(const FlowPlan& plan, uint64_t snapshot_bytes = kPoses) {
  const auto fits = check_flow_memory(plan, snapshot_bytes);
  return fits ? "" : fits.error().message;
}

TEST(FlowMemory, SurfacesHaveALimit) {
  FlowPlan plan = made_plan();
  EXPECT_EQ(fault_of(plan), "");
  plan.frames = 40;
  EXPECT_NE(fault_of(plan).find("keeps surfaces on the device that take 288 MiB; at most 256"),
            std::string::npos)
      << fault_of(plan);
  plan.has_later = false;
  EXPECT_EQ(fault_of(plan), "") << "no surfaces are kept";
  plan.frames = 400;
  EXPECT_NE(fault_of(plan).find("keeps depths on the device"), std::string::npos) << fault_of(plan);
}

TEST(FlowMemory, PosesHaveALimit) {
  FlowPlan plan = made_plan();
  const uint64_t large = uint64_t{30} << 20;
  EXPECT_NE(fault_of(plan, large).find("keeps poses of nodes and vertices on the device that take 330 MiB"),
            std::string::npos)
      << fault_of(plan, large);
  plan.frames = 7;  // with the image that is drawn: eight, which may take any size
  EXPECT_EQ(fault_of(plan, large), "");
  plan.cameras = 2;
  EXPECT_NE(fault_of(plan, large), "") << "each image has its own";
}

TEST(FlowMemory, WaitingImagesHaveALimit) {
  FlowPlan plan = made_plan();
  plan.frames = 7;  // no limit of the device
  plan.extent = {16384, 8192};
  plan.outputs = wire::ImageOutputs(wire::kAllImageOutputs);
  EXPECT_NE(fault_of(plan).find("keeps images in memory that take"), std::string::npos) << fault_of(plan);
  plan.has_later = false;
  EXPECT_EQ(fault_of(plan), "") << "no image waits";
  plan = {};
  EXPECT_EQ(fault_of(plan), "") << "no flow";
}

}  // namespace
}  // namespace fire3dv::offline
