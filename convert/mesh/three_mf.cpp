#include "convert/mesh/three_mf.h"

#include <tinyxml2.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/plural.h"
#include "convert/description_files.h"
#include "convert/mesh/mesh_store.h"
#include "convert/mesh/node_frames.h"
#include "convert/mesh/three_mf_xml.h"
#include "convert/mesh/zip_file.h"
#include "convert/model.h"
#include "convert/xml_error.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

constexpr uint64_t kMaxFileBytes = uint64_t{1} << 28, kMaxModelBytes = uint64_t{1} << 29;
constexpr uint64_t kMax3mfTriangles = 20'000'000;
constexpr size_t kMax3mfNodes = 100'000, kMaxDepth = 100, kMaxModels = 1000;

// Properties that triangles name: one of the lists is filled.
struct PropertyGroup {
  std::vector<size_t> materials;  // of basematerials: indices into ImportedMesh::materials
  std::vector<glm::vec4> colors;  // of a colorgroup: linear
  std::vector<glm::vec2> uvs;     // of a texture2dgroup
  size_t texture_material = 0;
};

struct TextureFile {
  std::string path;
  Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
};

Wrap wrap_of(const XMLElement& texture, std::string_view name) {
  const std::string style = attribute(texture, name).value_or("wrap");
  return style == "mirror" ? Wrap::mirror : style == "clamp" || style == "none" ? Wrap::clamp : Wrap::repeat;
}

struct ModelFile {
  std::unique_ptr<tinyxml2::XMLDocument> document;
  double unit_m = 0.001;
  std::map<uint32_t, const XMLElement*> objects;
  std::map<uint32_t, PropertyGroup> groups;
};

class ThreeMfReader {
 public:
  explicit ThreeMfReader(const ZipFile& zip) : zip_(zip) {}

  Result<ImportedMesh> read() {
    mesh_.materials.emplace_back();
    mesh_.materials[0].diffuse = glm::vec3(0.7f);
    mesh_.materials[0].is_default = true;
    mesh_.nodes.emplace_back();  // stands for the file
    const Result<std::string> root = root_model();
    if (!root) return root.error();
    const Result<ModelFile*> model = model_file(*root);
    if (!model) return model.error();
    const glm::dmat4 metres = scaling((*model)->unit_m);
    const XMLElement* const build = child_of(*(*model)->document->RootElement(), "build");
    Result<void> done = each(build, "item", [&](const XMLElement& item) -> Result<void> {
      return add_reference(item, *root, metres, 0, 0);
    });
    if (!done) return done.error();
    for (auto& [key, builder] : builders_) {
      Surface surface = builder.take();
      if (surface.indices.empty()) continue;
      surface.material = key.material;
      mesh_.surfaces.push_back(std::move(surface));
      mesh_.surface_nodes.push_back(key.node);
    }
    if (left_out_triangles_ > 0) {
      const std::string reason = "a vertex is not finite, or too far away for a number of 32 bits";
      const std::string line = std::to_string(first_left_out_line_);
      if (mesh_.surfaces.empty()) return Error{"line " + line + ": " + reason};
      mesh_.warnings.push_back(counted(left_out_triangles_, "triangle") + " left out (first in line " + line +
                               "): " + reason);
    }
    if (mesh_.surfaces.empty())
      return Error{std::string("there is no triangle in what it builds") +
                   (left_out_.contains("beamlattice") ? ", only beam lattices, which are not drawn" : "")};
    return std::move(mesh_);
  }

 private:
  struct Key {
    size_t node = 0, material = 0;
    bool uvs = false, colors = false;
    auto operator<=>(const Key&) const = default;
  };

  static glm::dmat4 scaling(double factor) {
    glm::dmat4 matrix(factor);
    matrix[3][3] = 1;
    return matrix;
  }

