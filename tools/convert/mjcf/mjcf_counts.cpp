#include "tools/convert/mjcf/mjcf_counts.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <optional>
#include <sstream>
#include <vector>

namespace fire3dv::convert {
namespace {

constexpr uint64_t kMaxCount = INT32_MAX;  // libmujoco counts with 32-bit integers

Error lies() {
  return Error{"has counts that differ from its contents; export it again"};
}

Error too_large(const char* those) {
  return Error{"has, with the " + std::string(those) +
               " before it, more than 2147483647 numbers: use smaller ones"};
}

template <typename T>
T at(std::string_view bytes, uint64_t place) {
  T value;
  std::memcpy(&value, bytes.data() + place, sizeof value);
  return value;
}

uint64_t product(std::initializer_list<uint64_t> factors) {
  uint64_t all = 1;
  for (const uint64_t factor : factors)
    if (__builtin_mul_overflow(all, factor, &all)) return UINT64_MAX;
  return all;
}

Result<void> add(uint64_t& sum, uint64_t more, const char* those) {
  if (more > kMaxCount || sum + more > kMaxCount) return too_large(those);
  sum += more;
  return {};
}

Result<void> check_faces(const std::vector<int32_t>& faces, uint64_t corners) {
  for (const int32_t corner : faces) {
    if (corner < 0 || static_cast<uint64_t>(corner) >= corners)
      return Error{"has a face that names corner " + std::to_string(corner) + " of " +
                   std::to_string(corners) + ", counted from 0; export it again"};
  }
  return {};
}

// The caller has checked the bounds.
std::vector<int32_t> faces_at(std::string_view bytes, uint64_t place, uint64_t count) {
  std::vector<int32_t> faces(3 * count);
  if (count > 0) std::memcpy(faces.data(), bytes.data() + place, 12 * count);
  return faces;
}

// Reads the four counts at the start of both formats.
std::optional<std::vector<uint64_t>> head(std::string_view bytes) {
  std::vector<uint64_t> counts;
  for (uint64_t i = 0; i < 4; ++i) {
    if (bytes.size() < 4 * (i + 1) || at<int32_t>(bytes, 4 * i) < 0) return std::nullopt;
    counts.push_back(at<uint32_t>(bytes, 4 * i));
  }
  return counts;
}

struct Size {
  uint64_t width = 0, height = 0;
};

// Empty: not a PNG; libmujoco reports it.
std::optional<Size> png_size(std::string_view bytes) {
  if (bytes.size() < 24 || bytes.substr(12, 4) != "IHDR") return std::nullopt;
  const auto side = [&](uint64_t place) {
    uint64_t value = 0;
    for (uint64_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[place + i]);
    return value;
  };
  return Size{side(16), side(20)};
}

// MuJoCo's own formats: two counts, then width * height numbers.
std::optional<Size> data_size(std::string_view bytes, uint64_t number_bytes) {
  if (bytes.size() < 8) return std::nullopt;
  const Size size{at<uint32_t>(bytes, 0), at<uint32_t>(bytes, 4)};
  if (product({size.width, size.height, number_bytes}) != bytes.size() - 8) return std::nullopt;
  return size;
}

// A cube map stored as one image has at most six faces of the smaller side.
uint64_t texture_bytes(const Size& size, MjcfTotals::Texture kind) {
  const uint64_t smaller = std::min(size.width, size.height);
  const uint64_t flat = product({3, size.width, size.height});
  return kind == MjcfTotals::Texture::flat ? flat : std::max(flat, product({18, smaller, smaller}));
}

}  // namespace

Result<void> check_msh(std::string_view bytes) {
  const auto counts = head(bytes);
  if (!counts) return lies();
  const uint64_t corners = (*counts)[0], normals = (*counts)[1], places = (*counts)[2], faces = (*counts)[3];
  const uint64_t first_face = 16 + 12 * corners + 12 * normals + 8 * places;
  if (bytes.size() != first_face + 12 * faces) return lies();
  for (uint64_t i = 0; i < 3 * corners; ++i) {
    constexpr float kMaxCoordinate = 1 << 30;  // libmujoco's limit for STL
    if (!(std::abs(at<float>(bytes, 16 + 4 * i)) <= kMaxCoordinate))
      return Error{"has a corner that is not finite, or beyond 2^30; export it again"};
  }
  return check_faces(faces_at(bytes, first_face, faces), corners);
}

Result<void> check_skn(std::string_view bytes) {
  const auto counts = head(bytes);
  if (!counts) return lies();
  const uint64_t corners = (*counts)[0], places = (*counts)[1], faces = (*counts)[2], bones = (*counts)[3];
  const uint64_t first_face = 16 + 12 * corners + 8 * places;
  uint64_t end = first_face + 12 * faces;
  if (end > bytes.size()) return lies();
  if (Result<void> done = check_faces(faces_at(bytes, first_face, faces), corners); !done) return done;
  constexpr uint64_t kBone = 72, kBoneCorner = 8;  // bone record: name, pose, vertex count; then 8 bytes per
                                                   // vertex
  if (bones > (bytes.size() - end) / kBone) return lies();
  for (uint64_t bone = 0; bone < bones; ++bone) {
    if (bytes.size() - end < kBone) return lies();
    const auto moved = at<int32_t>(bytes, end + kBone - 4);
    end += kBone;
    if (moved < 0 || static_cast<uint64_t>(moved) > (bytes.size() - end) / kBoneCorner) return lies();
    end += kBoneCorner * static_cast<uint64_t>(moved);
  }
  return end == bytes.size() ? Result<void>() : lies();
}

Result<void> check_inline_faces(const std::string& vertex, const std::string& face) {
  // Reads up to the first word that is not a number, like libmujoco.
  uint64_t numbers = 0;
  std::istringstream vertices(vertex), corners(face);
  for (float number = 0; vertices >> number;) ++numbers;
  std::vector<int32_t> faces;
  for (int32_t corner = 0; corners >> corner;) faces.push_back(corner);
  return check_faces(faces, numbers / 3);
}

Result<void> MjcfTotals::add_field(std::string_view bytes, bool is_png, uint64_t times) {
  const auto size = is_png ? png_size(bytes) : data_size(bytes, 4);
  if (!size) return is_png ? Result<void>() : lies();
  return add(cells_, product({times, size->width, size->height}), "height fields");
}

Result<void> MjcfTotals::add_texture(std::string_view bytes, bool is_png, Texture kind, uint64_t times) {
  const auto size = is_png ? png_size(bytes) : data_size(bytes, 3);
  if (!size) return is_png ? Result<void>() : lies();
  const uint64_t bytes_made = texture_bytes(*size, kind);
  if (kind != Texture::further_side) return add(texture_bytes_, product({times, bytes_made}), "textures");
  uint64_t alone = 0;
  return add(alone, bytes_made, "textures");
}

Result<void> MjcfTotals::add_field(int64_t rows, int64_t columns) {
  if (rows < 1 || columns < 1) return {};
  return add(cells_, product({static_cast<uint64_t>(rows), static_cast<uint64_t>(columns)}), "height fields");
}

Result<void> MjcfTotals::add_texture(int64_t width, int64_t height, Texture kind) {
  if (width < 1 || height < 1) return {};
  const auto side = static_cast<uint64_t>(width);
  const Size size{side, kind == Texture::flat ? static_cast<uint64_t>(height) : side};
  return add(texture_bytes_, texture_bytes(size, kind), "textures");
}

}  // namespace fire3dv::convert
