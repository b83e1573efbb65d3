#include "tools/convert/mjcf/mjcf_appearance.h"

#include <algorithm>
#include <cmath>

#include "tools/convert/glb/write_glb.h"
#include "tools/convert/mesh/surfaces.h"
#include "tools/convert/mjcf/mjcf_nodes.h"
#include "tools/convert/model.h"

namespace fire3dv::convert {
namespace {

constexpr double kInfinitePlaneExtents =
    // Half side of an infinite plane, in scene extents.
    10;

Surface mesh_shape(const mjModel& m, int mesh) {
  Surface surface;
  const int first = m.mesh_vertadr[mesh], count = m.mesh_vertnum[mesh];
  for (int v = first; v < first + count; ++v) {
    surface.positions.emplace_back(m.mesh_vert[3 * v], m.mesh_vert[3 * v + 1], m.mesh_vert[3 * v + 2]);
    surface.normals.emplace_back(m.mesh_normal[3 * v], m.mesh_normal[3 * v + 1], m.mesh_normal[3 * v + 2]);
  }
  if (const int uv = m.mesh_texcoordadr[mesh]; uv >= 0) {
    for (int v = uv; v < uv + count; ++v)
      surface.uvs.emplace_back(m.mesh_texcoord[2 * v], m.mesh_texcoord[2 * v + 1]);
  }
  const int* corner = m.mesh_face + 3 * m.mesh_faceadr[mesh];
  surface.indices.assign(corner, corner + 3 * m.mesh_facenum[mesh]);
  return surface;
}

// Height field surface with side walls down to its base.
Surface height_field(const mjModel& m, int field) {
  const mjtNum* size = m.hfield_size + 4 * field;
  const int rows = m.hfield_nrow[field], columns = m.hfield_ncol[field];
  const float* heights = m.hfield_data + m.hfield_adr[field];
  Surface surface;
  const auto place = [&](int row, int column) {
    return glm::dvec3(size[0] * (2.0 * column / (columns - 1) - 1), size[1] * (2.0 * row / (rows - 1) - 1),
                      size[2] * static_cast<double>(heights[row * columns + column]));
  };
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      surface.positions.push_back(place(row, column));
      surface.uvs.push_back(
          glm::dvec2(static_cast<double>(column) / (columns - 1), 1 - static_cast<double>(row) / (rows - 1)));
      const glm::dvec3 along_x =
          place(row, std::min(column + 1, columns - 1)) - place(row, std::max(column - 1, 0));
      const glm::dvec3 along_y =
          place(std::min(row + 1, rows - 1), column) - place(std::max(row - 1, 0), column);
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
    const glm::dvec3 from = place(edge[i].first, edge[i].second),
                     to = place(edge[i + 1].first, edge[i + 1].second);
    const glm::dvec2 way(to - from);
    const glm::vec3 outwards = glm::normalize(glm::dvec3(way.y, -way.x, 0));
    const auto first = static_cast<uint32_t>(surface.positions.size());
    for (const glm::dvec3& corner : {from, to})
      for (const double z : {-size[3], corner.z})
        surface.positions.push_back(glm::dvec3(corner.x, corner.y, z));
    surface.normals.resize(surface.positions.size(), outwards);
    surface.uvs.resize(surface.positions.size(), glm::vec2(0));
    surface.indices.insert(surface.indices.end(), {first, first + 2, first + 3, first, first + 3, first + 1});
  }
  return surface;
}

}  // namespace

bool MjcfAppearance::is_shown(int geom) const {
  return is_shown_group(m_.geom_group[geom]) && rgba(geom)[3] > 0;
}

std::array<float, 4> MjcfAppearance::rgba(int geom) const {
  return mjcf_color(m_, m_.geom_matid[geom], m_.geom_rgba + 4 * geom);
}

// Returns texture repetitions on a plane: relative to its size, or per unit of length.
glm::dvec2 MjcfAppearance::plane_repeats(int geom, const glm::dvec2& half) const {
  const int material = m_.geom_matid[geom];
  if (material < 0) return glm::dvec2(1);
  const glm::dvec2 repeats(m_.mat_texrepeat[2 * material], m_.mat_texrepeat[2 * material + 1]);
  return m_.mat_texuniform[material] ? repeats * half : repeats;
}