  Result<std::string> root_model() const {
    const std::string usual = "3D/3dmodel.model";
    const Result<std::string> text = zip_.read("_rels/.rels", kMaxModelBytes);
    tinyxml2::XMLDocument document;
    if (text && xml_root(*text).ok() && document.Parse(text->data(), text->size()) == tinyxml2::XML_SUCCESS) {
      std::string target;
      (void)each(document.RootElement(), "Relationship", [&](const XMLElement& relation) -> Result<void> {
        if (target.empty() && attribute(relation, "Type").value_or("").ends_with("/3dmodel"))
          target = attribute(relation, "Target").value_or("");
        return {};
      });
      if (target.starts_with('/')) target.erase(0, 1);
      if (zip_.has(target)) return target;
    }
    if (!zip_.has(usual)) return Error{"it is a ZIP archive without a 3MF model"};
    return usual;
  }

  Result<ModelFile*> model_file(const std::string& name) {
    const auto known = models_.find(name);
    if (known != models_.end()) return &known->second;
    if (models_.size() >= kMaxModels)
      return Error{"it has more than " + std::to_string(kMaxModels) + " models"};
    Result<std::string> text = zip_.read(name, kMaxModelBytes);
    if (!text) return text.error();
    if (text->starts_with("\xef\xbb\xbf")) text->erase(0, 3);
    if (const Result<std::string> sound = xml_root(*text); !sound)
      return Error{name + ", " + sound.error().message};
    ModelFile model;
    model.document = std::make_unique<tinyxml2::XMLDocument>();
    if (model.document->Parse(text->data(), text->size()) != tinyxml2::XML_SUCCESS)
      return Error{name + ", " + xml_error(*model.document)};
    const XMLElement* const root = model.document->RootElement();
    if (!root || !is(*root, "model")) return Error{name + " is no 3MF model"};
    static const std::map<std::string, double> kUnits = {{"micron", 1e-6},     {"millimeter", 1e-3},
                                                         {"centimeter", 1e-2}, {"inch", 0.0254},
                                                         {"foot", 0.3048},     {"meter", 1}};
    const std::string unit = attribute(*root, "unit").value_or("millimeter");
    const auto factor = kUnits.find(unit);
    if (factor == kUnits.end()) return at_line(*root, "its unit " + quote(unit) + " is unknown");
    model.unit_m = factor->second;
    if (Result<void> read = read_resources(child_of(*root, "resources"), model); !read) return read.error();
    return &models_.emplace(name, std::move(model)).first->second;
  }

  Result<void> read_resources(const XMLElement* resources, ModelFile& model) {
    std::map<uint32_t, TextureFile> textures;  // by id
    for (const XMLElement* e = resources ? resources->FirstChildElement() : nullptr; e;
         e = e->NextSiblingElement()) {
      const std::optional<uint32_t> id = index_of(*e, "id");
      const bool is_known = is(*e, "object") || is(*e, "texture2d") || is(*e, "basematerials") ||
                            is(*e, "colorgroup") || is(*e, "texture2dgroup");
      if (!id && is_known) return at_line(*e, "it has no id");
      if (!id) continue;  // of another program, such as <metadata>
      if (is(*e, "object")) {
        model.objects.emplace(*id, e);
      } else if (is(*e, "texture2d")) {
        textures[*id] = {attribute(*e, "path").value_or(""), wrap_of(*e, "tilestyleu"),
                         wrap_of(*e, "tilestylev")};
      } else if (is(*e, "basematerials") || is(*e, "colorgroup") || is(*e, "texture2dgroup")) {
        read_group(*e, textures, model.groups[*id]);
      } else if (is(*e, "compositematerials") || is(*e, "multiproperties")) {
        leave_out("its " + std::string(local_name(e->Name())) + " and other mixed materials",
                  "mixed materials");
      } else {
        leave_out("its <" + sanitize_text(local_name(e->Name()), 40) + "> resources", local_name(e->Name()));
      }
    }
    return {};
  }

  // kind: reported once.
  void leave_out(const std::string& what, std::string_view kind) {
    constexpr size_t kMaxKinds = 10;
    if (left_out_.size() < kMaxKinds && left_out_.emplace(kind).second) mesh_.losses.push_back(what);
  }

