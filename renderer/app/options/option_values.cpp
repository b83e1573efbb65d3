#include "renderer/app/options/option_values.h"

#include <charconv>
#include <cmath>

#include "renderer/scene/model/appearance.h"
#include "renderer/settings/draw_settings.h"

namespace fire3dv::app {

bool parse_image_size(const std::string& text, uint32_t& width, uint32_t& height) {
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, width);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != 'x') return false;
  const auto second = std::from_chars(first.ptr + 1, end, height);
  return second.ec == std::errc() && second.ptr == end && width >= 1 && height >= 1 &&
         width <= kMaxImageSide && height <= kMaxImageSide;
}

std::string positive_number(const std::string& text) {
  float value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool good =
      error == std::errc() && end == text.data() + text.size() && std::isfinite(value) && value > 0;
  return good ? "" : text + " is not a number above 0";
}

std::string number_from_zero(const std::string& text) {
  return text == "0" ? "" : positive_number(text);
}

std::string finite_number(const std::string& text) {
  float value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool good = error == std::errc() && end == text.data() + text.size() && std::abs(value) <= 1e6f;
  return good ? "" : text + " is not a number between -1000000 and 1000000";
}

namespace {

// bounds: text of the two bounds.
std::string number_in_range(const std::string& text, float least, float most, const char* bounds) {
  float value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool good = error == std::errc() && end == text.data() + text.size() && value >= least &&
                    value <= most;  // rejects NaN
  return good ? "" : text + " is not a number from " + bounds;
}

}  // namespace

std::string share_number(const std::string& text) {
  return number_in_range(text, 0, 1, "0 to 1");
}

std::string f_number(const std::string& text) {
  return number_in_range(text, scene::kMinFNumber, scene::kMaxFNumber, "0.1 to 1000");
}

std::string focus_distance_m(const std::string& text) {
  return number_in_range(text, scene::kMinFocusDistanceM, scene::kMaxFocusDistanceM, "0.001 to 1000000");
}

std::string anisotropy_number(const std::string& text) {
  return number_in_range(text, 1, 16, "1 to 16");
}

bool parse_background(std::string_view text, passes::Background& background) {
  if (text == "environment") {
    background.show_environment = true;
    return true;
  }
  if (text == "gradient") {
    background = passes::Background::gradient();
    return true;
  }
  background.zenith.reset();
  if (text.starts_with('#')) text.remove_prefix(1);  // optional: shells treat # as a comment
  uint32_t rgb = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), rgb, 16);
  if (error != std::errc() || end != text.data() + text.size() || text.size() != 6) return false;
  for (int c = 0; c < 3; ++c) {
    const float encoded = static_cast<float>(rgb >> (16 - 8 * c) & 0xff) / 255;
    background.color[c] =
        encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
  }
  return true;
}

std::string names_text(std::string label, const std::vector<std::string>& names) {
  for (size_t i = 0; i < names.size(); ++i)
    label += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + std::string(names[i]);
  return label;
}

}  // namespace fire3dv::app
