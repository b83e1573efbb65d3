#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "base/text.h"
#include "renderer/scene/textures/environment.h"

namespace fire3dv::scene {
namespace {

using Rgbe = std::array<uint8_t, 4>;

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
  if (auto fits = check_environment_size(header.width, header.height, name); !fits) return fits.error();
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

bool is_radiance_file(std::span<const std::byte> bytes) {
  return bytes.size() >= 2 && bytes[0] == std::byte{'#'} && bytes[1] == std::byte{'?'};
}

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

  EnvironmentImage image;
  image.width = header->width;
  image.height = header->height;
  image.scale = environment_scale(std::ldexp(1.0f, largest_exponent - 128) / header->exposure);
  image.rgb9e5.reserve(pixels.size());
  const float factor = 1 / (header->exposure * image.scale);
  for (const Rgbe& pixel : pixels) image.rgb9e5.push_back(pack_rgb9e5(radiance_of(pixel, factor)));
  return image;
}

}  // namespace fire3dv::scene
