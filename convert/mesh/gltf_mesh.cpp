#include "convert/mesh/gltf_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "convert/glb/write_glb.h"
#include "convert/mesh/node_frames.h"
#include "convert/model.h"
#include "renderer/scene/files.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/scene.h"
#include "renderer/scene/model/vertices.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxGltfBytes = uint64_t{1} << 28, kMaxGltfTriangles = 20'000'000;
constexpr uint64_t kMaxImagePixels = uint64_t{1} << 26, kMaxGltfNodes = 1'000'000;

// Inverse of linear_from_srgb.
glm::vec3 displayed_color(const glm::vec3& linear) {
  glm::vec3 displayed;
  for (int i = 0; i < 3; ++i) {
    const float c = std::clamp(linear[i], 0.0f, 1.0f);
    displayed[i] = c <= 0.0031308f ? c * 12.92f : 1.055f * std::pow(c, 1 / 2.4f) - 0.055f;
  }
  return displayed;
}

glm::vec2 transformed_uv(const scene::TextureRef& texture, const glm::vec2& uv) {
  const glm::vec2 scaled = uv * texture.uv_scale;
  const float c = std::cos(texture.uv_rotation_rad), s = std::sin(texture.uv_rotation_rad);
  return texture.uv_offset + glm::vec2(c * scaled.x + s * scaled.y, c * scaled.y - s * scaled.x);
}

class GltfMesh {
 public:
  GltfMesh(const scene::Scene& scene, const ImportRequest& request) : scene_(scene), request_(request) {
    if (request.gltf_up == GltfUp::apply)
      file_from_scene_ = glm::dmat4({1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}, {0, 0, 0, 1});
  }

  Result<ImportedMesh> read() {
    for (size_t i = 0; i < scene_.nodes.size(); ++i)
      if (Result<void> done = add_node(i); !done) return done.error();
    for (auto& [key, surface] : surfaces_) {
      to_.surfaces.push_back(std::move(surface));
      if (keeps_nodes()) to_.surface_nodes.push_back(std::get<0>(key));
    }
    if (to_.surfaces.empty()) return Error{"there is no triangle in it"};
    if (!scene_.animations.empty()) to_.losses.emplace_back("its animations");
    return std::move(to_);
  }

 private:
  using Key = std::tuple<size_t, size_t, bool, bool>;  // node, material, texture coordinates, colours

  bool keeps_nodes() const { return request_.nodes == Nodes::keep; }

  Result<void> add_node(size_t index) {
    const scene::Node& node = scene_.nodes[index];
    glm::dmat4 surface_from_node = file_from_scene_ * glm::dmat4(node.world_from_node);
    glm::dmat4 surface_from_scene = file_from_scene_;
    if (keeps_nodes()) {
      const glm::dmat4 rigid = rigid_part(surface_from_node);
      const std::string mesh = node.mesh == scene::kNone ? std::string() : scene_.meshes[node.mesh].name;
      const int64_t parent = node.parent == scene::kNone ? -1 : static_cast<int64_t>(node.parent);
      to_.nodes.push_back({sanitize_text(node.name), parent, rigid, sanitize_text(mesh)});
      surface_from_scene = glm::inverse(rigid) * surface_from_scene;
      surface_from_node = without_rounding(glm::inverse(rigid) * surface_from_node);
    }
    if (node.mesh == scene::kNone) return {};
    const scene::Mesh& mesh = scene_.meshes[node.mesh];
    for (uint32_t i = 0; i < mesh.primitive_count; ++i) {
      const scene::Primitive& primitive = scene_.primitives[mesh.first_primitive + i];
      if (primitive.topology != scene::Topology::triangles || primitive.index_count == 0) continue;
      triangles_ += primitive.index_count / 3;
      if (triangles_ > kMaxGltfTriangles)
        return Error{"it has more than " + std::to_string(kMaxGltfTriangles) + " triangles"};
      add_primitive(keeps_nodes() ? index : 0, node, primitive, surface_from_node, surface_from_scene);
    }
    return {};
  }

