#include "renderer/scene/gltf/gltf_parts.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <optional>

#include "base/parallel.h"
#include "renderer/scene/gltf/gltf_accessors.h"
#include "renderer/scene/model/vertices.h"

namespace fire3dv::scene {
namespace {

constexpr int kMissing = -1;
// Limits per file: enough for 100 million triangles on a large machine. Accessors may share bytes, so that a
// small file could claim any amount of memory.
constexpr size_t kMaxVertices = size_t{1} << 28;
constexpr size_t kMeshesAhead = 64, kMaxVerticesAhead = size_t{1} << 22;
constexpr size_t kMaxIndices = size_t{1} << 30;
constexpr size_t kAttributeFloats = sizeof(VertexAttributes) / sizeof(float);
static_assert(sizeof(VertexAttributes) == kAttributeFloats * sizeof(float));

// Deduplication key of a primitive's geometry: its accessors and derived attributes. Primitives with equal
// keys share vertices and indices, so that a file cannot request the same work a thousand times.
struct Recipe {
  int position = kMissing, normal = kMissing, tangent = kMissing, uv0 = kMissing, uv1 = kMissing,
      color = kMissing;
  int indices = kMissing, mode = TINYGLTF_MODE_TRIANGLES;
  int tangent_uv_set = kMissing;  // kMissing: no tangents are generated
  InfluenceAccessors influences;
  std::vector<MorphAccessors> targets;
  auto operator<=>(const Recipe&) const = default;

  Topology topology() const {
    if (mode == TINYGLTF_MODE_POINTS) return Topology::points;
    return mode < TINYGLTF_MODE_TRIANGLES ? Topology::lines : Topology::triangles;
  }
  bool flat() const { return normal == kMissing && topology() == Topology::triangles; }
  // Vertices are independent of the index list unless attributes are derived from triangles.
  bool vertices_stand_alone() const { return !flat() && tangent_uv_set == kMissing; }
};

struct VertexRange {
  uint32_t first = 0, count = 0;
  InfluenceRange influences;
  MorphRange morphs;
  uint32_t first_source = kNone, file_count = 0;  // see Primitive
};

const char* element_of(Topology topology) {
  return topology == Topology::triangles ? "triangle" : topology == Topology::lines ? "line" : "point";
}

class MeshLoader {
 public:
  MeshLoader(const GltfDocument& document, const LoadLimits& limits, Scene& scene)
      : document_(document), reader_(document, limits), model_(document.model), scene_(scene) {}

  Result<void> add_mesh(const tinygltf::Mesh& source, const std::string& where) {
    Mesh mesh;
    mesh.name = source.name;
    if (source.extras.Has("unbounded")) {
      const tinygltf::Value& unbounded = source.extras.Get("unbounded");
      mesh.unbounded = unbounded.IsBool() && unbounded.Get<bool>();
    }
    mesh.first_primitive = static_cast<uint32_t>(scene_.primitives.size());
    if (source.primitives.empty()) return Error{where + " has no primitives"};
    auto targets = morph_target_count(source, where);
    if (!targets) return targets.error();
    mesh.morph_target_count = *targets;
    for (size_t i = 0; i < source.primitives.size(); ++i) {
      auto done = add_primitive(source.primitives[i], where + "." + element("primitives", i));
      if (!done) return done;
    }
    report_repairs(where);
    mesh.primitive_count = static_cast<uint32_t>(scene_.primitives.size()) - mesh.first_primitive;
    scene_.meshes.push_back(std::move(mesh));
    return {};
  }

  // Builds the next meshes (tangents dominate) on all cores. Errors are left to add_mesh(), which reports
  // them.
  void make_ahead(std::span<const tinygltf::Mesh> meshes) {
    ahead_.clear();
    size_t vertices = 0;
    for (const tinygltf::Mesh& mesh : meshes) {
      for (const tinygltf::Primitive& source : mesh.primitives) {
        if (!is_plain(source)) continue;
        if (source.extensions.contains("KHR_materials_variants")) continue;  // read once, by add_primitive()
        const Recipe recipe = recipe_of(source, scene_.materials[static_cast<size_t>(source.material + 1)]);
        const auto count = reader_.count(recipe.position, "");
        if (recipe.tangent_uv_set == kMissing || !count || geometry_.contains(recipe)) continue;
        if (*count > kMaxVerticesAhead - vertices) break;
        if (ahead_.try_emplace(recipe).second) vertices += *count;
      }
    }
    std::vector<std::pair<const Recipe, std::optional<BuiltPrimitive>>*> wanted;
    for (auto& entry : ahead_) wanted.push_back(&entry);
    parallel_for(wanted.size(), [&](size_t i) { wanted[i]->second = made_of(wanted[i]->first); });
  }

