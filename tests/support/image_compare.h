// Image comparison with goldens and between images, and its tolerances.
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

namespace fire3dv::test {

// Image tolerances of all tests. There are two presets and no third: a test that needs another tolerance has
// found a defect or needs another scene.
class Tolerance {
 public:
  // Byte equality: ids, determinism, transport independence.
  static constexpr Tolerance exact() { return {"exact", 0, 0.0}; }

  // Colour against a golden: a limit per channel, and a fraction of pixels that may exceed it. Rounding
  // changes many pixels a little; an edge on the other side changes a few pixels a lot. A wrong light,
  // material or pose exceeds both.
  static constexpr Tolerance colour() { return {"colour", 5, 0.001}; }

  constexpr const char* name() const { return name_; }
  constexpr int max_channel_delta() const { return max_channel_delta_; }           // of 255
  constexpr double max_share_over_delta() const { return max_share_over_delta_; }  // of all pixels

 private:
  constexpr Tolerance(const char* name, int max_channel_delta, double max_share_over_delta)
      : name_(name), max_channel_delta_(max_channel_delta), max_share_over_delta_(max_share_over_delta) {}

  const char* name_;
  int max_channel_delta_;
  double max_share_over_delta_;
};

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
