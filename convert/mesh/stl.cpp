#include "convert/mesh/stl.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/plural.h"
#include "base/text.h"
#include "base/words.h"
#include "convert/mesh/geometry/triangulate.h"
#include "convert/mesh/mesh_store.h"
#include "convert/mesh/text/mesh_text.h"

namespace fire3dv::convert {
namespace {

constexpr size_t kHeaderBytes = 84, kTriangleBytes = 50, kMaxStlTriangles = 20'000'000;

// keyword: in small letters.
bool is_keyword(std::string_view word, std::string_view keyword) {
  return word.size() == keyword.size() && lower_case(std::string(word)) == keyword;
}

bool begins_with(std::string_view text, std::string_view keyword) {
  return is_keyword(text.substr(0, keyword.size()), keyword);
}

// Binary headers may begin with "solid", too, but counts and coordinates contain zero bytes.
bool is_text_stl(std::string_view bytes) {
  const std::string_view head = without_mark(bytes.substr(0, 1024));
  std::string_view rest = head;
  std::string_view word = next_word(rest);
  while (word.starts_with('#')) {
    rest.remove_prefix(std::min(rest.find('\n'), rest.size()));
    word = next_word(rest);
  }
  return (begins_with(word, "solid") || begins_with(word, "facet")) &&
         head.find('\0') == std::string_view::npos;
}

ImportedMesh empty_mesh() {
  ImportedMesh mesh;
  mesh.materials.emplace_back();
  mesh.materials[0].name = "DefaultMaterial";
  mesh.materials[0].diffuse = glm::vec3(0.7f);
  mesh.materials[0].is_default = true;
  return mesh;
}

constexpr const char* kNotFinite = "a vertex is not finite, or too far away for a number of 32 bits";

// Facets that SurfaceBuilder refuses.
struct LeftOut {
  size_t count = 0, first = 0;  // the latter from 1

  void add(size_t facet) {
    if (count++ == 0) first = facet;
  }
  void report(ImportedMesh& mesh) const {
    if (count == 0) return;
    mesh.warnings.push_back(counted(count, "facet") + " left out (first is facet " + std::to_string(first) +
                            "): " + kNotFinite);
  }
};

class TextStl {
 public:
  TextStl(std::string_view text, Nodes nodes)
      : text_(text), rest_(text), keeps_nodes_(nodes == Nodes::keep), mesh_(empty_mesh()) {
    if (keeps_nodes_) mesh_.nodes.emplace_back();  // stands for the file
  }

  // Words are read one after the other, since some exporters write facets in one line.
  Result<ImportedMesh> read() {
    for (std::string_view word = next_word(rest_); !word.empty(); word = next_word(rest_)) {
      const bool ends_facet =
          is_keyword(word, "facet") || is_keyword(word, "endloop") || is_keyword(word, "endfacet");
      Result<void> done;
      if (is_keyword(word, "vertex"))
        done = add_vertex();
      else if (ends_facet)
        done = end_facet();
      else if (is_keyword(word, "solid"))
        done = begin_solid(rest_of_line());
      else if (is_keyword(word, "endsolid") || word[0] == '#')
        rest_of_line();
      if (!done) return done.error();
    }
    if (Result<void> done = end_facet(); !done) return done.error();
    end_solid();
    if (mesh_.surfaces.empty()) return Error{left_out_.count > 0 ? kNotFinite : "there is no triangle in it"};
    left_out_.report(mesh_);
    if (incomplete_ > 0)
      mesh_.warnings.push_back(counted(incomplete_, "facet") +
                               " without three vertices: left out; is the file cut short?");
    if (std::string crossing = polygons_.warning(); !crossing.empty())
      mesh_.warnings.push_back(std::move(crossing));
    return std::move(mesh_);
  }

 private:
  std::string_view rest_of_line() {
    const size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
    const std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(end);
    return trimmed(line);
  }