  // Transform of a vertex: that of its node, or the mean of its joints.
  glm::dmat4 transform_of(const scene::Node& node, const scene::Primitive& primitive, uint32_t vertex,
                          const glm::dmat4& surface_from_node, const glm::dmat4& surface_from_scene) const {
    if (node.skin == scene::kNone || primitive.first_influence == scene::kNone) return surface_from_node;
    const scene::Skin& skin = scene_.skins[node.skin];
    glm::dmat4 sum(0);
    for (uint32_t set = 0; set < primitive.influence_sets; ++set) {
      const scene::Influences& influences =
          scene_.influences[primitive.first_influence + vertex * primitive.influence_sets + set];
      for (size_t k = 0; k < 4; ++k) {
        if (influences.weights[k] == 0 || influences.joints[k] >= skin.joint_count) continue;
        const scene::Joint& joint = scene_.joints[skin.first_joint + influences.joints[k]];
        sum += static_cast<double>(influences.weights[k]) *
               glm::dmat4(scene_.nodes[joint.node].world_from_node * joint.joint_from_mesh);
      }
    }
    return surface_from_scene * sum;
  }

  void add_primitive(size_t node_index, const scene::Node& node, const scene::Primitive& primitive,
                     const glm::dmat4& surface_from_node, const glm::dmat4& surface_from_scene) {
    const scene::Material& material = scene_.materials[primitive.material];
    const scene::TextureRef& uv_texture =
        material.base_color_texture.texture != scene::kNone ? material.base_color_texture
        : material.normal_texture.texture != scene::kNone   ? material.normal_texture
        : material.emissive_texture.texture != scene::kNone ? material.emissive_texture
                                                            : material.metallic_roughness_texture;
    const bool has_uvs = uv_texture.texture != scene::kNone && !scene_.uvs.empty();
    bool has_colors = false;
    for (uint32_t v = 0; v < primitive.vertex_count && !has_colors; ++v)
      has_colors = scene::has_color(scene_, primitive.first_vertex + v);
    Surface& surface = surfaces_[{node_index, material_of(primitive.material), has_uvs, has_colors}];
    surface.material = material_of(primitive.material);
    const auto first = static_cast<uint32_t>(surface.positions.size());
    for (uint32_t v = 0; v < primitive.vertex_count; ++v) {
      const scene::VertexAttributes from = scene::attributes_of(scene_, primitive.first_vertex + v);
      const glm::dmat4 transform = transform_of(node, primitive, v, surface_from_node, surface_from_scene);
      const glm::dmat3 linear(transform);
      // Cofactors replace the inverse transpose, which flattened nodes do not have.
      const glm::dmat3 cofactors(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                                 glm::cross(linear[0], linear[1]));
      const glm::dvec3 normal =
          cofactors * glm::dvec3(from.normal) * (glm::determinant(linear) < 0 ? -1.0 : 1.0);
      const double length = glm::length(normal);
      surface.positions.emplace_back(transform * glm::dvec4(scene_.positions[primitive.first_vertex + v], 1));
      surface.normals.emplace_back(length > 0 ? normal / length : glm::dvec3(0, 0, 1));
      if (has_uvs) surface.uvs.push_back(transformed_uv(uv_texture, uv_texture.uv_set ? from.uv1 : from.uv0));
      if (has_colors) surface.colors.push_back(from.color);
    }
    const bool mirrored = glm::determinant(glm::dmat3(surface_from_node)) < 0;
    for (uint32_t i = 0; i + 2 < primitive.index_count; i += 3) {
      const uint32_t* corner = &scene_.indices[primitive.first_index + i];
      surface.indices.insert(surface.indices.end(), {first + corner[0], first + corner[mirrored ? 2 : 1],
                                                     first + corner[mirrored ? 1 : 2]});
    }
  }

