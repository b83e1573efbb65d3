#include "adapters/mujoco/compiled/model_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <optional>
#include <sstream>
#include <string>
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
T at(std::string_view bytes, uint64_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
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
std::vector<int32_t> faces_at(std::string_view bytes, uint64_t offset, uint64_t count) {
  std::vector<int32_t> faces(3 * count);
  if (count > 0) std::memcpy(faces.data(), bytes.data() + offset, 12 * count);
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
  const auto side = [&](uint64_t offset) {
    uint64_t value = 0;
    for (uint64_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[offset + i]);
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
  const uint64_t corners = (*counts)[0], normals = (*counts)[1], uvs = (*counts)[2], faces = (*counts)[3];
  const uint64_t first_face = 16 + 12 * corners + 12 * normals + 8 * uvs;
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
  const uint64_t corners = (*counts)[0], uvs = (*counts)[1], faces = (*counts)[2], bones = (*counts)[3];
  const uint64_t first_face = 16 + 12 * corners + 8 * uvs;
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

namespace {

enum Kind : size_t { corners, texture_coordinates, normals };
constexpr const char* kNames[] = {"corner", "texture coordinate", "normal"};

bool is_blank(char c) {
  return c == ' ' || c == '\t';
}

// Counts of vertex data, and the range of indices used.
class Faces {
 public:
  // line: without its line end.
  void take(std::string_view line) {
    line = line.substr(0, line.find('\0'));
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    if (line.size() < 2) return;
    if (line[0] == 'v' && is_blank(line[1])) ++count_[corners];
    if (line.size() > 2 && line[0] == 'v' && is_blank(line[2])) {
      if (line[1] == 't') ++count_[texture_coordinates];
      if (line[1] == 'n') ++count_[normals];
    }
    if ((line[0] == 'f' || line[0] == 'l' || line[0] == 'p') && is_blank(line[1])) {
      has_faces_ = has_faces_ || line[0] == 'f';
      rest_ = line.substr(2);
      for (skip_blanks(); !rest_.empty(); skip_blanks()) take_corner(line[0] == 'f');
    }
  }

  Result<void> check() const {
    for (const Kind kind : {corners, texture_coordinates, normals}) {
      if (lowest_[kind] >= 0 && highest_[kind] < count_[kind]) continue;
      const int64_t named = lowest_[kind] < 0 ? lowest_[kind] : highest_[kind] + 1;
      return Error{"names " + std::string(kNames[kind]) + " " + std::to_string(named) + " of " +
                   std::to_string(count_[kind]) + "; export the mesh again"};
    }
    for (const Kind kind : {texture_coordinates, normals}) {
      if (lacks_[kind] && count_[kind] > 0)
        return Error{"has a " + std::string(kNames[kind]) +
                     " for some corners of faces, and none for others; " +
                     "export the mesh with all or without any"};
    }
    return has_faces_ ? Result<void>() : check_points();
  }

 private:
  // Without faces, the parser takes all vertices in order, with one texture coordinate and normal each.
  Result<void> check_points() const {
    constexpr int64_t kLeastCorners = 4;  // minimum of a convex hull
    if (count_[corners] < kLeastCorners)
      return Error{"has no faces and only " + std::to_string(count_[corners]) +
                   " corners; export the mesh with its faces"};
    for (const Kind kind : {texture_coordinates, normals}) {
      if (count_[kind] != 0 && count_[kind] != count_[corners])
        return Error{"has no faces, " + std::to_string(count_[corners]) + " corners, and " +
                     std::to_string(count_[kind]) + " of the kind " + kNames[kind] +
                     "; export the mesh with its faces"};
    }
    return {};
  }

  void skip_blanks() { rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t"), rest_.size())); }

  // Parses "1", "1/2", "1/2/3" or "1//3".
  void take_corner(bool of_face) {
    std::array<bool, 3> has{};
    has[corners] = take_number(corners);
    if (take_slash()) {
      const bool none = take_slash();
      has[texture_coordinates] = !none && take_number(texture_coordinates);
      has[normals] = (none || take_slash()) && take_number(normals);
    }
    for (const Kind kind : {texture_coordinates, normals})
      lacks_[kind] = lacks_[kind] || (of_face && !has[kind]);
  }

  bool take_slash() {
    const bool is_slash = rest_.starts_with('/');
    if (is_slash) rest_.remove_prefix(1);
    return is_slash;
  }

  // Parses like atoi(), as the parser does, and skips the rest up to a blank or slash.
  bool take_number(Kind kind) {
    constexpr int64_t kMaxIndex = int64_t{1} << 40;
    const size_t end = std::min(rest_.find_first_of("/ \t"), rest_.size());
    std::string_view digits = rest_.substr(0, end);
    digits.remove_prefix(std::min(digits.find_first_not_of("\v\f"), digits.size()));
    const bool below = digits.starts_with('-');
    if (below || digits.starts_with('+')) digits.remove_prefix(1);
    int64_t number = 0;
    for (const char c : digits) {
      if (c < '0' || c > '9') break;
      number = std::min(10 * number + (c - '0'), kMaxIndex);
    }
    // Negative indices count from the last element; 0 is read as the first.
    const int64_t index = below ? count_[kind] - number : std::max<int64_t>(number - 1, 0);
    lowest_[kind] = std::min(lowest_[kind], index);
    highest_[kind] = std::max(highest_[kind], index);
    rest_.remove_prefix(end);
    return true;
  }

  std::string_view rest_;  // rest of the line
  std::array<int64_t, 3> count_{}, lowest_{}, highest_{-1, -1, -1};
  std::array<bool, 3> lacks_{};  // some face vertex lacks this kind
  bool has_faces_ = false;
};

// Splits "a\ b.mtl c.mtl" in both readings: "a\", "b.mtl", "c.mtl" and "a b.mtl", "c.mtl".
void add_names(std::string_view line, std::vector<std::string>& names) {
  for (const bool escapes : {false, true}) {
    std::string name;
    const auto end_name = [&] {
      if (!name.empty()) names.push_back(std::move(name));
      name.clear();
    };
    for (size_t i = 0; i < line.size(); ++i) {
      if (escapes && line[i] == '\\' && i + 1 < line.size())
        name += line[++i];
      else if (line[i] == ' ')
        end_name();
      else
        name += line[i];
    }
    end_name();
  }
}

}  // namespace

Result<void> check_obj_faces(std::string_view text) {
  Faces faces;
  while (!text.empty()) {
    const size_t end = std::min(text.find_first_of("\r\n"), text.size());
    faces.take(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return faces.check();
}

Result<std::vector<std::string>> obj_material_files(std::string_view text) {
  constexpr size_t kMaxNames = 1000;
  constexpr std::string_view kWord = "mtllib";
  std::vector<std::string> names;
  for (size_t at = text.find(kWord); at != text.npos; at = text.find(kWord, at + 1)) {
    size_t begin = at;
    while (begin > 0 && (text[begin - 1] == ' ' || text[begin - 1] == '\t')) --begin;
    if (begin > 0 && text[begin - 1] != '\n' && text[begin - 1] != '\r')
      continue;  // not at the start of a
                 // line
    const std::string_view rest = text.substr(at + kWord.size());
    if (rest.empty() || (rest[0] != ' ' && rest[0] != '\t')) continue;
    add_names(rest.substr(1, rest.find_first_of("\r\n") - 1), names);
    if (names.size() > kMaxNames)
      return Error{"names more than " + std::to_string(kMaxNames) + " files of materials"};
  }
  return names;
}

std::vector<std::filesystem::path> obj_material_paths(const std::string& mesh, const std::string& name) {
  const size_t end = mesh.find_last_of("/\\");
  if (end == mesh.npos || end == 0) return {name};
  std::istringstream folders(mesh.substr(0, end) + "/");
  std::vector<std::filesystem::path> paths;
  for (std::string folder; std::getline(folders, folder, ':');) {
    const bool needs_slash = !folder.empty() && folder.back() != '/';
    paths.emplace_back(folder + (needs_slash ? "/" : "") + name);
  }
  return paths;
}

}  // namespace fire3dv::convert