  Result<void> add_vertex() {
    glm::dvec3 vertex;
    for (int i = 0; i < 3; ++i) {
      const std::string_view word = next_word(rest_);
      const std::optional<double> value = number_of(word);
      if (!value) {
        if (word.empty()) break;  // cut short: the facet is incomplete
        const auto read = static_cast<std::ptrdiff_t>(text_.size() - rest_.size());
        const auto line = 1 + std::count(text_.begin(), text_.begin() + read, '\n');
        return Error{"line " + std::to_string(line) + ": " + not_a_number(word)};
      }
      vertex[i] = *value;
      if (i == 2) facet_.push_back(vertex);
    }
    return {};
  }

  Result<void> end_facet() {
    if (!facet_.empty()) ++facets_;
    if (!facet_.empty() && facet_.size() < 3) ++incomplete_;
    bool is_whole = true;
    for (const auto& triangle : polygons_.triangulate(facet_)) {
      if (++triangles_ > kMaxStlTriangles)
        return Error{"it has more than " + std::to_string(kMaxStlTriangles) + " triangles"};
      SurfaceBuilder::Corner corners[3];
      for (size_t k = 0; k < 3; ++k) corners[k].position = glm::vec3(facet_[triangle[k]]);
      is_whole = builder_.add(corners[0], corners[1], corners[2]) && is_whole;
    }
    if (!is_whole) left_out_.add(facets_);
    facet_.clear();
    return {};
  }

  Result<void> begin_solid(std::string_view name) {
    if (Result<void> done = end_facet(); !done) return done;
    if (keeps_nodes_) {
      end_solid();
      constexpr size_t kMaxName = 1024, kMaxSolids = 1'000'000;
      if (mesh_.nodes.size() > kMaxSolids)
        return Error{"it has more than " + std::to_string(kMaxSolids) + " solids"};
      mesh_.nodes.push_back({printable_text(name, kMaxName), 0, glm::dmat4(1), {}});
    }
    return {};
  }

  void end_solid() {
    Surface surface = builder_.take();
    if (surface.indices.empty()) return;
    mesh_.surfaces.push_back(std::move(surface));
    if (keeps_nodes_) mesh_.surface_nodes.push_back(mesh_.nodes.size() - 1);
  }

  const std::string_view text_;
  std::string_view rest_;
  const bool keeps_nodes_;
  ImportedMesh mesh_;
  SurfaceBuilder builder_{false, false};
  std::vector<glm::dvec3> facet_;
  PolygonTriangulator polygons_;
  size_t triangles_ = 0, facets_ = 0, incomplete_ = 0;
  LeftOut left_out_;
};

// Colour of a facet: five bits each, and one that says whether it counts.
class FacetColors {
 public:
  FacetColors(std::string_view header, std::string_view facets) {
    constexpr std::string_view kMagics = "COLOR=";
    const size_t at = header.find(kMagics);
    is_magics_ = at != std::string_view::npos && at + kMagics.size() + 4 <= header.size();
    for (int i = 0; is_magics_ && i < 4; ++i)
      of_all_[i] =
          static_cast<float>(static_cast<uint8_t>(header[at + kMagics.size() + static_cast<size_t>(i)])) /
          255;
    for (size_t at_facet = 0; at_facet + kTriangleBytes <= facets.size(); at_facet += kTriangleBytes) {
      const uint16_t bits = bits_of(facets.substr(at_facet));
      any_marked_ = any_marked_ || (bits & kMark) != 0;
      any_unmarked_ = any_unmarked_ || ((bits & kMark) == 0 && bits != 0);
    }
  }

  bool any() const { return any_marked_ || is_magics_; }

  // sRGB. Magics marks facets without a colour of their own; MeshLab writes its header, too, but marks those
  // with one, as VisCAM does.
  glm::vec4 of(std::string_view facet) const {
    const uint16_t bits = bits_of(facet);
    const bool is_marked = (bits & kMark) != 0;
    if (is_magics_ && any_unmarked_ ? is_marked : !is_marked) return of_all_;
    const auto channel = [&](int shift) { return static_cast<float>(bits >> shift & 31) / 31; };
    return is_magics_ ? glm::vec4(channel(0), channel(5), channel(10), 1)
                      : glm::vec4(channel(10), channel(5), channel(0), 1);
  }

 private:
  static constexpr uint16_t kMark = 0x8000;
  static uint16_t bits_of(std::string_view facet) {
    return static_cast<uint16_t>(static_cast<uint8_t>(facet[48]) | static_cast<uint8_t>(facet[49]) << 8);
  }

