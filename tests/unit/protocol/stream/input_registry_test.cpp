// Tests of a stream's declared inputs: limits, budget, and what counts as a change.
#include "protocol/stream/input_registry.h"

#include <gtest/gtest.h>

#include <string>

namespace fire3dv::stream {
namespace {

wire::SceneEdit declaration(const std::string& name, double value = 0, double maximum = 1) {
  wire::Input input;
  input.kind = wire::InputKind::slider;
  input.maximum = maximum;
  input.value = value;
  return {1, 1, name, wire::Property::input, input};
}

TEST(InputRegistry, TellsValuesFromStructure) {
  InputRegistry registry;
  ASSERT_TRUE(registry.apply(declaration("gain")).ok());
  const uint64_t structure = registry.structure(), revision = registry.revision();
  ASSERT_TRUE(registry.apply(declaration("gain")).ok());
  EXPECT_EQ(registry.revision(), revision) << "repeated";
  ASSERT_TRUE(registry.apply(declaration("gain", 0.5)).ok());
  EXPECT_GT(registry.revision(), revision);
  EXPECT_EQ(registry.structure(), structure) << "only the value is another";
  ASSERT_NE(registry.find("gain"), nullptr);
  EXPECT_EQ(registry.find("gain")->value, 0.5);
  ASSERT_TRUE(registry.apply(declaration("gain", 0.5, 2)).ok());
  EXPECT_GT(registry.structure(), structure);
  EXPECT_NE(registry.find(wire::InputKind::slider), nullptr);
  ASSERT_TRUE(registry.apply({1, 2, "gain", wire::Property::input, wire::Cleared{}}).ok());
  EXPECT_EQ(registry.find("gain"), nullptr);
  EXPECT_EQ(registry.find(wire::InputKind::slider), nullptr);
}

TEST(InputRegistry, BoundsTheirNumber) {
  InputRegistry registry;
  for (size_t i = 0; i < wire::kMaxInputs; ++i)
    ASSERT_TRUE(registry.apply(declaration(std::to_string(i))).ok());
  const Result<void> more = registry.apply(declaration("more"));
  ASSERT_FALSE(more.ok());
  EXPECT_NE(more.error().message.find("at most 256 inputs"), std::string::npos) << more.error().message;
  EXPECT_TRUE(registry.apply(declaration("7", 1)).ok()) << "one that is declared may change";
  EXPECT_EQ(registry.inputs().size(), wire::kMaxInputs);
}

TEST(InputRegistry, ChargesThePeer) {
  PeerLimits limits;
  limits.of(Resource::edit_bytes) = 1000;
  const auto pool = BudgetPool::create(limits);
  InputRegistry registry(pool->add_peer("peer"));
  ASSERT_TRUE(registry.apply(declaration("a")).ok());
  EXPECT_FALSE(registry.apply(declaration("b")).ok()) << "the second does not fit";
  ASSERT_TRUE(registry.apply({1, 2, "a", wire::Property::input, wire::Cleared{}}).ok());
  EXPECT_TRUE(registry.apply(declaration("b")).ok()) << "the first has returned its memory";
}

}  // namespace
}  // namespace fire3dv::stream
