#include "renderer/scene/textures/environment.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <new>
#include <optional>
#include <string_view>

#include "renderer/scene/files.h"

namespace fire3dv::scene {
namespace {

constexpr int kExponentBias = 15, kMantissaBits = 9, kMaxExponent = 31;
constexpr float kPi = 3.14159265358979f;

// Radiances of the studio.
constexpr float kStudioFloor = 0.22f, kStudioWall = 0.15f, kStudioCeiling = 0.30f;
constexpr float kStudioKey = 2.2f, kStudioFill = 0.7f, kStudioRim = 2.6f;

// Rectangle at unit distance, perpendicular to its direction.
struct Panel {
  glm::vec3 to_panel;                   // unit
  float half_width, half_height, edge;  // at unit distance; edge: width of the soft border
  float radiance;
};

float radiance_of_panel(const Panel& panel, const glm::vec3& direction) {
  const float facing = glm::dot(direction, panel.to_panel);
  if (facing <= 1e-3f) return 0;
  const glm::vec3 right = glm::normalize(glm::cross(glm::vec3(0, 1, 0), panel.to_panel));
  const glm::vec3 up = glm::cross(panel.to_panel, right);
  const auto inside = [&](const glm::vec3& axis, float half) {
    return 1 - glm::smoothstep(half - panel.edge, half + panel.edge,
                               std::abs(glm::dot(direction, axis)) / facing);
  };
  return panel.radiance * inside(right, panel.half_width) * inside(up, panel.half_height);
}

glm::vec3 studio_radiance(const glm::vec3& direction) {
  static const Panel kPanels[] = {
      {glm::normalize(glm::vec3(-0.30f, 0.80f, 0.52f)), 0.38f, 0.28f, 0.03f, kStudioKey},
      {glm::normalize(glm::vec3(0.90f, 0.25f, 0.45f)), 0.30f, 0.60f, 0.10f, kStudioFill},
      {glm::normalize(glm::vec3(-0.75f, 0.30f, -0.65f)), 0.10f, 0.55f, 0.03f, kStudioRim},
      {glm::normalize(glm::vec3(0.70f, 0.35f, -0.75f)), 0.10f, 0.45f, 0.03f, kStudioRim},
  };
  float radiance = direction.y > 0
                       ? glm::mix(kStudioWall, kStudioCeiling, glm::smoothstep(0.0f, 0.9f, direction.y))
                       : glm::mix(kStudioFloor, kStudioWall, glm::smoothstep(-0.5f, -0.02f, direction.y));
  for (const Panel& panel : kPanels) radiance += radiance_of_panel(panel, direction);
  return glm::vec3(radiance);
}

}  // namespace

uint32_t pack_rgb9e5(glm::vec3 color) {
  for (int c = 0; c < 3; ++c) color[c] = color[c] > 0 ? std::min(color[c], kMaxRgb9e5) : 0;  // NaN becomes 0
  const float largest = std::max({color.r, color.g, color.b});
  int exponent = std::max(-kExponentBias - 1, largest > 0 ? std::ilogb(largest) : -kExponentBias - 1) + 1 +
                 kExponentBias;
  float step = std::ldexp(1.0f, exponent - kExponentBias - kMantissaBits);
  if (std::lround(largest / step) == 1 << kMantissaBits) {  // rounding needs one more bit
    step *= 2;
    ++exponent;
  }
  exponent = std::min(exponent, kMaxExponent);
  const auto mantissa = [&](float value) { return static_cast<uint32_t>(std::lround(value / step)); };
  return mantissa(color.r) | mantissa(color.g) << 9 | mantissa(color.b) << 18 |
         static_cast<uint32_t>(exponent) << 27;
}

glm::vec3 unpack_rgb9e5(uint32_t packed) {
  const float step = std::ldexp(1.0f, static_cast<int>(packed >> 27) - kExponentBias - kMantissaBits);
  return step * glm::vec3(packed & 0x1ff, packed >> 9 & 0x1ff, packed >> 18 & 0x1ff);
}

glm::vec3 environment_direction(float u, float v) {
  const float around = (u - 0.5f) * 2 * kPi, down = v * kPi;
  return {std::sin(down) * std::sin(around), std::cos(down), -std::sin(down) * std::cos(around)};
}

EnvironmentImage make_environment(uint32_t width, uint32_t height,
                                  const std::function<glm::vec3(const glm::vec3& direction)>& radiance) {
  EnvironmentImage image;
  image.width = width;
  image.height = height;
  image.rgb9e5.reserve(size_t{width} * height);
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      image.rgb9e5.push_back(pack_rgb9e5(
          radiance(environment_direction((static_cast<float>(x) + 0.5f) / static_cast<float>(width),
                                         (static_cast<float>(y) + 0.5f) / static_cast<float>(height)))));
    }
  }
  return image;
}

