// Images against goldens and against each other, by the policy in tolerance.h.
//
// Goldens are PNGs in tests/render/goldens (FIRE3DV_GOLDEN_DIR overrides). A test never skips for want of
// one: it writes what it has drawn as NAME.new.png and fails. An image that differs is written as
// NAME.actual.png with NAME.difference.png beside it (differences times 8, so that small ones show). Both go
// to <build>/tests/images (FIRE3DV_TEST_IMAGE_DIR overrides).
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string_view>

#include "renderer/sinks/frame.h"
#include "tests/support/tolerance.h"

namespace fire3dv::test {

struct ImageDifference {
  uint64_t pixels = 0;
  uint64_t pixels_different = 0;  // at all
  uint64_t pixels_over_delta = 0;
  int largest_channel_delta = 0;
  uint32_t largest_x = 0, largest_y = 0;  // the first pixel that is that far off
  bool same_size = true;

  bool within(Tolerance tolerance) const;
};

// All four channels count.
ImageDifference difference_of(const sinks::FrameImage& actual, const sinks::FrameImage& expected,
                              Tolerance tolerance);

// name: letters, digits, '_' and '-'; the golden is NAME.png.
::testing::AssertionResult matches_golden(const sinks::FrameImage& actual, std::string_view name,
                                          Tolerance tolerance);

// name: what the files of a failure are called.
::testing::AssertionResult matches_image(const sinks::FrameImage& actual, const sinks::FrameImage& expected,
                                         std::string_view name, Tolerance tolerance);

}  // namespace fire3dv::test
