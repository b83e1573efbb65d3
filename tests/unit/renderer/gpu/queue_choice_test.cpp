// Test of queue selection, without a device.
#include "renderer/gpu/device/queues.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace fire3dv::gpu {
namespace {

constexpr VkQueueFlags kDraws = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT | VK_QUEUE_TRANSFER_BIT;
constexpr VkQueueFlags kComputes = VK_QUEUE_COMPUTE_BIT | VK_QUEUE_TRANSFER_BIT;

VkQueueFamilyProperties family(VkQueueFlags flags, uint32_t count) {
  VkQueueFamilyProperties properties{};
  properties.queueFlags = flags;
  properties.queueCount = count;
  return properties;
}

TEST(QueueChoice, ComputeFamilyIsPreferred) {
  const std::vector families{family(VK_QUEUE_TRANSFER_BIT, 2), family(kDraws, 16), family(kComputes, 8)};
  const auto choice = choose_queues(families, AsyncCompute::automatic);
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->main_family, 1u);
  EXPECT_EQ(choice->async, AsyncQueue::compute_family);
  EXPECT_EQ(choice->async_family, 2u);
  EXPECT_EQ(choice->async_index, 0u);
  EXPECT_TRUE(choice->two_families());
  EXPECT_EQ(choose_queues(families, AsyncCompute::on)->async, AsyncQueue::compute_family);
}

TEST(QueueChoice, SecondMainQueueIsNext) {
  const std::vector families{family(kDraws, 2), family(kComputes, 0), family(VK_QUEUE_TRANSFER_BIT, 1)};
  const auto choice = choose_queues(families, AsyncCompute::automatic);
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->async, AsyncQueue::main_family);
  EXPECT_EQ(choice->async_family, 0u);
  EXPECT_EQ(choice->async_index, 1u);
  EXPECT_FALSE(choice->two_families());
}

TEST(QueueChoice, ElseNoneUnlessAskedFor) {
  const std::vector families{family(kDraws, 1)};
  EXPECT_EQ(choose_queues(families, AsyncCompute::automatic)->async, AsyncQueue::none);
  const auto asked_for = choose_queues(families, AsyncCompute::on);
  ASSERT_TRUE(asked_for);
  EXPECT_EQ(asked_for->async, AsyncQueue::main_queue);
  EXPECT_EQ(asked_for->async_index, 0u);
  EXPECT_FALSE(asked_for->two_families());
}

TEST(QueueChoice, OffIsOff) {
  const std::vector families{family(kDraws, 16), family(kComputes, 8)};
  const auto choice = choose_queues(families, AsyncCompute::off);
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->async, AsyncQueue::none);
  EXPECT_EQ(choice->async_family, 0u);
  EXPECT_FALSE(choice->two_families());
}

TEST(QueueChoice, IncompleteDeviceHasNone) {
  EXPECT_FALSE(choose_queues({}, AsyncCompute::automatic));
  const std::vector apart{family(VK_QUEUE_GRAPHICS_BIT, 1), family(kComputes, 1), family(kDraws, 0)};
  EXPECT_FALSE(choose_queues(apart, AsyncCompute::on));
}

}  // namespace
}  // namespace fire3dv::gpu