  void read_group(const XMLElement& element, const std::map<uint32_t, TextureFile>& textures,
                  PropertyGroup& group) {
    (void)each(&element, "base", [&](const XMLElement& base) -> Result<void> {
      group.materials.push_back(mesh_.materials.size());
      ImportedMaterial material;
      material.name = sanitize_text(attribute(base, "name").value_or(""), 200);
      const glm::vec4 color = color_of(base, "displaycolor").value_or(glm::vec4(glm::vec3(0.7f), 1));
      material.diffuse = color;
      material.opacity = color.a;
      mesh_.materials.push_back(std::move(material));
      return {};
    });
    (void)each(&element, "color", [&](const XMLElement& color) -> Result<void> {
      group.colors.push_back(linear_from_srgb(color_of(color, "color").value_or(glm::vec4(1))));
      return {};
    });
    // Programs that know no opacity write 0 everywhere.
    const bool is_clear = !group.colors.empty() && std::all_of(group.colors.begin(), group.colors.end(),
                                                               [](const glm::vec4& c) { return c.a == 0; });
    if (is_clear) {
      for (glm::vec4& color : group.colors) color.a = 1;
      const std::string warning = "its colours would be invisible (all of opacity 0): drawn opaque";
      if (std::find(mesh_.warnings.begin(), mesh_.warnings.end(), warning) == mesh_.warnings.end())
        mesh_.warnings.push_back(warning);
    }
    (void)each(&element, "tex2coord", [&](const XMLElement& at) -> Result<void> {
      group.uvs.emplace_back(number(attribute(at, "u").value_or("")).value_or(0),
                             1 - number(attribute(at, "v").value_or("")).value_or(0));
      return {};
    });
    if (group.uvs.empty()) return;
    group.texture_material = mesh_.materials.size();
    ImportedMaterial material;
    material.name = "texture";
    const auto path = textures.find(index_of(element, "texid").value_or(0));
    std::string name = path == textures.end() ? "" : path->second.path;
    if (path != textures.end()) {
      material.diffuse_placement.wrap_u = path->second.wrap_u;
      material.diffuse_placement.wrap_v = path->second.wrap_v;
    }
    if (name.starts_with('/')) name.erase(0, 1);
    material.diffuse_image = "*" + std::to_string(mesh_.images.size());
    EmbeddedImage image{sanitize_text(name, 200), {}};  // without bytes: reported as missing
    if (const Result<std::string> bytes = zip_.read(name, kMaxFileBytes); bytes) {
      const auto view = std::as_bytes(std::span(*bytes));
      image.bytes.assign(view.begin(), view.end());
    }
    mesh_.images.push_back(std::move(image));
    mesh_.materials.push_back(std::move(material));
  }

  // An item or a component: the object below a new node.
  Result<void> add_reference(const XMLElement& reference, const std::string& here,
                             const glm::dmat4& file_from_parent, size_t parent, size_t depth) {
    std::string path = attribute(reference, "path").value_or("/" + here);
    if (path.starts_with('/')) path.erase(0, 1);
    const Result<ModelFile*> model = model_file(path);
    if (!model) return model.error();
    const std::optional<uint32_t> id = index_of(reference, "objectid");
    const auto object = (*model)->objects.find(id.value_or(0));
    if (!id || object == (*model)->objects.end())
      return at_line(reference, "it names an object that is not there");
    const Result<glm::dmat4> transform = transform_of(reference);
    if (!transform) return transform.error();
    if (depth >= kMaxDepth)
      return at_line(reference, "components are nested too deep, or contain themselves");
    if (mesh_.nodes.size() >= kMax3mfNodes) return at_line(reference, "there are too many components");
    const glm::dmat4 file_from_object = file_from_parent * *transform;
    const size_t node = mesh_.nodes.size();
    const std::string name = attribute(*object->second, "name").value_or("object " + std::to_string(*id));
    mesh_.nodes.push_back({sanitize_text(name), static_cast<int64_t>(parent), rigid_part(file_from_object)});
    const glm::dmat4 node_from_object =
        without_rounding(glm::inverse(mesh_.nodes.back().file_from_node) * file_from_object);
    if (const XMLElement* shape = child_of(*object->second, "mesh")) {
      if (Result<void> added = add_mesh(*object->second, *shape, **model, node, node_from_object); !added)
        return added;
    }
    return each(child_of(*object->second, "components"), "component", [&](const XMLElement& component) {
      return add_reference(component, path, file_from_object, node, depth + 1);
    });
  }

