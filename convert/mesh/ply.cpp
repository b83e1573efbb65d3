#include "convert/mesh/ply.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/plural.h"
#include "base/words.h"
#include "convert/mesh/geometry/triangulate.h"
#include "convert/mesh/mesh_store.h"
#include "convert/mesh/text/mesh_text.h"

namespace fire3dv::convert {
namespace {

constexpr size_t kMaxPlyTriangles = 20'000'000, kMaxProperties = 100;

enum class Format { ascii, little, big };

// Size in bytes and kind of a number.
struct Type {
  size_t size = 0;
  bool is_float = false, is_signed = false;
};

std::optional<Type> type_of(std::string_view name) {
  static constexpr std::pair<std::string_view, Type> kTypes[] = {
      {"char", {1, false, true}},    {"int8", {1, false, true}},    {"uchar", {1, false, false}},
      {"uint8", {1, false, false}},  {"short", {2, false, true}},   {"int16", {2, false, true}},
      {"ushort", {2, false, false}}, {"uint16", {2, false, false}}, {"int", {4, false, true}},
      {"int32", {4, false, true}},   {"uint", {4, false, false}},   {"uint32", {4, false, false}},
      {"float", {4, true, true}},    {"float32", {4, true, true}},  {"double", {8, true, true}},
      {"float64", {8, true, true}}};
  for (const auto& [known, type] : kTypes)
    if (known == name) return type;
  return std::nullopt;
}

struct Property {
  std::string name;
  Type type;
  std::optional<Type> count_type;  // of a list
};
struct ElementList {
  std::string name;
  uint64_t count = 0;
  std::vector<Property> properties;
};

// Reads numbers one after the other. ok() is false once data is missing or malformed.
class Numbers {
 public:
  Numbers(std::string_view bytes, Format format, char line_end)
      : rest_(bytes), format_(format), line_end_(line_end) {}

  bool ok() const { return ok_; }

  // Lines of text with numbers in them.
  uint64_t lines() const {
    uint64_t count = 0;
    for (std::string_view text = rest_; !text.empty();) {
      const std::string_view line = text.substr(0, text.find(line_end_));
      text.remove_prefix(std::min(line.size() + 1, text.size()));
      const size_t first = line.find_first_not_of(" \t\r\n");
      count += first != std::string_view::npos && !line.substr(first).starts_with(kComment) ? 1 : 0;
    }
    return count;
  }

  void end_line() { rest_.remove_prefix(std::min(rest_.find(line_end_), rest_.size())); }

  size_t bytes_left() const { return rest_.size(); }

  double next(const Type& type) {
    if (format_ == Format::ascii) {
      constexpr std::string_view kSpace = " \t\r\n";
      rest_.remove_prefix(std::min(rest_.find_first_not_of(kSpace), rest_.size()));
      while (rest_.starts_with(kComment)) {
        end_line();
        rest_.remove_prefix(std::min(rest_.find_first_not_of(kSpace), rest_.size()));
      }
      const std::optional<double> value = number_of(next_word(rest_));
      ok_ = ok_ && value;
      return value.value_or(0);
    }
    uint64_t bits = 0;
    if (rest_.size() < type.size) {
      ok_ = false;
      return 0;
    }
    for (size_t i = 0; i < type.size; ++i) {
      const size_t from = format_ == Format::little ? type.size - 1 - i : i;
      bits = bits << 8 | static_cast<unsigned char>(rest_[from]);
    }
    rest_.remove_prefix(type.size);
    if (type.is_float)
      return type.size == 8 ? std::bit_cast<double>(bits) : std::bit_cast<float>(static_cast<uint32_t>(bits));
    if (!type.is_signed) return static_cast<double>(bits);
    const size_t unused = 64 - 8 * type.size;
    return static_cast<double>(static_cast<int64_t>(bits << unused) >> unused);
  }

 private:
  static constexpr std::string_view kComment = "comment";
  std::string_view rest_;
  Format format_;
  char line_end_;
  bool ok_ = true;
};

class PlyReader {
 public:
  explicit PlyReader(Nodes nodes) : keeps_nodes_(nodes == Nodes::keep) {}