  bool is_magics_ = false, any_marked_ = false, any_unmarked_ = false;
  glm::vec4 of_all_{0.7f, 0.7f, 0.7f, 1};
};

glm::vec3 vertex_of(std::string_view facet, size_t corner) {
  glm::vec3 vertex;
  for (int i = 0; i < 3; ++i) {
    uint32_t bits = 0;
    for (size_t k = 4; k-- > 0;)
      bits = bits << 8 | static_cast<uint8_t>(facet[12 * (corner + 1) + 4 * static_cast<size_t>(i) + k]);
    std::memcpy(&vertex[i], &bits, sizeof bits);
  }
  return vertex;
}

Result<ImportedMesh> import_binary_stl(std::string_view bytes, Nodes nodes) {
  uint64_t declared = 0;
  for (size_t k = 4; k-- > 0;) declared = declared << 8 | static_cast<uint8_t>(bytes[80 + k]);
  const uint64_t present = (bytes.size() - kHeaderBytes) / kTriangleBytes;
  const bool fits = declared > 0 && declared <= present;
  const uint64_t count = fits ? declared : present;
  const uint64_t behind = bytes.size() - kHeaderBytes - count * kTriangleBytes;
  if (count == 0) return Error{"there is no triangle in it"};
  if (count > kMaxStlTriangles)
    return Error{"it has more than " + std::to_string(kMaxStlTriangles) + " triangles"};
  const std::string_view facets = bytes.substr(kHeaderBytes, count * kTriangleBytes);
  const bool keeps_nodes = nodes == Nodes::keep;
  const FacetColors colors(bytes.substr(0, 80), facets);
  const bool has_colors = keeps_nodes && colors.any();
  SurfaceBuilder builder(false, false, has_colors);
  LeftOut left_out;
  for (uint64_t i = 0; i < count; ++i) {
    const std::string_view facet = facets.substr(i * kTriangleBytes, kTriangleBytes);
    SurfaceBuilder::Corner corners[3];
    for (size_t k = 0; k < 3; ++k) {
      corners[k].position = vertex_of(facet, k);
      if (has_colors) corners[k].color = linear_from_srgb(colors.of(facet));
      // The count is the only sign of a binary STL file: without it, coordinates must look like some.
      constexpr float kFar = 1e12f;
      const glm::vec3 size = glm::abs(corners[k].position);
      if (!fits && !(std::max({size.x, size.y, size.z}) < kFar))
        return Error{"it is damaged, or not what its name says (its count of triangles is wrong)"};
    }
    if (!builder.add(corners[0], corners[1], corners[2])) left_out.add(i + 1);
  }
  if (left_out.count == count) return Error{kNotFinite};
  ImportedMesh mesh = empty_mesh();
  mesh.surfaces.push_back(builder.take());
  left_out.report(mesh);
  if (keeps_nodes) {
    mesh.nodes.emplace_back();
    mesh.surface_nodes.push_back(0);
  }
  if (!fits)
    mesh.warnings.push_back("its header counts " + counted(declared, "triangle") + ", but there are " +
                            std::to_string(present) + (declared > present ? "; is it cut short?" : ""));
  else if (behind > 0)
    mesh.warnings.push_back(counted(behind, "byte") + " behind its triangles are ignored");
  return mesh;
}

}  // namespace

Result<ImportedMesh> import_stl(std::string_view bytes, Nodes nodes) {
  const bool has_header = bytes.size() >= kHeaderBytes;
  uint32_t declared = 0;
  if (has_header) std::memcpy(&declared, bytes.data() + 80, sizeof declared);
  const bool is_exact = has_header && bytes.size() == kHeaderBytes + uint64_t{kTriangleBytes} * declared;
  if (!is_exact && is_text_stl(bytes)) return TextStl(without_mark(bytes), nodes).read();
  const bool is_binary = has_header && bytes.substr(0, 1024).find('\0') != std::string_view::npos;
  if (!is_exact && !is_binary)
    return Error{"it is damaged, or not what its name says (neither text nor binary STL)"};
  return import_binary_stl(bytes, nodes);
}

}  // namespace fire3dv::convert
