// Image comparison with goldens and between images, by the tolerances in tolerance.h.
//
// Goldens are PNGs in tests/render/goldens (FIRE3DV_GOLDEN_DIR overrides). A missing golden is a failure,
// never a skip: the test writes its image as NAME.new.png. A different image is written as NAME.actual.png
// with NAME.difference.png (differences times 8, for visibility). Both go to <build>/tests/images
// (FIRE3DV_TEST_IMAGE_DIR overrides).
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string_view>

#include "renderer/sinks/frame.h"
#include "tests/support/tolerance.h"

namespace fire3dv::test {

struct ImageDifference {
  uint64_t pixels = 0;
  uint64_t pixels_different = 0;  // by any amount
  uint64_t pixels_over_delta = 0;
  int largest_channel_delta = 0;
  uint32_t largest_x = 0, largest_y = 0;  // first pixel with the largest difference
  bool same_size = true;

  bool within(Tolerance tolerance) const;
};

// Compares all four channels.
ImageDifference difference_of(const sinks::FrameImage& actual, const sinks::FrameImage& expected,
                              Tolerance tolerance);

// name: letters, digits, '_' and '-'; the golden is NAME.png.
::testing::AssertionResult matches_golden(const sinks::FrameImage& actual, std::string_view name,
                                          Tolerance tolerance);

// name: stem of the files of a failure.
::testing::AssertionResult matches_image(const sinks::FrameImage& actual, const sinks::FrameImage& expected,
                                         std::string_view name, Tolerance tolerance);

}  // namespace fire3dv::test