 private:
  // One warning a mesh for its vertices that were repaired.
  void report_repairs(const std::string& where) {
    if (repaired_normals_ > 0) {
      scene_.warnings.push_back(where + " has " + std::to_string(repaired_normals_) +
                                " normals that are zero or not finite; they are computed from its triangles");
    }
    if (has_bad_tangents_)
      scene_.warnings.push_back(where +
                                " has tangents that are not finite; its normal map is wrong there: "
                                "export it without tangents");
    repaired_normals_ = 0;
    has_bad_tangents_ = false;
  }

  struct BuiltPrimitive {
    std::vector<uint32_t> indices;
    Vertices vertices;
  };

  // True for undeformed triangle lists that cause no warnings.
  bool is_plain(const tinygltf::Primitive& source) const {
    const bool deformed = !source.targets.empty() || source.attributes.contains("JOINTS_0") ||
                          source.attributes.contains("WEIGHTS_0");
    return source.mode == TINYGLTF_MODE_TRIANGLES && !deformed && source.indices != kMissing &&
           source.attributes.contains("POSITION") &&
           (source.material == kMissing || in_range(source.material, model_.materials.size()));
  }

  std::optional<BuiltPrimitive> made_of(const Recipe& recipe) const {
    const auto count = reader_.count(recipe.position, ""), index_count = reader_.count(recipe.indices, "");
    if (!count || !index_count || *count >= kNone || *index_count == 0 || *index_count % 3 != 0)
      return std::nullopt;
    if (*index_count > 8 * kMaxVerticesAhead) return std::nullopt;
    BuiltPrimitive made;
    if (!reader_.reserve(2 * sizeof(uint32_t) * uint64_t{*index_count}, "")) return std::nullopt;
    made.indices.resize(*index_count);
    const auto limit = static_cast<uint32_t>(*count);
    if (!reader_.read_indices(recipe.indices, "", made.indices.data(), limit)) return std::nullopt;
    auto vertices = make_vertices(recipe, *count, made.indices, "");
    if (!vertices) return std::nullopt;
    made.vertices = std::move(*vertices);
    return made;
  }

  // Rewrites `indices` if vertices are duplicated.
  Result<Vertices> make_vertices(const Recipe& recipe, size_t count, std::vector<uint32_t>& indices,
                                 const std::string& where) const {
    auto vertices = read_vertices(recipe, count, where);
    if (!vertices) return vertices;
    // Flat shading and tangents split vertices: at most one per triangle corner.
    if (recipe.flat() || recipe.tangent_uv_set != kMissing) {
      if (auto room = reserve_vertices(indices.size(), where); !room) return room.error();
    }
    if (recipe.flat()) {
      make_flat(*vertices, indices);
    } else {
      std::span<const uint32_t> triangles;
      if (recipe.topology() == Topology::triangles) triangles = indices;
      vertices->repaired_normals = repair_normals(*vertices, triangles);
    }
    if (recipe.tangent_uv_set != kMissing) {
      generate_tangents(*vertices, indices, static_cast<uint32_t>(recipe.tangent_uv_set));
    }
    return vertices;
  }

  Result<void> add_primitive(const tinygltf::Primitive& source, const std::string& where) {
    if (source.mode < TINYGLTF_MODE_POINTS || source.mode > TINYGLTF_MODE_TRIANGLE_FAN) {
      return Error{where + " has the unknown mode " + std::to_string(source.mode)};
    }
    if (source.material != kMissing && !in_range(source.material, model_.materials.size())) {
      return out_of_range(where, "materials", source.material, model_.materials.size());
    }
    const auto material = static_cast<uint32_t>(source.material + 1);  // 0 is glTF's default material
    auto of_variants = variant_materials_of(document_, source, where, scene_);
    if (!of_variants) return of_variants.error();
    Recipe recipe = recipe_of(source, scene_.materials[material_for_tangents(material, *of_variants)]);
    report_missing_tangents(recipe, scene_.materials[material], where);
    auto influences = influence_accessors(source, where, scene_.warnings);
    if (!influences) return influences.error();
    recipe.influences = *influences;
    recipe.targets = morph_accessors(source, where, scene_.warnings);
    if (recipe.position == kMissing) {
      scene_.warnings.push_back(where + " has no POSITION and is not drawn");
      return {};
    }
    auto known = geometry_.find(recipe);
    if (known == geometry_.end()) {
      auto made = make_geometry(recipe, where);
      if (!made) return made.error();
      known = geometry_.emplace(recipe, *made).first;
    }
    if (known->second.index_count == 0) {
      scene_.warnings.push_back(where + " has no whole " + element_of(recipe.topology()) +
                                " and is not drawn");
      return {};
    }
    Primitive primitive = known->second;
    primitive.material = material;
    if (!of_variants->empty()) {
      primitive.first_variant_material = static_cast<uint32_t>(scene_.variant_materials.size());
      scene_.variant_materials.insert(scene_.variant_materials.end(), of_variants->begin(),
                                      of_variants->end());
    }
    scene_.primitives.push_back(primitive);
    return {};
  }

