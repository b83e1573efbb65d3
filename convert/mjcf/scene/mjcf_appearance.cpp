#include "convert/mjcf/scene/mjcf_appearance.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "convert/surfaces.h"

namespace fire3dv::convert {
namespace {

constexpr int kShownGroups = 3;
// Height field surface with side walls down to its base.
Surface height_field(const MjcfHeightField& field) {
  const int rows = static_cast<int>(field.rows), columns = static_cast<int>(field.columns);
  Surface surface;
  if (rows < 2 || columns < 2) return surface;
  const auto vertex_at = [&](int row, int column) {
    const auto index = static_cast<size_t>(row) * field.columns + static_cast<size_t>(column);
    return glm::dvec3(field.half.x * (2.0 * column / (columns - 1) - 1),
                      field.half.y * (2.0 * row / (rows - 1) - 1),
                      field.height * static_cast<double>(field.data[index]));
  };
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      surface.positions.push_back(vertex_at(row, column));
      surface.uvs.push_back(
          glm::dvec2(static_cast<double>(column) / (columns - 1), 1 - static_cast<double>(row) / (rows - 1)));
      const glm::dvec3 along_x =
          vertex_at(row, std::min(column + 1, columns - 1)) - vertex_at(row, std::max(column - 1, 0));
      const glm::dvec3 along_y =
          vertex_at(std::min(row + 1, rows - 1), column) - vertex_at(std::max(row - 1, 0), column);
      surface.normals.push_back(glm::normalize(glm::cross(along_x, along_y)));
    }
  }
  for (int row = 0; row + 1 < rows; ++row) {
    for (int column = 0; column + 1 < columns; ++column) {
      const auto a = static_cast<uint32_t>(row * columns + column), b = a + static_cast<uint32_t>(columns);
      surface.indices.insert(surface.indices.end(), {a, a + 1, b + 1, a, b + 1, b});
    }
  }
  // Counter-clockwise seen from above; the outside is to the right.
  std::vector<std::pair<int, int>> edge;
  for (int c = 0; c < columns; ++c) edge.emplace_back(0, c);
  for (int r = 1; r < rows; ++r) edge.emplace_back(r, columns - 1);
  for (int c = columns - 2; c >= 0; --c) edge.emplace_back(rows - 1, c);
  for (int r = rows - 2; r >= 0; --r) edge.emplace_back(r, 0);
  for (size_t i = 0; i + 1 < edge.size(); ++i) {
    const glm::dvec3 from = vertex_at(edge[i].first, edge[i].second),
                     to = vertex_at(edge[i + 1].first, edge[i + 1].second);
    const glm::dvec2 way(to - from);
    const glm::vec3 outwards = glm::normalize(glm::dvec3(way.y, -way.x, 0));
    const auto first = static_cast<uint32_t>(surface.positions.size());
    for (const glm::dvec3& corner : {from, to})
      for (const double z : {-field.base, corner.z})
        surface.positions.push_back(glm::dvec3(corner.x, corner.y, z));
    surface.normals.resize(surface.positions.size(), outwards);
    surface.uvs.resize(surface.positions.size(), glm::vec2(0));
    surface.indices.insert(surface.indices.end(), {first, first + 2, first + 3, first, first + 3, first + 1});
  }
  return surface;
}

Surface primitive(const MjcfGeom& geom) {
  const glm::dvec3& size = geom.size;
  switch (geom.shape) {
    case MjcfShape::sphere:
      return ellipsoid(glm::dvec3(size.x));
    case MjcfShape::capsule:
      return capsule(size.x, size.y);
    case MjcfShape::ellipsoid:
      return ellipsoid(size);
    case MjcfShape::cylinder:
      return cylinder(size.x, size.y);
    case MjcfShape::box:
      return box(size);
    default:
      return {};
  }
}

}  // namespace

bool is_shown_group(int group) {
  return group < kShownGroups;
}

const std::array<float, 4>& mjcf_color(const std::array<float, 4>& own,
                                       const std::array<float, 4>* material) {
  constexpr std::array<float, 4> kDefault{0.5f, 0.5f, 0.5f, 1};
  return material && own == kDefault ? *material : own;
}

bool is_infinite_plane(const MjcfGeom& geom) {
  return geom.shape == MjcfShape::plane && !(geom.size.x > 0 && geom.size.y > 0);
}

bool is_scene_light(const MjcfLight& light) {
  return light.is_active && glm::length(light.direction) > 0 &&
         std::max({light.diffuse.r, light.diffuse.g, light.diffuse.b}) > 0;
}

const std::array<float, 4>& MjcfAppearance::color(const std::array<float, 4>& own,
                                                  std::optional<size_t> material) const {
  return mjcf_color(own, material ? &scene_.materials[*material].rgba : nullptr);
}

bool MjcfAppearance::is_shown(const MjcfGeom& geom) const {
  return is_shown_group(geom.group) && color(geom.rgba, geom.material)[3] > 0;
}

bool MjcfAppearance::is_shown(const MjcfSkin& skin) const {
  return is_shown_group(skin.group) && color(skin.rgba, skin.material)[3] > 0;
}

bool MjcfAppearance::has_flat_texture(const MjcfGeom& geom) const {
  if (!geom.material) return false;
  const std::optional<size_t> texture = scene_.materials[*geom.material].texture;
  return texture && scene_.textures[*texture].image;
}