  size_t material_of(uint32_t index) {
    const auto [known, is_new] = materials_.try_emplace(index, to_.materials.size());
    if (!is_new) return known->second;
    const scene::Material& from = scene_.materials[index];
    ImportedMaterial made;
    made.name = sanitize_text(from.name, 200);
    made.is_default = index == 0;
    made.is_exact = true;
    made.diffuse = made.is_default ? glm::vec3(0.7f) : displayed_color(glm::vec3(from.base_color));
    made.is_blended = from.alpha_mode == scene::AlphaMode::blend;
    made.opacity =
        from.alpha_mode == scene::AlphaMode::opaque ? 1 : std::clamp(from.base_color.a, 0.0f, 1.0f);
    if (from.alpha_mode == scene::AlphaMode::mask) made.alpha_cutoff = from.alpha_cutoff;
    made.emission = displayed_color(from.emissive);
    made.roughness = made.is_default ? 0.5f : std::clamp(from.roughness, 0.0f, 1.0f);
    made.metallic = made.is_default ? 0 : std::clamp(from.metallic, 0.0f, 1.0f);
    const bool has_opacity = from.alpha_mode != scene::AlphaMode::opaque;
    made.diffuse_image = image_of(from.base_color_texture, has_opacity);
    made.normal_image = image_of(from.normal_texture, false);
    made.emission_image = image_of(from.emissive_texture, false);
    made.roughness_image = made.metallic_image = image_of(from.metallic_roughness_texture, false);
    made.diffuse_placement = placement_of(from.base_color_texture);
    made.normal_placement = placement_of(from.normal_texture);
    made.emission_placement = placement_of(from.emissive_texture);
    made.roughness_placement = placement_of(from.metallic_roughness_texture);
    if (made.opacity == 0 && made.is_blended)
      to_.warnings.push_back("material " + quote(made.name) +
                             " is invisible: its base colour has the opacity 0");
    to_.materials.push_back(std::move(made));
    return known->second;
  }

  // Wrap modes; the vertices hold the transform.
  ImagePlacement placement_of(const scene::TextureRef& texture) const {
    ImagePlacement placement;
    if (texture.texture == scene::kNone) return placement;
    const auto wrap = [](scene::Wrap from) {
      return from == scene::Wrap::repeat            ? Wrap::repeat
             : from == scene::Wrap::mirrored_repeat ? Wrap::mirror
                                                    : Wrap::clamp;
    };
    const scene::Sampler& sampler = scene_.textures[texture.texture].sampler;
    placement.wrap_u = wrap(sampler.wrap_u);
    placement.wrap_v = wrap(sampler.wrap_v);
    return placement;
  }

  // Name of the embedded image; empty: none.
  std::string image_of(const scene::TextureRef& texture, bool has_opacity) {
    if (texture.texture == scene::kNone) return {};
    const uint32_t index = scene_.textures[texture.texture].image;
    const auto [known, is_new] = images_.try_emplace({index, has_opacity}, to_.images.size());
    if (is_new) {
      const scene::Image& from = scene_.images[index];
      EmbeddedImage made;
      made.name = sanitize_text(from.name, 200);
      std::vector<uint8_t> pixels;
      const uint32_t channels = has_opacity ? 4 : 3;
      pixels.reserve(from.rgba8.size() / 4 * channels);
      for (size_t i = 0; i + 3 < from.rgba8.size(); i += 4)
        pixels.insert(pixels.end(), from.rgba8.data() + i, from.rgba8.data() + i + channels);
      if (Result<std::vector<std::byte>> png = png_of(pixels, from.width, from.height, channels))
        made.bytes = std::move(*png);
      to_.images.push_back(std::move(made));
    }
    return "*" + std::to_string(known->second);
  }

  const scene::Scene& scene_;
  const ImportRequest request_;
  glm::dmat4 file_from_scene_{1.0};
  ImportedMesh to_;
  uint64_t triangles_ = 0;
  std::map<Key, Surface> surfaces_;
  std::map<uint32_t, size_t> materials_;
  std::map<std::pair<uint32_t, bool>, size_t> images_;
};

}  // namespace

Result<ImportedMesh> import_gltf(const fs::path& file, const ImportRequest& request) {
  scene::LoadLimits limits;
  limits.max_file_bytes = kMaxGltfBytes;
  limits.max_image_pixels = kMaxImagePixels;
  limits.max_elements = 3 * kMaxGltfTriangles;
  limits.max_nodes = kMaxGltfNodes;
  std::vector<scene::SourceFile> sources;
  const Result<scene::Scene> scene = scene::load_gltf(file, limits, {}, &sources);
  if (!scene) {
    std::string message = scene.error().message;
    if (const std::string prefix = file.string() + ": "; message.starts_with(prefix))
      message.erase(0, prefix.size());
    return Error{message};
  }
  Result<ImportedMesh> mesh = GltfMesh(*scene, request).read();
  if (!mesh) return mesh;
  for (const std::string& warning : scene->warnings) mesh->warnings.push_back(sanitize_text(warning));
  const scene::AssetFolder folder(file);
  for (const scene::SourceFile& source : sources)
    if (!source.uri.empty() && !source.uri.starts_with("data:"))
      if (const Result<fs::path> path = folder.resolve(source.uri)) mesh->besides.add(*path);
  return mesh;
}

}  // namespace fire3dv::convert