  void report_missing_tangents(const Recipe& recipe, const Material& material, const std::string& where) {
    const int uv = recipe.tangent_uv_set == 0 ? recipe.uv0 : recipe.uv1;
    if (recipe.tangent_uv_set == kMissing || uv != kMissing || material.anisotropy <= 0) return;
    scene_.warnings.push_back(
        where +
        " has an anisotropic material, but neither tangents nor texture coordinates; its "
        "highlights have any direction: export it with tangents");
  }

  // All variants share the vertices: if one of them needs tangents, there are some.
  uint32_t material_for_tangents(uint32_t material, std::span<const uint32_t> of_variants) const {
    if (needs_tangents(scene_.materials[material])) return material;
    const auto found = std::find_if(of_variants.begin(), of_variants.end(),
                                    [&](uint32_t other) { return needs_tangents(scene_.materials[other]); });
    return found == of_variants.end() ? material : *found;
  }

  // Both normal maps and the anisotropy share one tangent frame, of the UV set of the first that has a
  // texture.
  static int tangent_uv_set_of(const Material& material) {
    if (!needs_tangents(material)) return kMissing;
    for (const TextureRef* ref :
         {&material.normal_texture, &material.clearcoat_normal_texture, &material.anisotropy_texture}) {
      if (ref->texture != kNone) return static_cast<int>(ref->uv_set);
    }
    return 0;
  }

  static Recipe recipe_of(const tinygltf::Primitive& source, const Material& material) {
    const auto accessor = [&](const char* attribute) {
      const auto found = source.attributes.find(attribute);
      return found == source.attributes.end() ? kMissing : found->second;
    };
    Recipe recipe;
    recipe.position = accessor("POSITION");
    recipe.normal = accessor("NORMAL");
    recipe.tangent = accessor("TANGENT");
    recipe.uv0 = accessor("TEXCOORD_0");
    recipe.uv1 = accessor("TEXCOORD_1");
    recipe.color = accessor("COLOR_0");
    recipe.indices = source.indices;
    recipe.mode = source.mode;
    if (recipe.normal == kMissing) recipe.tangent = kMissing;  // glTF: tangents without normals are ignored
    if (recipe.topology() == Topology::triangles && recipe.tangent == kMissing) {
      recipe.tangent_uv_set = tangent_uv_set_of(material);
    }
    return recipe;
  }

  // Returns a primitive without material.
  Result<Primitive> make_geometry(const Recipe& recipe, const std::string& where) {
    auto vertex_count = reader_.count(recipe.position, where + ".POSITION");
    if (!vertex_count) return vertex_count.error();
    if (*vertex_count >= kNone) return Error{where + " has more vertices than 32-bit indices can name"};
    std::optional<BuiltPrimitive> made;
    if (const auto ahead = ahead_.find(recipe); ahead != ahead_.end()) {
      made = std::move(ahead->second);
      ahead_.erase(ahead);
    }
    auto indices = made ? Result(std::move(made->indices))
                        : read_list(recipe, static_cast<uint32_t>(*vertex_count), where);
    if (!indices) return indices.error();
    Primitive primitive;
    if (indices->empty()) return primitive;
    primitive.topology = recipe.topology();
    primitive.lit = recipe.normal != kMissing || recipe.flat();
    if (scene_.indices.size() + indices->size() > kMaxIndices)
      return Error{where + ": the file holds more than " + std::to_string(kMaxIndices) +
                   " indices; split it"};
    auto range = add_vertices(recipe, *vertex_count, *indices, made ? &made->vertices : nullptr, where);
    if (!range) return range.error();
    primitive.first_vertex = range->first;
    primitive.vertex_count = range->count;
    primitive.first_influence = range->influences.first;
    primitive.influence_sets = range->influences.sets;
    primitive.joint_limit = range->influences.joint_limit;
    primitive.first_morph_delta = range->morphs.first;
    primitive.morph_target_count = range->morphs.count;
    primitive.first_vertex_source = range->first_source;
    primitive.file_vertex_count = range->file_count;
    primitive.first_index = static_cast<uint32_t>(scene_.indices.size());
    primitive.index_count = static_cast<uint32_t>(indices->size());
    if (scene_.indices.empty()) {
      scene_.indices = std::move(*indices);
    } else {
      scene_.indices.insert(scene_.indices.end(), indices->begin(), indices->end());
    }
    find_bounds(primitive);
    return primitive;
  }