// Returns texture repetitions over a geom: relative to its size, or per unit of length.
glm::dvec2 MjcfAppearance::repeats(const MjcfGeom& geom, const glm::dvec2& half) const {
  if (!geom.material) return glm::dvec2(1);
  const MjcfMaterial& material = scene_.materials[*geom.material];
  return material.texture_is_uniform ? material.texture_repeats * half : material.texture_repeats;
}

// A mesh without coordinates shows a 2D texture from above, once over its extent, or per two units of length.
void MjcfAppearance::project_texture(const MjcfGeom& geom, Surface& surface) const {
  const MjcfMaterial& material = scene_.materials[*geom.material];
  glm::vec2 half(0);
  for (const glm::vec3& position : surface.positions) half = glm::max(half, glm::abs(glm::vec2(position)));
  glm::vec2 scale = 0.5f * glm::vec2(material.texture_repeats);
  if (!material.texture_is_uniform) scale /= glm::max(half, glm::vec2(1e-6f));
  for (const glm::vec3& position : surface.positions)
    surface.uvs.emplace_back(0.5f + scale.x * position.x, 0.5f - scale.y * position.y);
}

Surface MjcfAppearance::surface(const MjcfGeom& geom) const {
  if (geom.shape == MjcfShape::plane) {
    if (!is_infinite_plane(geom))
      return rectangle(geom.size.x, geom.size.y, repeats(geom, glm::dvec2(geom.size)));
    const double extent = std::max(scene_.extent, 0.1);
    // Textures of infinite planes repeat per unit of length.
    const glm::dvec2 unit(geom.size.x > 0 ? geom.size.x : 1, geom.size.y > 0 ? geom.size.y : 1);
    return horizon_plane(glm::max(glm::dvec2(geom.size), 0.0), extent, repeats(geom, unit) / unit);
  }
  if (geom.shape == MjcfShape::height_field) {
    const auto& field = geom.data ? scene_.height_fields[*geom.data] : nullptr;
    return field ? height_field(*field) : Surface();
  }
  Surface surface;
  if (geom.shape == MjcfShape::mesh) {
    const auto& mesh = geom.data ? scene_.meshes[*geom.data] : nullptr;
    if (mesh) surface = *mesh;
    if (surface.uvs.empty() && has_flat_texture(geom)) {
      project_texture(geom, surface);
    } else if (!surface.uvs.empty() && geom.material) {
      const glm::vec2 scale(scene_.materials[*geom.material].texture_repeats);
      for (glm::vec2& uv : surface.uvs) uv *= scale;
    }
  } else {
    surface = primitive(geom);
    // MuJoCo 3.12 and newer: repeats, and for uniform ones also the size, multiply the coordinates of
    // primitives.
    const double second = geom.size.y > 0 ? geom.size.y : geom.size.x;
    const glm::vec2 scale(repeats(geom, {geom.size.x, second}));
    for (glm::vec2& uv : surface.uvs) uv *= scale;
  }
  return surface;
}

size_t MjcfAppearance::material(std::optional<size_t> index, const std::array<float, 4>& rgba) {
  const auto [known, is_new] = materials_.try_emplace({index, rgba}, model_.materials.size());
  if (!is_new) return known->second;
  Material made;
  const glm::vec4 display(rgba[0], rgba[1], rgba[2], rgba[3]);
  made.base_color = linear_from_srgb(display);
  made.blended = display.a < 1;
  MjcfMaterial from;  // MuJoCo's values without a material
  if (index) {
    from = scene_.materials[*index];
    made.name = from.name;
    if (from.texture) {
      const MjcfTexture& texture = scene_.textures[*from.texture];
      made.base_color_image = image(*from.texture);
      if (texture.is_cube) made.base_color *= glm::vec4(texture.mean_color, 1);
      made.blended = made.blended || (texture.has_opacity && made.base_color_image);
    }
    if (from.normal_texture) made.normal_image = image(*from.normal_texture);
    made.emission = linear_from_srgb(glm::vec3(display) * from.emission);
  }
  made.metallic = std::clamp(from.metallic.value_or(from.reflectance), 0.0f, 1.0f);
  // Roughness with equal lobe width; weakly specular materials get a higher one.
  const float exponent = std::clamp(from.shininess, 0.0f, 1.0f) * 128;
  const float lobe = std::pow(2 / (exponent + 2), 0.25f);
  const float roughness = glm::mix(1.0f, lobe, std::clamp(2 * from.specular, 0.0f, 1.0f));
  made.roughness = std::clamp(from.roughness.value_or(roughness), 0.0f, 1.0f);
  model_.materials.push_back(std::move(made));
  return known->second;
}

std::optional<size_t> MjcfAppearance::image(size_t texture) {
  const auto [known, is_new] = images_.try_emplace(texture, std::nullopt);
  if (!is_new) return known->second;
  const MjcfTexture& from = scene_.textures[texture];
  if (from.is_cube)
    model_.warnings.push_back("texture \"" + from.name +
                              "\" is a cube, which glTF has not: its materials show its mean colour");
  if (!from.image) return std::nullopt;
  known->second = model_.images.size();
  model_.images.push_back(*from.image);
  return known->second;
}

}  // namespace fire3dv::convert