  Result<ImportedMesh> read(std::string_view bytes) {
    if (Result<void> header = read_header(bytes); !header) return header.error();
    Numbers numbers(bytes, format_, line_end_);
    uint64_t items = 0;
    for (const ElementList& element : elements_) items += element.count;
    // In the usual text each item is a line, whose end may have more numbers than the header says.
    const bool has_lines = format_ == Format::ascii && numbers.lines() == items;
    for (const ElementList& element : elements_) {
      // Each item takes a byte at least, so that the count is bounded by the file.
      if (element.properties.empty() || element.count > numbers.bytes_left()) return cut_short();
      for (uint64_t i = 0; i < element.count; ++i) {
        read_element(element, numbers);
        if (has_lines) numbers.end_line();
        if (!numbers.ok()) return cut_short();
        if (indices_.size() / 3 > kMaxPlyTriangles)
          return Error{"it has more than " + std::to_string(kMaxPlyTriangles) + " triangles"};
      }
    }
    return mesh();
  }

 private:
  static Error cut_short() { return Error{"the PLY file is cut short or damaged"}; }

  Result<void> read_header(std::string_view& bytes) {
    // Old programs of Apple's end lines by carriage returns alone.
    const size_t first_end = bytes.find_first_of("\r\n");
    const bool is_return = first_end != std::string_view::npos && bytes[first_end] == '\r' &&
                           bytes.substr(first_end + 1, 1) != "\n";
    line_end_ = is_return ? '\r' : '\n';
    for (size_t line_count = 0; line_count < 10'000; ++line_count) {
      const size_t end = bytes.find(line_end_);
      if (end == std::string_view::npos) break;
      std::string_view line = bytes.substr(0, end);
      bytes.remove_prefix(end + 1);
      const std::string_view word = next_word(line);
      if (line_count == 0 && word != "ply") break;
      if (word == "end_header") return {};
      if (word == "comment" && keeps_nodes_ && next_word(line) == "TextureFile") {
        image_ = std::string(line.substr(std::min(line.find_first_not_of(' '), line.size())));
        while (image_.ends_with('\r') || image_.ends_with(' ')) image_.pop_back();
      }
      if (word == "format") {
        const std::string_view name = next_word(line);
        format_ = name == "ascii"                  ? Format::ascii
                  : name == "binary_little_endian" ? Format::little
                                                   : Format::big;
      } else if (word == "element") {
        ElementList element;
        element.name = next_word(line);
        const std::string_view count = next_word(line);
        if (std::from_chars(count.data(), count.data() + count.size(), element.count).ec != std::errc())
          break;
        elements_.push_back(std::move(element));
      } else if (word == "property") {
        if (elements_.empty() || elements_.back().properties.size() >= kMaxProperties) break;
        Property property;
        std::string_view name = next_word(line);
        if (name == "list") {
          property.count_type = type_of(next_word(line));
          if (!property.count_type) break;
          name = next_word(line);
        }
        const std::optional<Type> type = type_of(name);
        if (!type) break;
        property.type = *type;
        property.name = next_word(line);
        elements_.back().properties.push_back(std::move(property));
      }
    }
    return Error{"its PLY header is damaged"};
  }

  // Returns the numbers of a property: one, or those of a list. Valid until the next call.
  const std::vector<double>& read_property(const Property& property, Numbers& numbers) {
    values_.clear();
    const double count = property.count_type ? numbers.next(*property.count_type) : 1;
    for (double i = 0; i < count && numbers.ok(); ++i) values_.push_back(numbers.next(property.type));
    return values_;
  }

  void read_vertex(const ElementList& element, Numbers& numbers) {
    SurfaceBuilder::Corner corner;
    for (const Property& property : element.properties) {
      const std::vector<double>& values = read_property(property, numbers);
      const float value = values.empty() ? 0 : static_cast<float>(values[0]);
      const std::string& name = property.name;
      if (name == "x" || name == "y" || name == "z") corner.position[name[0] - 'x'] = value;
      if (name == "nx" || name == "ny" || name == "nz") {
        corner.normal[name[1] - 'x'] = value;
        has_normals_ = true;
      }
      const bool is_u = name == "s" || name == "u" || name == "texture_u";
      if (is_u || name == "t" || name == "v" || name == "texture_v") {
        (is_u ? corner.uv.x : corner.uv.y) = std::isfinite(value) ? (is_u ? value : 1 - value) : 0;
        has_uvs_ = true;
      }
      if (keeps_nodes_) read_color(property, value, corner.color, of_vertices_);
    }
    corners_.push_back(corner);
  }