EnvironmentImage studio_environment() {
  return make_environment(512, 256, studio_radiance);
}

float mean_radiance(const EnvironmentImage& image) {
  double sum = 0, weights = 0;
  for (uint32_t y = 0; y < image.height; ++y) {
    // Solid angle of a texel, up to a factor.
    const double weight = std::sin((y + 0.5) / image.height * static_cast<double>(kPi));
    double row = 0;
    for (uint32_t x = 0; x < image.width; ++x)
      row += glm::dot(unpack_rgb9e5(image.rgb9e5[size_t{y} * image.width + x]),
                      glm::vec3(0.2126f, 0.7152f, 0.0722f));
    sum += weight * row;
    weights += weight * image.width;
  }
  return weights > 0 ? static_cast<float>(sum / weights) * image.scale : 0;
}

namespace {

using Rgbe = std::array<uint8_t, 4>;

constexpr uint64_t kMaxBytes = 2ull * 4 * kMaxEnvironmentWidth * kMaxEnvironmentHeight;
constexpr size_t kMaxHeaderBytes = 64 << 10;

// Bounds-checked byte reader; all methods fail at the end.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  bool byte(uint8_t& value) {
    if (at_ == bytes_.size()) return false;
    value = static_cast<uint8_t>(bytes_[at_++]);
    return true;
  }
  bool pixel(Rgbe& value) { return byte(value[0]) && byte(value[1]) && byte(value[2]) && byte(value[3]); }
  // Header line without line feed.
  std::optional<std::string_view> line() {
    const size_t first = at_;
    while (at_ < std::min(bytes_.size(), kMaxHeaderBytes)) {
      if (bytes_[at_++] == std::byte{'\n'}) {
        std::string_view text(reinterpret_cast<const char*>(bytes_.data()) + first, at_ - 1 - first);
        if (text.ends_with('\r')) text.remove_suffix(1);
        return text;
      }
    }
    return std::nullopt;
  }

 private:
  std::span<const std::byte> bytes_;
  size_t at_ = 0;
};

struct Header {
  uint32_t width = 0, height = 0;
  float exposure = 1;
};

// Parses "-Y 512 +X 1024" (top row first, left to right). The other seven orientations do not occur in
// practice.
bool parse_size(std::string_view line, Header& header) {
  const char* end = line.data() + line.size();
  if (!line.starts_with("-Y ")) return false;
  const auto height = std::from_chars(line.data() + 3, end, header.height);
  constexpr std::string_view kBetween = " +X ";
  if (height.ec != std::errc() || !std::string_view(height.ptr, end).starts_with(kBetween)) return false;
  const auto width = std::from_chars(height.ptr + kBetween.size(), end, header.width);
  return width.ec == std::errc() && width.ptr == end;
}

Result<Header> read_header(Reader& reader, const std::string& name) {
  const std::optional<std::string_view> magic = reader.line();
  if (!magic || (*magic != "#?RADIANCE" && *magic != "#?RGBE")) {
    return Error{name + " is not a Radiance image; use an equirectangular .hdr file"};
  }
  Header header;
  bool format_known = false;
  for (;;) {
    const std::optional<std::string_view> line = reader.line();
    if (!line) return Error{name + ": the header does not end; save the file again"};
    if (line->empty()) break;
    if (line->starts_with("FORMAT=")) {
      if (line->substr(7) != "32-bit_rle_rgbe") {
        return Error{name + ": its format is " + quote(line->substr(7)) + "; save it as 32-bit_rle_rgbe"};
      }
      format_known = true;
    } else if (line->starts_with("EXPOSURE=")) {
      std::string_view text = line->substr(9);
      while (text.starts_with(' ')) text.remove_prefix(1);
      float exposure = 0;
      const auto parsed = std::from_chars(text.data(), text.data() + text.size(), exposure);
      if (parsed.ec != std::errc() || !(exposure > 1e-6f && exposure < 1e6f)) {
        return Error{name + ": its exposure " + quote(text) + " is no number between 1e-6 and 1e6"};
      }
      header.exposure *= exposure;
    }
  }
  if (!format_known) return Error{name + ": the header lacks FORMAT=32-bit_rle_rgbe; save the file again"};
  const std::optional<std::string_view> size = reader.line();
  if (!size || !parse_size(*size, header)) {
    return Error{name + ": the size is to read \"-Y HEIGHT +X WIDTH\"" +
                 (size ? ", not " + quote(*size) : std::string()) + "; save the file again"};
  }
  if (header.width == 0 || header.height == 0 || header.width > kMaxEnvironmentWidth ||
      header.height > kMaxEnvironmentHeight) {
    return Error{name + " is " + std::to_string(header.width) + " x " + std::to_string(header.height) +
                 " pixels large; from 1 x 1 to " + std::to_string(kMaxEnvironmentWidth) + " x " +
                 std::to_string(kMaxEnvironmentHeight) + " are read"};
  }
  if (!(header.exposure > 1e-6f && header.exposure < 1e6f))
    return Error{name + ": its exposures multiply beyond 1e6"};
  return header;
}