Surface MjcfAppearance::shape(int geom) const {
  const mjtNum* size = m_.geom_size + 3 * geom;
  switch (m_.geom_type[geom]) {
    case mjGEOM_PLANE: {
      const double endless = std::max(m_.stat.extent, 0.1) * kInfinitePlaneExtents;
      const glm::dvec2 half(size[0] > 0 ? size[0] : endless, size[1] > 0 ? size[1] : endless);
      return rectangle(half.x, half.y, plane_repeats(geom, half));
    }
    case mjGEOM_HFIELD:
      return height_field(m_, m_.geom_dataid[geom]);
    case mjGEOM_SPHERE:
      return ellipsoid(glm::dvec3(size[0]));
    case mjGEOM_CAPSULE:
      return capsule(size[0], size[1]);
    case mjGEOM_ELLIPSOID:
      return ellipsoid({size[0], size[1], size[2]});
    case mjGEOM_CYLINDER:
      return cylinder(size[0], size[1]);
    case mjGEOM_BOX:
      return box({size[0], size[1], size[2]});
    case mjGEOM_MESH:
      return m_.geom_dataid[geom] >= 0 ? mesh_shape(m_, m_.geom_dataid[geom]) : Surface();
    default:
      return {};
  }
}

size_t MjcfAppearance::tendon_material(int tendon) {
  const int index = m_.tendon_matid[tendon];
  return material_of(index, mjcf_color(m_, index, m_.tendon_rgba + 4 * tendon));
}

size_t MjcfAppearance::material_of(int index, const std::array<float, 4>& color) {
  const auto [known, is_new] = materials_.try_emplace({index, color}, model_.materials.size());
  if (!is_new) return known->second;
  Material made;
  const glm::vec4 display(color[0], color[1], color[2], color[3]);
  made.base_color = linear_from_srgb(display);
  made.blended = display.a < 1;
  float shininess = 0.5f, specular = 0.5f;  // MuJoCo's values without a material
  if (index >= 0) {
    made.name = m_.names + m_.name_matadr[index];
    made.base_color_image = image(index);
    made.emission = linear_from_srgb(glm::vec3(display) * m_.mat_emission[index]);
    made.metallic = std::clamp(m_.mat_reflectance[index], 0.0f, 1.0f);
    shininess = m_.mat_shininess[index];
    specular = m_.mat_specular[index];
  }
  // Roughness with equal lobe width; weakly specular materials get a higher one.
  const float exponent = std::clamp(shininess, 0.0f, 1.0f) * 128;
  const float lobe = std::pow(2 / (exponent + 2), 0.25f);
  made.roughness = glm::mix(1.0f, lobe, std::clamp(2 * specular, 0.0f, 1.0f));
  model_.materials.push_back(std::move(made));
  return known->second;
}

std::optional<size_t> MjcfAppearance::image(int material_index) {
  const int texture = m_.mat_texid[material_index];
  if (texture < 0) return std::nullopt;
  const auto [known, is_new] = images_.try_emplace(texture, std::nullopt);
  if (!is_new) return known->second;
  const std::string name = m_.names + m_.name_texadr[texture];
  if (m_.tex_type[texture] != mjTEXTURE_2D) {
    model_.warnings.push_back("texture \"" + name +
                              "\" is a cube, which glTF has not: its materials show their colour alone");
    return std::nullopt;
  }
  const auto width = static_cast<uint32_t>(m_.tex_width[texture]),
             height = static_cast<uint32_t>(m_.tex_height[texture]);
  const uint8_t* pixels = m_.tex_rgb + m_.tex_adr[texture];
  Result<std::vector<std::byte>> png = png_of({pixels, size_t{3} * width * height}, width, height, 3);
  if (!png) {
    model_.warnings.push_back("texture \"" + name + "\": " + png.error().message);
    return std::nullopt;
  }
  known->second = model_.images.size();
  model_.images.push_back({name, std::move(*png)});
  return known->second;
}

}  // namespace fire3dv::convert
