// Image comparison, and evidence files of failures.
#include "tests/support/image_compare.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

#include "renderer/sinks/png.h"

namespace fire3dv::test {
namespace {

std::filesystem::path folder_from(const char* variable, const char* otherwise) {
  const char* chosen = std::getenv(variable);
  return chosen && *chosen ? chosen : otherwise;
}
std::filesystem::path golden_folder() {
  return folder_from("FIRE3DV_GOLDEN_DIR", FIRE3DV_DEFAULT_GOLDEN_DIR);
}
std::filesystem::path image_folder() {
  return folder_from("FIRE3DV_TEST_IMAGE_DIR", FIRE3DV_DEFAULT_IMAGE_DIR);
}

bool is_plain_name(std::string_view name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

// Returns the path of the written file, or the write error; both belong into the failure's text.
std::string write_evidence(const sinks::FrameImage& image, const std::string& file_name) {
  const std::filesystem::path path = image_folder() / file_name;
  std::error_code ignored;  // the write below reports the error
  std::filesystem::create_directories(path.parent_path(), ignored);
  const auto written = sinks::write_png(path, image);
  return written ? path.string() : written.error().message;
}

int channel_delta(const sinks::FrameImage& a, const sinks::FrameImage& b, size_t byte) {
  return std::abs(int{a.rgba8[byte]} - int{b.rgba8[byte]});
}

sinks::FrameImage difference_image(const sinks::FrameImage& actual, const sinks::FrameImage& expected) {
  sinks::FrameImage image;
  image.width = actual.width;
  image.height = actual.height;
  image.rgba8.resize(actual.rgba8.size());
  for (size_t i = 0; i < image.rgba8.size(); ++i) {
    const bool alpha = i % 4 == 3;
    image.rgba8[i] =
        alpha ? 255 : static_cast<uint8_t>(std::min(255, 8 * channel_delta(actual, expected, i)));
  }
  return image;
}

std::string size_text(const sinks::FrameImage& image) {
  return std::to_string(image.width) + " x " + std::to_string(image.height);
}

}  // namespace

bool ImageDifference::within(Tolerance tolerance) const {
  return same_size && static_cast<double>(pixels_over_delta) <=
                          tolerance.max_share_over_delta() * static_cast<double>(pixels);
}

ImageDifference difference_of(const sinks::FrameImage& actual, const sinks::FrameImage& expected,
                              Tolerance tolerance) {
  ImageDifference result;
  result.pixels = uint64_t{actual.width} * actual.height;
  result.same_size = actual.width == expected.width && actual.height == expected.height &&
                     sinks::is_consistent(actual) && sinks::is_consistent(expected) && result.pixels > 0;
  if (!result.same_size) return result;
  for (uint64_t pixel = 0; pixel < result.pixels; ++pixel) {
    int delta = 0;
    for (size_t channel = 0; channel < 4; ++channel)
      delta = std::max(delta, channel_delta(actual, expected, 4 * pixel + channel));
    if (delta > 0) ++result.pixels_different;
    if (delta > tolerance.max_channel_delta()) ++result.pixels_over_delta;
    if (delta > result.largest_channel_delta) {
      result.largest_channel_delta = delta;
      result.largest_x = static_cast<uint32_t>(pixel % actual.width);
      result.largest_y = static_cast<uint32_t>(pixel / actual.width);
    }
  }
  return result;
}

::testing::AssertionResult matches_image(const sinks::FrameImage& actual, const sinks::FrameImage& expected,
                                         std::string_view name, Tolerance tolerance) {
  if (!is_plain_name(name))
    return ::testing::AssertionFailure() << "'" << name << "' is not a plain name for an image";
  const ImageDifference difference = difference_of(actual, expected, tolerance);
  if (difference.within(tolerance)) return ::testing::AssertionSuccess() << name << " is as expected";
  auto failure = ::testing::AssertionFailure();
  const std::string base(name);
  if (!difference.same_size) {
    failure << name << ": " << size_text(actual) << " pixels, expected " << size_text(expected);
  } else {
    failure << name << ": " << difference.pixels_over_delta << " of " << difference.pixels << " pixels ("
            << 100.0 * static_cast<double>(difference.pixels_over_delta) /
                   static_cast<double>(difference.pixels)
            << " %) are off by more than " << tolerance.max_channel_delta() << "/255, and "
            << 100.0 * tolerance.max_share_over_delta() << " % may be (" << tolerance.name() << "); "
            << difference.pixels_different << " differ at all; the largest difference is "
            << difference.largest_channel_delta << "/255 at x " << difference.largest_x << ", y "
            << difference.largest_y << "\n  difference: "
            << write_evidence(difference_image(actual, expected), base + ".difference.png");
  }
  return failure << "\n  actual: " << write_evidence(actual, base + ".actual.png");
}

::testing::AssertionResult matches_golden(const sinks::FrameImage& actual, std::string_view name,
                                          Tolerance tolerance) {
  if (!is_plain_name(name))
    return ::testing::AssertionFailure() << "'" << name << "' is not a plain name for a golden";
  const std::filesystem::path golden_path = golden_folder() / (std::string(name) + ".png");
  const auto golden = sinks::read_png(golden_path);
  if (!golden) {
    return ::testing::AssertionFailure()
           << name << ": no golden (" << golden.error().message
           << ")\n  drawn now: " << write_evidence(actual, std::string(name) + ".new.png")
           << "\n  look at it; if it is right, copy it to " << golden_path.string();
  }
  return matches_image(actual, golden->image, name, tolerance) << "\n  golden: " << golden_path.string();
}

}  // namespace fire3dv::test
