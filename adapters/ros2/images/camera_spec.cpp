#include "adapters/ros2/images/camera_spec.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "adapters/ros2/dds/names.h"
#include "base/text.h"

namespace fire3dv::ros2 {
namespace {

constexpr std::string_view kKeys =
    "parent, optical, xyz, rpy, size, fov, fx, fy, cx, cy, near, far, plumb_bob, equidistant, rate, depth, "
    "labels, "
    "compressed, quality";

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

Error bad_value(const std::string& key, std::string_view value, const std::string& valid) {
  return Error{key + "=" + quote(value) + ": expected " + valid};
}

Result<double> number(const std::string& key, std::string_view value, double least, double most,
                      const std::string& valid) {
  double parsed = 0;
  if (!parse_numbers(value, &parsed, 1) || parsed < least || parsed > most)
    return bad_value(key, value, valid);
  return parsed;
}

Result<void> set_number(double& target, const std::string& key, std::string_view value, double least,
                        double most, const std::string& valid) {
  const Result<double> parsed = number(key, value, least, most, valid);
  if (!parsed) return parsed.error();
  target = *parsed;
  return {};
}

// Frame ids as tf2 takes them: a leading slash is stripped.
Result<void> set_frame(std::string& frame, const std::string& key, std::string_view value) {
  if (value.starts_with('/')) value.remove_prefix(1);
  constexpr size_t kMaxBytes = 255;
  if (value.empty() || value.size() > kMaxBytes || printable_text(value, kMaxBytes) != value)
    return bad_value(key, value, "the name of a tf frame");
  frame = value;
  return {};
}

Result<void> set_flag(bool& flag, const std::string& key, std::string_view value) {
  if (!value.empty() && value != "true" && value != "false")
    return bad_value(key, value, "true or false, or the key alone");
  flag = value != "false";
  return {};
}

Result<void> set_lens(CameraSpec& camera, Lens lens, size_t count, const std::string& key,
                      std::string_view value, const std::string& valid) {
  std::array<double, 5> coefficients{};
  if (!parse_numbers(value, coefficients.data(), count)) return bad_value(key, value, valid);
  camera.lens = lens;
  camera.lens_coefficients = coefficients;
  return {};
}

// What the settings of one option have named so far.
struct Given {
  bool parent = false, pose = false, optical = false;
};

Result<void> set(CameraSpec& camera, Given& given, const std::string& key, const std::string& value) {
  constexpr double kMaxPixels = 1e6;
  constexpr double kMaxMetres = 1e9;
  if (key == "parent") {
    given.parent = true;
    return set_frame(camera.parent_frame, key, value);
  }
  if (key == "optical") {
    given.optical = true;
    return set_frame(camera.optical_frame, key, value);
  }
  if (key == "xyz" || key == "rpy") {
    given.pose = true;
    std::array<double, 3> parsed{};
    if (!parse_numbers(value, parsed.data(), 3) || std::abs(parsed[0]) > kMaxMetres ||
        std::abs(parsed[1]) > kMaxMetres || std::abs(parsed[2]) > kMaxMetres)
      return bad_value(key, value,
                       key == "xyz" ? "three numbers in metres, as in URDF: 'xyz=0.1 0 0.05'"
                                    : "three angles in radians, as in URDF: 'rpy=0 0.4 0'");
    (key == "xyz" ? camera.xyz : camera.rpy) = parsed;
    return {};
  }
  if (key == "size") {
    const auto size = parse_image_size(value);
    if (!size) return Error{"size=" + size.error().message};
    set_image_size(camera, size->first, size->second);
    return {};
  }
  if (key == "fov") {
    camera.fx = camera.fy = 0;
    return set_number(camera.fov, key, value, 1e-3, std::numbers::pi - 1e-3,
                      "the horizontal angle of view in radians, less than pi (60 degrees are 1.0472)");
  }
  if (key == "fx" || key == "fy")
    return set_number(key == "fx" ? camera.fx : camera.fy, key, value, 1e-3, kMaxPixels,
                      "a focal length in pixels, more than 0");
  if (key == "cx" || key == "cy")
    return set_number(key == "cx" ? camera.cx : camera.cy, key, value, 0, kMaxPixels,
                      "a pixel of the image; 0 is the centre of the first");
  if (key == "near") return set_number(camera.near_m, key, value, 1e-4, kMaxMetres, "metres, more than 0");
  if (key == "far") return set_number(camera.far_m, key, value, 0, kMaxMetres, "metres; 0: infinite");
  if (key == "plumb_bob") return set_lens(camera, Lens::plumb_bob, 5, key, value, "'k1 k2 p1 p2 k3'");
  if (key == "equidistant") return set_lens(camera, Lens::equidistant, 4, key, value, "'k1 k2 k3 k4'");
  if (key == "rate")
    return set_number(camera.rate_hz, key, value, 0, 1e6, "images per second; 0: one of every pose frame");
  if (key == "depth") return set_flag(camera.depth, key, value);
  if (key == "compressed") return set_flag(camera.compressed, key, value);
  if (key == "labels") {
    if (!value.empty() && value != "instance" && value != "semantic" && value != "false")
      return bad_value(key, value, "instance or semantic, or the key alone for instance");
    camera.labels = value == "semantic" ? LabelSource::semantic
                    : value == "false"  ? LabelSource::none
                                        : LabelSource::instance;
    return {};
  }
  if (key == "quality") {
    const Result<double> quality = number(key, value, 1, 100, "a JPEG quality from 1 to 100");
    if (!quality) return quality.error();
    camera.jpeg_quality = static_cast<uint32_t>(*quality);
    return {};
  }
  return Error{quote(key) + " is not a key of a camera; the keys are " + std::string(kKeys)};
}

Result<void> check_projection(const CameraSpec& camera) {
  if (camera.far_m > 0 && camera.far_m <= camera.near_m) return Error{"far must be more than near, or 0"};
  if (camera.fx == 0 && camera.fy != 0) return Error{"fy goes together with fx"};
  return {};
}

}  // namespace

bool parse_numbers(std::string_view text, double* numbers, size_t count) {
  const char* at = text.data();
  const char* const end = at + text.size();
  const auto skip_space = [&] {
    while (at != end && is_space(*at)) ++at;
  };
  for (size_t i = 0; i < count; ++i) {
    const char* const before = at;
    skip_space();
    if (i > 0 && at == before) return false;  // "1-2"
    if (at != end && *at == '+') ++at;
    const auto [rest, error] = std::from_chars(at, end, numbers[i]);
    if (error != std::errc() || !std::isfinite(numbers[i])) return false;
    at = rest;
  }
  skip_space();
  return at == end;
}

void set_image_size(CameraSpec& camera, uint32_t width, uint32_t height) {
  const double x = static_cast<double>(width) / camera.width, y = static_cast<double>(height) / camera.height;
  if (camera.fx > 0 && camera.fy == 0 && x != y) camera.fy = camera.fx;
  camera.fx *= x;
  camera.fy *= y;
  // Pixel coordinates count from the centre of the first pixel.
  if (camera.cx >= 0) camera.cx = std::max((camera.cx + 0.5) * x - 0.5, 0.0);
  if (camera.cy >= 0) camera.cy = std::max((camera.cy + 0.5) * y - 0.5, 0.0);
  camera.width = width;
  camera.height = height;
}

Result<std::pair<uint32_t, uint32_t>> parse_image_size(std::string_view text) {
  uint32_t width = 0, height = 0;
  const char* const end = text.data() + text.size();
  const auto [cross, width_error] = std::from_chars(text.data(), end, width);
  if (width_error == std::errc() && cross != end && *cross == 'x') {
    const auto [rest, height_error] = std::from_chars(cross + 1, end, height);
    if (height_error == std::errc() && rest == end && width >= 1 && height >= 1 && width <= kMaxImageSide &&
        height <= kMaxImageSide)
      return std::pair{width, height};
  }
  return Error{quote(text) + ": expected WIDTHxHEIGHT, each from 1 to " + std::to_string(kMaxImageSide) +
               " pixels"};
}

std::string topic_from_name(std::string_view name) {
  std::string topic;
  for (const char c : name) {
    const bool is_digit = c >= '0' && c <= '9';
    const bool is_good = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || is_digit;
    if (is_digit && topic.empty()) topic = "camera_";
    if (topic.size() < kMaxTopicBytes) topic += is_good ? c : '_';
  }
  return topic.empty() ? "camera" : topic;
}

Result<CameraOption> parse_camera_option(std::string_view text) {
  const auto fail = [&](const Error& error) {
    return Error{"camera " + quote(text.substr(0, text.find_first_of(",:"))) + ": " + error.message};
  };
  CameraOption option;
  std::string_view rest = text;
  for (bool is_first = true; is_first || !rest.empty(); is_first = false) {
    const size_t comma = rest.find(',');
    const std::string_view item = rest.substr(0, comma);
    rest = comma == rest.npos ? std::string_view() : rest.substr(comma + 1);
    if (is_first) {
      const size_t remap = item.find(":=");
      if (Result<void> named = set_frame(option.name, "name", item.substr(0, remap)); !named)
        return Error{"a camera needs a name: NAME[:=TOPIC][,KEY=VALUE]..., not " + quote(text)};
      if (remap != item.npos) {
        option.topic = item.substr(remap + 2);
        if (!is_valid_name(option.topic) || option.topic.size() > kMaxTopicBytes)
          return fail(Error{quote(option.topic) +
                            " is not a topic name: use letters, digits, underscores and single "
                            "slashes"});
      }
      continue;
    }
    const size_t equals = item.find('=');
    option.settings.emplace_back(item.substr(0, equals),
                                 equals == item.npos ? std::string_view() : item.substr(equals + 1));
  }
  if (const Result<CameraSpec> checked = apply(option, CameraSpec{}); !checked) return checked.error();
  return option;
}

Result<CameraSpec> apply(const CameraOption& option, CameraSpec camera) {
  const auto fail = [&](const std::string& message) {
    return Error{"camera " + quote(option.name) + ": " + message};
  };
  const bool is_new = camera.name.empty();  // not a <sensor> that is there already
  camera.name = option.name;
  if (!option.topic.empty()) camera.topic = option.topic;
  if (camera.topic.empty()) camera.topic = topic_from_name(camera.name);
  Given given;
  // Projections of the same option belong to its size.
  for (const bool is_size : {true, false})
    for (const auto& [key, value] : option.settings)
      if ((key == "size") == is_size)
        if (Result<void> done = set(camera, given, key, value); !done) return fail(done.error().message);
  if (Result<void> good = check_projection(camera); !good) return fail(good.error().message);
  if (given.parent || given.pose) {
    // The pose of a <sensor> is relative to its own link.
    if (given.parent && !given.pose) camera.xyz = camera.rpy = {};
    if (!given.optical && !is_new) camera.optical_frame = camera.name + "_optical_frame";
    camera.publishes_frame = true;
  }
  if (given.optical && !given.parent && !given.pose) {
    camera.parent_frame = camera.optical_frame;
    camera.publishes_frame = false;
    return camera;
  }
  if (camera.parent_frame.empty()) camera.parent_frame = camera.name;
  if (camera.optical_frame.empty()) camera.optical_frame = camera.name + "_optical_frame";
  if (camera.is_in_optical_frame())
    return fail("parent and optical are one frame; give only optical=" + camera.optical_frame +
                " if tf has that frame already");
  return camera;
}

}  // namespace fire3dv::ros2