  // Colours that were met: of vertices or of faces.
  struct ColorKind {
    bool is_there = false, has_opacity = false;
  };

  // red, green, blue and alpha, also with the prefix diffuse_, or as letters; integers end at their largest
  // value.
  static void read_color(const Property& property, float value, glm::vec4& color, ColorKind& kind) {
    std::string_view name = property.name;
    if (name.starts_with("diffuse_")) name.remove_prefix(8);
    constexpr std::string_view kNames[] = {"red", "green", "blue", "alpha", "r", "g", "b", "a"};
    const auto* known = std::find(std::begin(kNames), std::end(kNames), name);
    if (known == std::end(kNames)) return;
    const Type& type = property.type;
    const double most = type.is_float ? 1 : std::exp2(8.0 * static_cast<double>(type.size)) - 1;
    const auto channel = static_cast<int>(known - std::begin(kNames)) % 4;
    color[channel] = std::isfinite(value) ? std::clamp(static_cast<float>(value / most), 0.0f, 1.0f) : 0;
    if (channel < 3) kind.is_there = true;
    if (channel == 3 && color[channel] > 0) kind.has_opacity = true;
  }

  static bool is_index_list(const Property& property) {
    return property.count_type && (property.name == "vertex_indices" || property.name == "vertex_index" ||
                                   property.name == "vertex_indexes");
  }

  // Vertex number of an untrusted one; those out of range cause an error later.
  static uint32_t checked(double index) {
    return index >= 0 && index < kNoVertex ? static_cast<uint32_t>(index) : kNoVertex;
  }

  void read_face(const ElementList& element, Numbers& numbers) {
    Face face;
    face.number = ++face_count_;
    face.first = indices_.size();
    for (const Property& property : element.properties) {
      const std::vector<double>& values = read_property(property, numbers);
      if (is_index_list(property)) {
        for (const double index : values) indices_.push_back(checked(index));
      } else if (property.name == "texcoord") {  // of the face's corners, as MeshLab writes them
        face.first_uv = face_uvs_.size();
        for (size_t i = 0; i + 1 < values.size(); i += 2) {
          const glm::vec2 uv(static_cast<float>(values[i]), static_cast<float>(1 - values[i + 1]));
          face_uvs_.push_back(std::isfinite(uv.x + uv.y) ? uv : glm::vec2(0));
        }
      } else if (keeps_nodes_) {
        read_color(property, values.empty() ? 0 : static_cast<float>(values[0]), face.color, of_faces_);
      }
    }
    face.count = indices_.size() - face.first;
    const bool has_uvs = face.count > 0 && face_uvs_.size() - face.first_uv == face.count;
    if (!has_uvs) face.first_uv = kNoUvs;
    has_face_uvs_ = has_face_uvs_ || has_uvs;
    if (face.count >= 3) faces_.push_back(face);
  }

  // Triangle strips, as Stanford's files have them: -1 begins another one.
  void read_strips(const ElementList& element, Numbers& numbers) {
    for (const Property& property : element.properties) {
      const std::vector<double>& values = read_property(property, numbers);
      if (!is_index_list(property)) continue;
      for (size_t first = 0, i = 0; i < values.size(); ++i) {
        if (values[i] < 0) first = i + 1;
        if (i < first + 2) continue;
        const bool is_odd = (i - first) % 2 == 1;
        Face face;
        face.number = ++face_count_;
        face.first = indices_.size();
        face.count = 3;
        for (const size_t at : {i - 2, is_odd ? i : i - 1, is_odd ? i - 1 : i})
          indices_.push_back(checked(values[at]));
        const uint32_t* const corner = &indices_[face.first];
        // Strips turn by naming a vertex twice.
        if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0])
          indices_.resize(face.first);
        else
          faces_.push_back(face);
      }
    }
  }

  void read_element(const ElementList& element, Numbers& numbers) {
    if (element.name == "vertex") {
      read_vertex(element, numbers);
    } else if (element.name == "face") {
      read_face(element, numbers);
    } else if (element.name == "tristrips") {
      read_strips(element, numbers);
    } else {
      for (const Property& property : element.properties) read_property(property, numbers);
    }
  }

