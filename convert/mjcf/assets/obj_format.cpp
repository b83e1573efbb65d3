// Wavefront OBJ.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "base/words.h"
#include "convert/mesh/geometry/triangulate.h"
#include "convert/mjcf/assets/mesh_data.h"

namespace fire3dv::convert {
namespace {

constexpr std::string_view kLineBlanks = " \t\v\f";
constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();

class ObjParser {
 public:
  Result<MeshData> parse(std::string_view text) {
    while (!text.empty()) {
      const size_t end = std::min(text.find_first_of("\r\n"), text.size());
      std::string_view line = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      ++line_;
      if (Result<void> done = take_line(line); !done)
        return Error{"the OBJ file, " + std::to_string(line_) + ". line: " + done.error().message};
    }
    // Attributes that only some corners have are left out.
    triangulate();
    if (Result<void> done = check_mesh_data(mesh_); !done) return done.error();
    return std::move(mesh_);
  }

 private:
  struct Corner {
    uint32_t vertex = kNone, uv = kNone, normal = kNone;
  };

  Result<void> take_line(std::string_view line) {
    const std::string_view kind = next_word(line, kLineBlanks);
    if (kind == "v") return take_vector(line, mesh_.vertices);
    if (kind == "vn") return take_vector(line, mesh_.normals);
    if (kind == "vt") return take_uv(line);
    if (kind == "f") return take_face(line);
    return {};
  }

  static Result<float> number(std::string_view word) {
    if (word.starts_with('+')) word.remove_prefix(1);
    float value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error == std::errc::result_out_of_range) return 0.0f;  // denormal
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
      return Error{"a number is missing or malformed"};
    return value;
  }

  static Result<void> take_vector(std::string_view line, std::vector<glm::vec3>& to) {
    glm::vec3 v;
    for (int i = 0; i < 3; ++i) {
      const Result<float> value = number(next_word(line, kLineBlanks));
      if (!value) return value.error();
      v[i] = *value;
    }
    to.push_back(v);
    return {};
  }

  Result<void> take_uv(std::string_view line) {
    const Result<float> u = number(next_word(line, kLineBlanks));
    if (!u) return u.error();
    const std::string_view second = next_word(line, kLineBlanks);
    const Result<float> v = second.empty() ? Result<float>(0.0f) : number(second);
    if (!v) return v.error();
    mesh_.uvs.emplace_back(*u, 1 - *v);  // OBJ counts v from the lower edge
    return {};
  }

  // Indices count from 1; negative ones from the last element.
  static Result<uint32_t> index(std::string_view word, size_t count, const char* kind) {
    int64_t number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc() || end != word.data() + word.size() || number == 0)
      return Error{"a face names a " + std::string(kind) + " by something else than a number"};
    const int64_t from_zero = number > 0 ? number - 1 : static_cast<int64_t>(count) + number;
    // Elements may follow the face; check_mesh_data checks the upper limit.
    if (from_zero < 0 || from_zero >= int64_t{kNone})
      return Error{"a face names " + std::string(kind) + " " + std::string(word) + ", which does not exist"};
    return static_cast<uint32_t>(from_zero);
  }

  Result<Corner> corner(std::string_view word) const {
    std::array<std::string_view, 3> parts;
    for (std::string_view& part : parts) {
      const size_t end = std::min(word.find('/'), word.size());
      part = word.substr(0, end);
      word.remove_prefix(std::min(end + 1, word.size()));
    }
    Corner made;
    const Result<uint32_t> vertex = index(parts[0], mesh_.vertices.size(), "vertex");
    if (!vertex) return vertex.error();
    made.vertex = *vertex;
    if (!parts[1].empty()) {
      const Result<uint32_t> uv = index(parts[1], mesh_.uvs.size(), "texture coordinate");
      if (!uv) return uv.error();
      made.uv = *uv;
    }
    if (!parts[2].empty()) {
      const Result<uint32_t> normal = index(parts[2], mesh_.normals.size(), "normal");
      if (!normal) return normal.error();
      made.normal = *normal;
    }
    return made;
  }

  // Vertices may follow the faces that name them, so polygons are kept until the end.
  Result<void> take_face(std::string_view line) {
    const size_t first = corners_.size();
    for (std::string_view word = next_word(line, kLineBlanks); !word.empty();
         word = next_word(line, kLineBlanks)) {
      const Result<Corner> next = corner(word);
      if (!next) return next.error();
      lacks_uvs_ = lacks_uvs_ || next->uv == kNone;
      lacks_normals_ = lacks_normals_ || next->normal == kNone;
      corners_.push_back(*next);
    }
    face_ends_.push_back(corners_.size());
    return corners_.size() - first < 3 ? Result<void>(Error{"a face has fewer than three vertices"})
                                       : Result<void>();
  }

  void triangulate() {
    PolygonTriangulator polygons;
    std::vector<glm::dvec3> polygon;
    size_t first = 0;
    for (const size_t end : face_ends_) {
      polygon.clear();
      for (size_t i = first; i < end; ++i) {
        const uint32_t vertex = corners_[i].vertex;  // check_mesh_data refuses others
        polygon.emplace_back(vertex < mesh_.vertices.size() ? mesh_.vertices[vertex] : glm::vec3(0));
      }
      const Corner* const corners = &corners_[first];
      for (const auto& [a, b, c] : polygons.triangulate(polygon)) {
        mesh_.faces.push_back({corners[a].vertex, corners[b].vertex, corners[c].vertex});
        if (!lacks_uvs_) mesh_.uv_faces.push_back({corners[a].uv, corners[b].uv, corners[c].uv});
        if (!lacks_normals_)
          mesh_.normal_faces.push_back({corners[a].normal, corners[b].normal, corners[c].normal});
      }
      first = end;
    }
  }

  std::vector<Corner> corners_;
  std::vector<size_t> face_ends_;  // in corners_
  MeshData mesh_;
  size_t line_ = 0;
  bool lacks_uvs_ = false, lacks_normals_ = false;
};

}  // namespace

Result<MeshData> parse_obj(std::string_view text) {
  return ObjParser().parse(text);
}

}  // namespace fire3dv::convert
