// Test of the publisher's scene edit store: the newest value of each key, versioned, within its budget.
#include <gtest/gtest.h>

#include "protocol/wire/decode.h"
#include "protocol/wire/edit_store.h"

namespace fire3dv::wire {
namespace {

SceneEdit vertices(const std::string& node, size_t count) {
  Vertices value;
  value.positions.resize(count);
  return {0, 0, node, Property::vertices, value};
}
SceneEdit visible(const std::string& node, bool shown) {
  return {0, 0, node, Property::visible, Visible{shown}};
}

Result<void> set(EditStore& store, SceneEdit edit) {
  auto prepared = store.prepare(std::move(edit));
  if (!prepared) return prepared.error();
  store.commit(std::move(*prepared));
  return {};
}

SceneEdit decoded(const EditStore::Stored& stored) {
  Decoder decoder;
  auto message = decoder.decode(*stored.message);
  EXPECT_TRUE(message.ok()) << message.error().message;
  return std::get<SceneEdit>(*message);
}

TEST(EditStore, NewestVersionOfKeyStays) {
  EditStore store;
  EXPECT_EQ(store.version(), 0u);
  ASSERT_TRUE(set(store, visible("a", false)));
  ASSERT_TRUE(set(store, visible("b", false)));
  ASSERT_TRUE(set(store, visible("a", true)));
  ASSERT_TRUE(set(store, {0, 0, "a", Property::light, Cleared{}}));
  store.set_epoch(77);
  const auto all = store.in_order();
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(decoded(all[0]), (SceneEdit{77, 2, "b", Property::visible, Visible{false}}));
  EXPECT_EQ(decoded(all[1]), (SceneEdit{77, 3, "a", Property::visible, Visible{true}}));
  EXPECT_EQ(decoded(all[2]), (SceneEdit{77, 4, "a", Property::light, Cleared{}}));
  EXPECT_EQ(store.version(), 4u);
  EXPECT_NE(all[0].key, all[1].key);
  EXPECT_NE(all[1].key, all[2].key);
}

TEST(EditStore, AKeyKeepsItsNumber) {
  EditStore store;
  ASSERT_TRUE(set(store, visible("a", false)));
  const uint64_t key = store.in_order()[0].key;
  ASSERT_TRUE(set(store, visible("b", false)));
  ASSERT_TRUE(set(store, visible("a", true)));
  EXPECT_EQ(store.in_order()[1].key, key);
}

TEST(EditStore, OverTheBudgetNothingChanges) {
  EditStore store(20'000);
  ASSERT_TRUE(set(store, vertices("a", 1000)));
  const size_t used = store.used_bytes();
  const auto refused = set(store, vertices("b", 1000));
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("budget is 20000"), std::string::npos) << refused.error().message;
  EXPECT_EQ(store.used_bytes(), used);
  EXPECT_EQ(store.version(), 1u);
  EXPECT_EQ(store.in_order().size(), 1u);
  // A smaller value always replaces a larger one; otherwise a full store could not be cleared.
  EXPECT_TRUE(set(store, vertices("a", 1100)));
  EXPECT_TRUE(set(store, {0, 0, "a", Property::vertices, Cleared{}}));
  EXPECT_TRUE(set(store, vertices("b", 1000)));
  EXPECT_LE(store.used_bytes(), 20'000u);
  EXPECT_FALSE(set(store, vertices("a", 1000)));
}

TEST(EditStore, InvalidEditsAreRefused) {
  EditStore store;
  const auto refused = set(store, {0, 0, "a", Property::base_color, BaseColor{{2, 0, 0, 1}}});
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("rgba[0]"), std::string::npos);
  EXPECT_EQ(store.version(), 0u);
}

TEST(EditStore, KeyTooManyIsRefused) {
  EditStore store(kMaxSceneEditBytes);
  for (size_t i = 0; i < kMaxSceneEdits; ++i) ASSERT_TRUE(set(store, visible(std::to_string(i), false)));
  EXPECT_FALSE(set(store, visible("one more", false)).ok());
  EXPECT_TRUE(set(store, visible("7", true)).ok());
}

}  // namespace
}  // namespace fire3dv::wire