  Result<std::vector<uint32_t>> read_list(const Recipe& recipe, uint32_t vertex_count,
                                          const std::string& where) {
    std::vector<uint32_t> indices;
    // Strips and fans unroll to at most three indices each.
    constexpr uint64_t kIndexBytes = 3 * sizeof(uint32_t);
    if (recipe.indices == kMissing) {
      if (auto room = reader_.reserve(kIndexBytes * vertex_count, where); !room) return room.error();
      indices.resize(vertex_count);
      std::iota(indices.begin(), indices.end(), 0u);
    } else {
      auto count = reader_.count(recipe.indices, where + ".indices");
      if (!count) return count.error();
      if (auto room = reader_.reserve(kIndexBytes * *count, where); !room) return room.error();
      indices.resize(*count);
      auto done = reader_.read_indices(recipe.indices, where + ".indices", indices.data(), vertex_count);
      if (!done) return done.error();
    }
    switch (recipe.mode) {
      case TINYGLTF_MODE_LINE_LOOP:
        return lines_of_loop(indices);
      case TINYGLTF_MODE_LINE_STRIP:
        return lines_of_strip(indices);
      case TINYGLTF_MODE_TRIANGLE_STRIP:
        return triangles_of_strip(indices);
      case TINYGLTF_MODE_TRIANGLE_FAN:
        return triangles_of_fan(indices);
      default:
        break;
    }
    const size_t corners = recipe.topology() == Topology::triangles ? 3
                           : recipe.topology() == Topology::lines   ? 2
                                                                    : 1;
    if (indices.size() % corners != 0) {
      scene_.warnings.push_back(where + " has " + std::to_string(indices.size()) +
                                " indices, not a multiple of " + std::to_string(corners) +
                                ": the last are left out");
      indices.resize(indices.size() / corners * corners);
    }
    return indices;
  }

  // made: vertices that were built ahead, or null.
  Result<VertexRange> add_vertices(const Recipe& recipe, size_t count, std::vector<uint32_t>& indices,
                                   Vertices* made, const std::string& where) {
    Recipe key = recipe;
    key.indices = key.mode = 0;
    if (recipe.vertices_stand_alone()) {
      if (const auto known = vertices_.find(key); known != vertices_.end()) return known->second;
    }
    if (auto ok = check_room(recipe.flat() ? indices.size() : count, where); !ok) return ok.error();
    auto vertices = made ? Result(std::move(*made)) : make_vertices(recipe, count, indices, where);
    if (!vertices) return vertices.error();
    if (auto ok = check_room(vertices->positions.size(), where); !ok) return ok.error();
    VertexRange range{static_cast<uint32_t>(scene_.positions.size()),
                      static_cast<uint32_t>(vertices->positions.size()),
                      {},
                      {}};
    if (auto done = add_deformation(recipe, count, *vertices, indices, where, range); !done)
      return done.error();
    if (!vertices->source.empty()) {
      range.first_source = static_cast<uint32_t>(scene_.vertex_sources.size());
      range.file_count = static_cast<uint32_t>(count);
      scene_.vertex_sources.insert(scene_.vertex_sources.end(), vertices->source.begin(),
                                   vertices->source.end());
    }
    if (scene_.positions.empty()) {  // moves the vertices of a single large mesh
      scene_.positions = std::move(vertices->positions);
    } else {
      scene_.positions.insert(scene_.positions.end(), vertices->positions.begin(), vertices->positions.end());
    }
    append_attributes(scene_, vertices->attributes);
    repaired_normals_ += vertices->repaired_normals;
    has_bad_tangents_ |= vertices->has_bad_tangents;
    // Repaired normals belong to these triangles.
    if (recipe.vertices_stand_alone() && vertices->repaired_normals == 0) vertices_.emplace(key, range);
    return range;
  }

  Result<void> check_room(size_t vertices, const std::string& where) const {
    if (scene_.positions.size() + vertices <= kMaxVertices) return {};
    return Error{where + ": the file holds more than " + std::to_string(kMaxVertices) +
                 " vertices; split it"};
  }

  Result<void> reserve_vertices(size_t count, const std::string& where) const {
    return reader_.reserve(uint64_t{count} * (sizeof(glm::vec3) + sizeof(VertexAttributes)), where);
  }