  Result<void> add_mesh(const XMLElement& object, const XMLElement& shape, const ModelFile& model,
                        size_t node, const glm::dmat4& node_from_object) {
    std::vector<glm::vec3> positions;
    Result<void> read =
        each(child_of(shape, "vertices"), "vertex", [&](const XMLElement& vertex) -> Result<void> {
          glm::dvec4 position(0, 0, 0, 1);
          for (int i = 0; i < 3; ++i) {
            const std::optional<double> value =
                number(attribute(vertex, std::string_view(&"xyz"[i], 1)).value_or(""));
            position[i] = value.value_or(std::numeric_limits<double>::quiet_NaN());
          }
          positions.emplace_back(node_from_object * position);
          return {};
        });
    if (!read) return read;
    if (child_of(shape, "beamlattice")) leave_out("its beam lattices", "beamlattice");
    const std::optional<uint32_t> object_group = index_of(object, "pid");
    const uint32_t object_property = index_of(object, "pindex").value_or(0);
    return each(child_of(shape, "triangles"), "triangle", [&](const XMLElement& triangle) -> Result<void> {
      if (++triangles_ > kMax3mfTriangles)
        return Error{"it has more than " + std::to_string(kMax3mfTriangles) + " triangles"};
      SurfaceBuilder::Corner corners[3];
      constexpr std::string_view kVertices[] = {"v1", "v2", "v3"}, kProperties[] = {"p1", "p2", "p3"};
      for (size_t i = 0; i < 3; ++i) {
        const std::optional<uint32_t> vertex = index_of(triangle, kVertices[i]);
        if (!vertex || *vertex >= positions.size())
          return at_line(triangle, "it names a vertex that is not there");
        corners[i].position = positions[*vertex];
      }
      const std::optional<uint32_t> first = index_of(triangle, kProperties[0]);
      const std::optional<uint32_t> own = index_of(triangle, "pid");
      const auto group = model.groups.find(own ? *own : object_group.value_or(UINT32_MAX));
      Key key{node};
      if (group != model.groups.end()) {
        const uint32_t property = first.value_or(object_property);
        for (size_t i = 0; i < 3; ++i) {
          const uint32_t at =
              i == 0 || !first ? property : index_of(triangle, kProperties[i]).value_or(property);
          if (!set_property(group->second, at, corners[i], key))
            return at_line(triangle, "it names a property that is not there");
        }
      }
      auto& builder = builders_.try_emplace(key, false, key.uvs, key.colors).first->second;
      const bool mirrored = glm::determinant(glm::dmat3(node_from_object)) < 0;
      if (mirrored) std::swap(corners[1], corners[2]);
      if (!builder.add(corners[0], corners[1], corners[2]) && left_out_triangles_++ == 0)
        first_left_out_line_ = triangle.GetLineNum();
      return {};
    });
  }

  static bool set_property(const PropertyGroup& group, uint32_t at, SurfaceBuilder::Corner& corner,
                           Key& key) {
    if (at < group.materials.size()) {
      if (key.material == 0) key.material = group.materials[at];  // that of the first vertex
    } else if (at < group.colors.size()) {
      corner.color = group.colors[at];
      key.colors = true;
    } else if (at < group.uvs.size()) {
      corner.uv = group.uvs[at];
      key.material = group.texture_material;
      key.uvs = true;
    } else {
      return group.materials.empty() && group.colors.empty() && group.uvs.empty();
    }
    return true;
  }

  const ZipFile& zip_;
  std::map<std::string, ModelFile> models_;  // by path
  std::map<Key, SurfaceBuilder> builders_;
  ImportedMesh mesh_;
  uint64_t triangles_ = 0, left_out_triangles_ = 0;
  int first_left_out_line_ = 0;
  std::set<std::string, std::less<>> left_out_;  // kinds of elements
};

}  // namespace

Result<ImportedMesh> import_3mf(const std::filesystem::path& file) {
  const Result<FileBytes> bytes = read_file(file, kMaxFileBytes);
  if (!bytes) return bytes.error();
  const Result<ZipFile> zip = ZipFile::open({reinterpret_cast<const char*>(bytes->data.get()), bytes->size});
  if (!zip) return zip.error();
  return ThreeMfReader(*zip).read();
}

}  // namespace fire3dv::convert