// RLE format: the four components of a row as separate run-length encoded planes.
bool read_planes(Reader& reader, std::span<Rgbe> row) {
  for (size_t plane = 0; plane < 4; ++plane) {
    for (size_t x = 0; x < row.size();) {
      uint8_t count = 0, value = 0;
      if (!reader.byte(count) || count == 0) return false;
      const bool run = count > 128;
      const size_t length = run ? count - 128 : count;
      if (length > row.size() - x || (run && !reader.byte(value))) return false;
      for (const size_t end = x + length; x < end; ++x) {
        if (!run && !reader.byte(value)) return false;
        row[x][plane] = value;
      }
    }
  }
  return true;
}

// Old RLE format: pixels (1, 1, 1, N) repeat the previous pixel; consecutive ones extend the count by 8 bits
// each.
bool read_pixels(Reader& reader, std::span<Rgbe> row, const Rgbe& first) {
  Rgbe pixel = first;
  unsigned shift = 0;
  for (size_t x = 0; x < row.size();) {
    if (pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1) {
      if (x == 0 || shift > 16) return false;
      const size_t length = size_t{pixel[3]} << shift;
      if (length > row.size() - x) return false;
      std::fill_n(row.begin() + static_cast<ptrdiff_t>(x), length, row[x - 1]);
      x += length;
      shift += 8;
    } else {
      row[x++] = pixel;
      shift = 0;
    }
    if (x < row.size() && !reader.pixel(pixel)) return false;
  }
  return true;
}

bool read_row(Reader& reader, std::span<Rgbe> row) {
  Rgbe first{};
  if (!reader.pixel(first)) return false;
  const bool planes =
      row.size() >= 8 && row.size() < 32768 && first[0] == 2 && first[1] == 2 && first[2] < 128;
  if (!planes) return read_pixels(reader, row, first);
  return (size_t{first[2]} << 8 | first[3]) == row.size() && read_planes(reader, row);
}

glm::vec3 radiance_of(const Rgbe& pixel, float factor) {
  if (pixel[3] == 0) return glm::vec3(0);
  return glm::vec3(pixel[0], pixel[1], pixel[2]) * (std::ldexp(1.0f, pixel[3] - 136) * factor);
}

}  // namespace

Result<EnvironmentImage> decode_radiance_file(std::span<const std::byte> bytes, const std::string& name) {
  Reader reader(bytes);
  Result<Header> header = read_header(reader, name);
  if (!header) return header.error();
  // A row has at least 4 bytes: a small file must not claim gigabytes.
  if (bytes.size() / 4 < header->height) return Error{name + " ends early; copy or save it again"};

  std::vector<Rgbe> pixels(size_t{header->width} * header->height);
  uint8_t largest_exponent = 0;
  for (uint32_t y = 0; y < header->height; ++y) {
    const std::span<Rgbe> row = std::span(pixels).subspan(size_t{y} * header->width, header->width);
    if (!read_row(reader, row)) {
      return Error{name + ": row " + std::to_string(y) +
                   " is damaged or missing; copy or save the file again"};
    }
    for (const Rgbe& pixel : row) largest_exponent = std::max(largest_exponent, pixel[3]);
  }

  // Scales images with values above the packed format (the sun). The scale is limited to preserve precision
  // of the rest.
  constexpr int kMaxScaleExponent = 10;
  EnvironmentImage image;
  image.width = header->width;
  image.height = header->height;
  const float brightest = std::ldexp(1.0f, largest_exponent - 128) / header->exposure;
  if (brightest > kMaxRgb9e5)
    image.scale = std::ldexp(1.0f, std::min(std::ilogb(brightest) - 15, kMaxScaleExponent));
  image.rgb9e5.reserve(pixels.size());
  const float factor = 1 / (header->exposure * image.scale);
  for (const Rgbe& pixel : pixels) image.rgb9e5.push_back(pack_rgb9e5(radiance_of(pixel, factor)));
  return image;
}

Result<EnvironmentImage> load_environment(const std::filesystem::path& path) {
  Result<FileBytes> bytes = read_file(path, kMaxBytes);
  if (!bytes) return bytes.error();
  try {
    return decode_radiance_file(bytes->view(), path.string());
  } catch (const std::bad_alloc&) {
    return Error{path.string() + " does not fit into memory; make the environment smaller"};
  }
}

}  // namespace fire3dv::scene
