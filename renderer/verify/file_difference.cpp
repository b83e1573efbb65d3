#include "renderer/verify/file_difference.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <glm/gtc/packing.hpp>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "base/text.h"
#include "renderer/sinks/gray_png.h"
#include "renderer/sinks/png.h"
#include "renderer/verify/json_difference.h"

namespace fire3dv::verify {
namespace {

using Bytes = std::span<const uint8_t>;

constexpr size_t kMaxShownBytes = 120;

std::string at_pixel(uint64_t x, uint64_t y) {
  return "pixel (" + std::to_string(x) + ", " + std::to_string(y) + ")";
}

std::string both(const std::string& stored, const std::string& drawn) {
  return " is " + stored + " in the file and " + drawn + " here";
}

std::string size_text(uint64_t width, uint64_t height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

// has_alpha: of both pixels, since that is all that differs.
std::string color_text(const uint8_t* pixel, bool has_alpha) {
  std::string text;
  for (int channel = 0; channel < (has_alpha ? 4 : 3); ++channel)
    text += (channel ? " " : "") + std::to_string(pixel[channel]);
  return text;
}

// png: accepted by decode_png(), so that its first chunk is IHDR.
bool has_16_bits(Bytes png) {
  constexpr size_t kBitDepthAt = 24;
  return png[kBitDepthAt] == 16;
}

std::optional<std::string> png_difference(Bytes stored, Bytes drawn) {
  const auto before = sinks::decode_png(stored), now = sinks::decode_png(drawn);
  if (!before) return before.error().message;
  if (!now) return now.error().message;
  constexpr uint64_t kMaxPixels = sinks::PngLimits().max_pixels;
  const auto gray_before = sinks::decode_gray16(stored, kMaxPixels),
             gray_now = sinks::decode_gray16(drawn, kMaxPixels);
  if (!gray_before || !gray_now || gray_before->width != gray_now->width ||
      gray_before->height != gray_now->height) {
    if (auto difference = pixel_difference(before->image, now->image)) return difference;
    // decode_png() has dropped the low bytes of 16-bit channels.
    if (has_16_bits(stored) || has_16_bits(drawn)) return "it is not a grey image of 16 bits in both";
    return std::nullopt;
  }
  const auto [a, b] = std::mismatch(gray_before->pixels.begin(), gray_before->pixels.end(),
                                    gray_now->pixels.begin(), gray_now->pixels.end());
  if (a == gray_before->pixels.end()) return std::nullopt;
  const auto pixel = static_cast<uint64_t>(a - gray_before->pixels.begin());
  return at_pixel(pixel % gray_now->width, pixel / gray_now->width) +
         both(std::to_string(*a), std::to_string(*b));
}

// Type and shape of the files that fire3dv writes.
struct NpyHead {
  size_t data_at = 0;
  std::string type;
  std::vector<uint64_t> shape;
};

// drawn: of this program.
NpyHead npy_head(Bytes drawn) {
  NpyHead head;
  head.data_at = 10 + (drawn[8] | size_t{drawn[9]} << 8);
  const std::string text(drawn.begin() + 10, drawn.begin() + static_cast<std::ptrdiff_t>(head.data_at));
  const size_t type_at = text.find("'descr': '") + 10;
  head.type = text.substr(type_at, text.find('\'', type_at) - type_at);
  uint64_t number = 0;
  bool has_digits = false;
  for (size_t at = text.find('('); at < text.find(')') + 1; ++at) {
    const bool is_digit = text[at] >= '0' && text[at] <= '9';
    if (is_digit) number = 10 * number + static_cast<uint64_t>(text[at] - '0');
    if (!is_digit && has_digits) head.shape.push_back(number);
    if (!is_digit) number = 0;
    has_digits = is_digit;
  }
  return head;
}

template <typename T>
T element(const uint8_t* at) {
  T value{};
  std::memcpy(&value, at, sizeof value);
  return value;
}

std::string element_text(const std::string& type, const uint8_t* at) {
  char text[32];
  if (type == "<f4") {
    std::snprintf(text, sizeof text, "%.9g", static_cast<double>(element<float>(at)));
    return text;
  }
  if (type == "<f2") {
    std::snprintf(text, sizeof text, "%.5g", static_cast<double>(glm::unpackHalf1x16(element<uint16_t>(at))));
    return text;
  }
  if (type == "<u4") return std::to_string(element<uint32_t>(at));
  if (type == "<u2") return std::to_string(element<uint16_t>(at));
  return std::to_string(*at);
}

std::optional<std::string> npy_difference(Bytes stored, Bytes drawn) {
  const NpyHead head = npy_head(drawn);
  if (stored.size() != drawn.size() ||
      !std::equal(drawn.begin(), drawn.begin() + static_cast<std::ptrdiff_t>(head.data_at), stored.begin()))
    return "type or shape of the array differs";
  const auto differing = std::mismatch(drawn.begin(), drawn.end(), stored.begin()).first;
  const size_t element_bytes = static_cast<size_t>(std::max(head.type.back() - '0', 1));
  const size_t index = (static_cast<size_t>(differing - drawn.begin()) - head.data_at) / element_bytes;
  const size_t at = head.data_at + index * element_bytes;
  const std::string values =
      both(element_text(head.type, stored.data() + at), element_text(head.type, drawn.data() + at));
  const bool is_image = head.shape.size() == 2 || (head.shape.size() == 3 && head.shape[2] <= 4);
  if (!is_image) return "element " + std::to_string(index) + values;
  const uint64_t channels = head.shape.size() == 3 ? head.shape[2] : 1, pixel = index / channels;
  return at_pixel(pixel % head.shape[1], pixel / head.shape[1]) +
         (channels > 1 ? ", channel " + std::to_string(index % channels) + "," : "") + values;
}

std::string line_at(Bytes text, size_t at) {
  const auto position = text.begin() + static_cast<std::ptrdiff_t>(std::min(at, text.size()));
  const auto end = std::find(position, text.end(), '\n');
  return printable_text(std::string(position, end), kMaxShownBytes);
}

// Parts between commas and spaces of the line around a position.
std::vector<std::string> parts_of_line(Bytes text, size_t at) {
  const auto position = text.begin() + static_cast<std::ptrdiff_t>(std::min(at, text.size()));
  const auto end = std::find(position, text.end(), '\n');
  auto begin = position;
  while (begin != text.begin() && *(begin - 1) != '\n') --begin;
  std::vector<std::string> parts(1);
  for (auto each = begin; each != end; ++each) {
    if (*each == ',' || *each == ' ')
      parts.emplace_back();
    else
      parts.back() += static_cast<char>(*each);
  }
  return parts;
}

// Of rows of equally many numbers the first that differs, else the rest of the lines.
std::string text_difference(Bytes stored, Bytes drawn, size_t at) {
  const auto lines = std::count(drawn.begin(), drawn.begin() + static_cast<std::ptrdiff_t>(at), '\n');
  const std::string line = "line " + std::to_string(lines + 1);
  const std::vector<std::string> before = parts_of_line(stored, at), now = parts_of_line(drawn, at);
  const auto [was, is] = std::mismatch(before.begin(), before.end(), now.begin(), now.end());
  if (now.size() > 1 && before.size() == now.size() && is != now.end())
    return line + ", value " + std::to_string(is - now.begin() + 1) +
           both(printable_text(*was, kMaxShownBytes), printable_text(*is, kMaxShownBytes));
  return line + both('"' + line_at(stored, at) + '"', '"' + line_at(drawn, at) + '"');
}

}  // namespace

std::optional<std::string> pixel_difference(const sinks::FrameImage& stored, const sinks::FrameImage& drawn) {
  if (stored.width != drawn.width || stored.height != drawn.height)
    return "the size" + both(size_text(stored.width, stored.height), size_text(drawn.width, drawn.height));
  const auto [a, b] =
      std::mismatch(stored.rgba8.begin(), stored.rgba8.end(), drawn.rgba8.begin(), drawn.rgba8.end());
  if (a == stored.rgba8.end() || b == drawn.rgba8.end()) return std::nullopt;
  const auto pixel = static_cast<uint64_t>(a - stored.rgba8.begin()) / 4;
  const uint8_t* const was = stored.rgba8.data() + 4 * pixel;
  const uint8_t* const now = drawn.rgba8.data() + 4 * pixel;
  const bool has_alpha = std::equal(was, was + 3, now);
  return at_pixel(pixel % drawn.width, pixel / drawn.width) +
         both(color_text(was, has_alpha), color_text(now, has_alpha));
}

std::optional<std::string> file_difference(std::string_view name, Bytes stored, Bytes drawn) {
  if (std::equal(stored.begin(), stored.end(), drawn.begin(), drawn.end())) return std::nullopt;
  if (name.ends_with(".png")) return png_difference(stored, drawn);
  if (name.ends_with(".npy")) return npy_difference(stored, drawn);
  const auto [a, b] = std::mismatch(stored.begin(), stored.end(), drawn.begin(), drawn.end());
  const auto at = static_cast<size_t>(b - drawn.begin());
  if (name.ends_with(".json")) {
    const auto before = parse_json(stored), json_now = parse_json(drawn);
    if (const auto difference = before && json_now ? json_difference(*before, *json_now) : std::nullopt)
      return difference;
    return text_difference(stored, drawn, at);
  }
  if (name.ends_with(".txt") || name.ends_with(".yaml")) return text_difference(stored, drawn, at);
  return "byte " + std::to_string(at) + " of " + std::to_string(stored.size()) + " differs";
}

std::optional<std::string> line_difference(const std::string& stored, const std::string& drawn) {
  auto before = nlohmann::json::parse(stored, nullptr, false);
  auto now = nlohmann::json::parse(drawn, nullptr, false);
  if (!before.is_object() || !now.is_object()) return "the line is no JSON object";
  before.erase("bytes");
  now.erase("bytes");
  return json_difference(before, now);
}

}  // namespace fire3dv::verify