  Result<Vertices> read_vertices(const Recipe& recipe, size_t count, const std::string& where) const {
    struct Attribute {
      const char* name;
      int accessor;
      float* first;
      int components, min_components;
    };
    if (auto room = reserve_vertices(count, where); !room) return room.error();
    Vertices vertices{std::vector<glm::vec3>(count), std::vector<VertexAttributes>(count), {}};
    auto done = reader_.read_floats(recipe.position, where + ".POSITION", &vertices.positions[0].x, 3, 3, 3);
    if (!done) return done.error();
    VertexAttributes& first = vertices.attributes[0];
    const std::array<Attribute, 5> attributes{{{".NORMAL", recipe.normal, &first.normal.x, 3, 3},
                                               {".TANGENT", recipe.tangent, &first.tangent.x, 4, 4},
                                               {".TEXCOORD_0", recipe.uv0, &first.uv0.x, 2, 2},
                                               {".TEXCOORD_1", recipe.uv1, &first.uv1.x, 2, 2},
                                               {".COLOR_0", recipe.color, &first.color.x, 4, 3}}};
    for (const Attribute& attribute : attributes) {
      if (attribute.accessor == kMissing) continue;
      const std::string name = where + attribute.name;
      auto own_count = reader_.count(attribute.accessor, name);
      if (!own_count) return own_count.error();
      if (*own_count != count) {
        return Error{name + " has " + std::to_string(*own_count) + " elements, but POSITION has " +
                     std::to_string(count)};
      }
      // Normals and tangents can be replaced.
      const bool is_replaceable = attribute.accessor == recipe.normal || attribute.accessor == recipe.tangent;
      bool is_finite = true;
      done = reader_.read_floats(attribute.accessor, name, attribute.first, kAttributeFloats,
                                 attribute.components, attribute.min_components,
                                 is_replaceable ? &is_finite : nullptr);
      if (!done) return done.error();
      if (!is_finite && attribute.accessor == recipe.tangent) vertices.has_bad_tangents = true;
    }
    sanitize_attributes(vertices);
    return vertices;
  }

  Result<void> add_deformation(const Recipe& recipe, size_t count, const Vertices& vertices,
                               std::span<const uint32_t> indices, const std::string& where,
                               VertexRange& range) {
    FIRE3DV_ASSERT(vertices.positions.size() == (vertices.source.empty() ? count : vertices.source.size()));
    auto influences = add_influences(reader_, recipe.influences, count, vertices.source, where, scene_);
    if (!influences) return influences.error();
    range.influences = *influences;
    MorphBase base{count, vertices.source, vertices.positions, vertices.attributes, {}};
    if (recipe.flat()) base.flat = indices;
    auto morphs = add_morphs(reader_, recipe.targets, base, where, scene_);
    if (!morphs) return morphs.error();
    range.morphs = *morphs;
    return {};
  }

  void find_bounds(Primitive& primitive) const {
    glm::vec3 low(std::numeric_limits<float>::max()), high(std::numeric_limits<float>::lowest());
    for (uint32_t vertex = primitive.first_vertex; vertex < primitive.first_vertex + primitive.vertex_count;
         ++vertex) {
      low = glm::min(low, scene_.positions[vertex]);
      high = glm::max(high, scene_.positions[vertex]);
    }
    primitive.bounds_min = low;
    primitive.bounds_max = high;
  }

  const GltfDocument& document_;
  AccessorReader reader_;
  const tinygltf::Model& model_;
  Scene& scene_;
  size_t repaired_normals_ = 0;  // in the current mesh
  bool has_bad_tangents_ = false;
  std::map<Recipe, Primitive> geometry_;
  std::map<Recipe, VertexRange> vertices_;
  std::map<Recipe, std::optional<BuiltPrimitive>> ahead_;
};

}  // namespace

Result<void> add_meshes(const GltfDocument& document, const LoadLimits& limits, const LoadProgress& progress,
                        Scene& scene) {
  MeshLoader loader(document, limits, scene);
  const auto& meshes = document.model.meshes;
  for (size_t i = 0; i < meshes.size(); ++i) {
    if (limits.stop_requested && limits.stop_requested())
      return Error{element("meshes", i) + " is not read: the load was stopped"};
    if (i % kMeshesAhead == 0) {
      loader.make_ahead(std::span(meshes).subspan(i, std::min(kMeshesAhead, meshes.size() - i)));
    }
    if (auto done = loader.add_mesh(meshes[i], element("meshes", i)); !done) return done;
    if (progress) progress("meshes", i + 1, meshes.size());
  }
  return {};
}

}  // namespace fire3dv::scene
