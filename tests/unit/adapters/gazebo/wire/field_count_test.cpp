// Count of the fields of encoded messages, against bytes written by hand.
#include <gtest/gtest.h>

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "adapters/gazebo/wire/field_count.h"

namespace fire3dv::gazebo {
namespace {

bool has_at_most(std::string_view bytes, size_t most) {
  return has_at_most_fields(std::as_bytes(std::span(bytes)), most);
}

TEST(GazeboFields, CountsAllLevels) {
  EXPECT_TRUE(has_at_most("", 0));
  // 1: varint 300; 2: {1: 5, 3: {}}; 4: 8 bytes; 5: 4 bytes.
  constexpr std::string_view kMessage{
      "\x08\xac\x02\x12\x04\x08\x05\x1a\x00\x21"
      "12345678"
      "\x2d"
      "1234",
      23};
  EXPECT_TRUE(has_at_most(kMessage, 6));
  EXPECT_FALSE(has_at_most(kMessage, 5));
  // A text that is no message is one field.
  EXPECT_TRUE(has_at_most("\x0a\x05hello", 10));
}

TEST(GazeboFields, EmptyMessagesAreRefused) {
  std::string_view pair{"\x12\x00", 2};
  std::string many;
  for (int i = 0; i < 1000; ++i) many += pair;
  EXPECT_TRUE(has_at_most(many, 1000));
  EXPECT_FALSE(has_at_most(many, 999));
  EXPECT_FALSE(
      has_at_most("\x12\x05"
                  "ab",
                  10));                                                           // cut short
  EXPECT_FALSE(has_at_most("\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff", 10));  // no varint
  EXPECT_FALSE(has_at_most(std::string_view("\x00\x00", 2), 10));                 // field 0
  EXPECT_FALSE(has_at_most("\x0b", 10));                                          // a group
  // Nested to any depth.
  std::string nested;
  for (int level = 0; level < 60; ++level)
    nested = std::string("\x0a") + static_cast<char>(nested.size()) + nested;
  EXPECT_TRUE(has_at_most(nested, 100));
}

}  // namespace
}  // namespace fire3dv::gazebo