  Result<ImportedMesh> mesh() {
    const bool has_colors = of_vertices_.is_there || of_faces_.is_there;
    const bool has_uvs = has_uvs_ || has_face_uvs_;
    SurfaceBuilder builder(has_normals_, has_uvs, has_colors);
    PolygonTriangulator polygons;
    std::vector<glm::dvec3> polygon;
    size_t left_out = 0, first_left_out = 0;
    for (const Face& face : faces_) {
      polygon.clear();
      for (size_t i = face.first; i < face.first + face.count; ++i) {
        if (indices_[i] >= corners_.size()) return Error{"a face names a vertex that it does not have"};
        polygon.emplace_back(corners_[indices_[i]].position);
      }
      const auto corner = [&](uint32_t number) {
        SurfaceBuilder::Corner made = corners_[indices_[face.first + number]];
        if (face.first_uv != kNoUvs) made.uv = face_uvs_[face.first_uv + number];
        // Colours of vertices win, as in MeshLab.
        if (of_vertices_.is_there)
          made.color = visible_color(made.color, of_vertices_);
        else if (of_faces_.is_there)
          made.color = visible_color(face.color, of_faces_);
        return made;
      };
      const bool is_finite = std::all_of(polygon.begin(), polygon.end(), [](const glm::dvec3& p) {
        return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
      });
      if (!is_finite) {
        if (left_out++ == 0) first_left_out = face.number;
        continue;
      }
      for (const auto& [a, b, c] : polygons.triangulate(polygon))
        (void)builder.add(corner(a), corner(b), corner(c));
    }
    const std::string not_finite = "a vertex is not finite, or too far away for a number of 32 bits";
    ImportedMesh mesh;
    mesh.materials.emplace_back();
    mesh.materials[0].diffuse = glm::vec3(0.7f);
    mesh.materials[0].is_default = true;
    mesh.surfaces.push_back(builder.take());
    if (mesh.surfaces[0].indices.empty() && left_out > 0) return Error{not_finite};
    if (left_out > 0)
      mesh.warnings.push_back(counted(left_out, "face") + " left out (first is face " +
                              std::to_string(first_left_out) + "): " + not_finite);
    if (mesh.surfaces[0].indices.empty())
      return Error{std::string("there is no triangle in it") +
                   (corners_.empty() ? "" : ": point clouds are not drawn; make a mesh, as with MeshLab")};
    if (keeps_nodes_) {
      mesh.nodes.emplace_back();
      mesh.surface_nodes.push_back(0);
    }
    if (!image_.empty()) mesh.materials[0].diffuse_image = image_;
    if (!image_.empty()) mesh.materials[0].diffuse = glm::vec3(1);
    if (std::string crossing = polygons.warning(); !crossing.empty())
      mesh.warnings.push_back(std::move(crossing));
    return mesh;
  }

  // Scanners write an opacity of 0 everywhere: it means nothing.
  static glm::vec4 visible_color(const glm::vec4& color, const ColorKind& kind) {
    glm::vec4 linear = linear_from_srgb(color);
    if (!kind.has_opacity) linear.a = 1;
    return linear;
  }

  Format format_ = Format::ascii;
  char line_end_ = '\n';
  std::vector<ElementList> elements_;
  std::vector<SurfaceBuilder::Corner> corners_;
  static constexpr uint32_t kNoVertex = UINT32_MAX;
  static constexpr size_t kNoUvs = SIZE_MAX;
  struct Face {
    size_t first = 0, count = 0;  // corners in indices_
    size_t first_uv = kNoUvs;     // in face_uvs_
    size_t number = 0;            // from 1, in the file
    glm::vec4 color{1};
  };
  std::vector<Face> faces_;
  size_t face_count_ = 0;          // also of those with fewer than three corners
  std::vector<uint32_t> indices_;  // vertex numbers, unchecked
  std::vector<glm::vec2> face_uvs_;
  std::vector<double> values_;
  bool has_normals_ = false, has_uvs_ = false, has_face_uvs_ = false;
  ColorKind of_vertices_, of_faces_;
  const bool keeps_nodes_;
  std::string image_;  // name in the header, as MeshLab writes it
};

}  // namespace

Result<ImportedMesh> import_ply(std::string_view bytes, Nodes nodes) {
  return PlyReader(nodes).read(bytes);
}

}  // namespace fire3dv::convert
