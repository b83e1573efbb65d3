#include "convert/mesh/ply.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "convert/mesh/mesh_store.h"

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

std::string_view next_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
  const size_t end = std::min(line.find_first_of(" \t\r"), line.size());
  const std::string_view word = line.substr(0, end);
  line.remove_prefix(end);
  return word;
}

// Reads numbers one after the other. ok() is false once data is missing or malformed.
class Numbers {
 public:
  Numbers(std::string_view bytes, Format format) : rest_(bytes), format_(format) {}

  bool ok() const { return ok_; }
  size_t bytes_left() const { return rest_.size(); }

  double next(const Type& type) {
    if (format_ == Format::ascii) {
      constexpr std::string_view kSpace = " \t\r\n";
      rest_.remove_prefix(std::min(rest_.find_first_not_of(kSpace), rest_.size()));
      double value = 0;
      const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
      ok_ = ok_ && error == std::errc();
      rest_.remove_prefix(static_cast<size_t>(end - rest_.data()));
      return value;
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
  std::string_view rest_;
  Format format_;
  bool ok_ = true;
};

class PlyReader {
 public:
  explicit PlyReader(Nodes nodes) : keeps_nodes_(nodes == Nodes::keep) {}

  Result<ImportedMesh> read(std::string_view bytes) {
    if (Result<void> header = read_header(bytes); !header) return header.error();
    Numbers numbers(bytes, format_);
    for (const ElementList& element : elements_) {
      // Each item takes a byte at least, so that the count is bounded by the file.
      if (element.properties.empty() || element.count > numbers.bytes_left()) return cut_short();
      for (uint64_t i = 0; i < element.count; ++i) {
        if (element.name == "vertex")
          read_vertex(element, numbers);
        else
          read_other(element, numbers);
        if (!numbers.ok()) return cut_short();
        if (triangles_.size() / 3 > kMaxPlyTriangles)
          return Error{"it has more than " + std::to_string(kMaxPlyTriangles) + " triangles"};
      }
    }
    return mesh();
  }

 private:
  static Error cut_short() { return Error{"the PLY file is cut short or damaged"}; }

  Result<void> read_header(std::string_view& bytes) {
    for (size_t line_count = 0; line_count < 10'000; ++line_count) {
      const size_t end = bytes.find('\n');
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

  std::vector<double> read_property(const Property& property, Numbers& numbers) {
    if (!property.count_type) return {numbers.next(property.type)};
    const double count = numbers.next(*property.count_type);
    std::vector<double> values;
    for (double i = 0; i < count && numbers.ok(); ++i) values.push_back(numbers.next(property.type));
    return values;
  }

  void read_vertex(const ElementList& element, Numbers& numbers) {
    SurfaceBuilder::Corner corner;
    for (const Property& property : element.properties) {
      const std::vector<double> values = read_property(property, numbers);
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
      if (keeps_nodes_) read_color(property, value, corner.color);
    }
    corners_.push_back(corner);
  }

  // red, green, blue and alpha, also with the prefix diffuse_; integers end at their largest value.
  void read_color(const Property& property, float value, glm::vec4& color) {
    std::string_view name = property.name;
    if (name.starts_with("diffuse_")) name.remove_prefix(8);
    constexpr std::string_view kNames[] = {"red", "green", "blue", "alpha"};
    const auto* known = std::find(std::begin(kNames), std::end(kNames), name);
    if (known == std::end(kNames)) return;
    const Type& type = property.type;
    const double most = type.is_float ? 1 : std::exp2(8.0 * static_cast<double>(type.size)) - 1;
    const auto channel = static_cast<int>(known - std::begin(kNames));
    color[channel] = std::isfinite(value) ? std::clamp(static_cast<float>(value / most), 0.0f, 1.0f) : 0;
    if (channel < 3) has_colors_ = true;
    if (channel == 3 && color[channel] > 0) has_opacity_ = true;
  }

  void read_other(const ElementList& element, Numbers& numbers) {
    for (const Property& property : element.properties) {
      const std::vector<double> values = read_property(property, numbers);
      const bool is_face =
          element.name == "face" && (property.name == "vertex_indices" || property.name == "vertex_index");
      if (!is_face) continue;
      for (size_t i = 2; i < values.size(); ++i)
        triangles_.insert(triangles_.end(), {values[0], values[i - 1], values[i]});
    }
  }

  Result<ImportedMesh> mesh() const {
    SurfaceBuilder builder(has_normals_, has_uvs_, has_colors_);
    for (size_t i = 0; i + 2 < triangles_.size(); i += 3) {
      const SurfaceBuilder::Corner* corners[3];
      for (size_t k = 0; k < 3; ++k) {
        const double index = triangles_[i + k];
        if (!(index >= 0 && index < static_cast<double>(corners_.size())))
          return Error{"a face names a vertex that it does not have"};
        corners[k] = &corners_[static_cast<size_t>(index)];
      }
      if (!builder.add(coloured(*corners[0]), coloured(*corners[1]), coloured(*corners[2])))
        return Error{"a vertex is not finite, or too far away for a number of 32 bits"};
    }
    ImportedMesh mesh;
    mesh.materials.emplace_back();
    mesh.materials[0].diffuse = glm::vec3(0.7f);
    mesh.materials[0].is_default = true;
    mesh.surfaces.push_back(builder.take());
    if (mesh.surfaces[0].indices.empty())
      return Error{std::string("there is no triangle in it") +
                   (corners_.empty() ? "" : ": point clouds are not drawn; make a mesh, as with MeshLab")};
    if (keeps_nodes_) {
      mesh.nodes.emplace_back();
      mesh.surface_nodes.push_back(0);
    }
    if (!image_.empty()) mesh.materials[0].diffuse_image = image_;
    if (!image_.empty()) mesh.materials[0].diffuse = glm::vec3(1);
    return mesh;
  }

  // Scanners write an opacity of 0 everywhere: it means nothing.
  SurfaceBuilder::Corner coloured(SurfaceBuilder::Corner corner) const {
    if (has_colors_) corner.color = linear_from_srgb(corner.color);
    if (!has_opacity_ || !has_colors_) corner.color.a = 1;
    return corner;
  }

  Format format_ = Format::ascii;
  std::vector<ElementList> elements_;
  std::vector<SurfaceBuilder::Corner> corners_;
  std::vector<double> triangles_;  // vertex numbers, unchecked
  bool has_normals_ = false, has_uvs_ = false, has_colors_ = false, has_opacity_ = false;
  const bool keeps_nodes_;
  std::string image_;  // name in the header, as MeshLab writes it
};

}  // namespace

Result<ImportedMesh> import_ply(std::string_view bytes, Nodes nodes) {
  return PlyReader(nodes).read(bytes);
}

}  // namespace fire3dv::convert
