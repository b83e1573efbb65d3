#include "adapters/mujoco/compiled/compiled_scene.h"

#include <memory>
#include <utility>

#include "convert/glb/write_glb.h"

namespace fire3dv::convert {
namespace {

glm::dvec3 vec3(const mjtNum* v) {
  return {v[0], v[1], v[2]};
}
glm::dquat quat(const mjtNum* q) {
  return {q[0], q[1], q[2], q[3]};
}
glm::dquat quat_of_matrix(const mjtNum* rows) {
  return glm::quat_cast(glm::transpose(
      glm::dmat3(rows[0], rows[1], rows[2], rows[3], rows[4], rows[5], rows[6], rows[7], rows[8])));
}
std::array<float, 4> rgba_at(const float* from) {
  return {from[0], from[1], from[2], from[3]};
}
std::optional<size_t> index_at(int index) {
  return index >= 0 ? std::optional(static_cast<size_t>(index)) : std::nullopt;
}

class CompiledReader {
 public:
  CompiledReader(const mjModel& m, const mjData& d) : m_(m), d_(d) {}

  MjcfScene read() {
    for (int i = 0; i < m_.nbody; ++i)
      scene_.bodies.push_back({name(m_.name_bodyadr[i]),
                               i > 0 ? index_at(m_.body_parentid[i]) : std::nullopt,
                               {vec3(d_.xpos + 3 * i), quat(d_.xquat + 4 * i)}});
    for (int i = 0; i < m_.nmesh; ++i) add_mesh(i);
    for (int i = 0; i < m_.nhfield; ++i) add_height_field(i);
    for (int i = 0; i < m_.ntex; ++i) add_texture(i);
    for (int i = 0; i < m_.nmat; ++i) add_material(i);
    for (int i = 0; i < m_.ngeom; ++i) add_geom(i);
    for (int i = 0; i < m_.ncam; ++i)
      scene_.cameras.push_back({name(m_.name_camadr[i]),
                                static_cast<size_t>(m_.cam_bodyid[i]),
                                {vec3(d_.cam_xpos + 3 * i), quat_of_matrix(d_.cam_xmat + 9 * i)},
                                m_.cam_fovy[i]});
    for (int i = 0; i < m_.nlight; ++i) add_light(i);
    for (int i = 0; i < m_.ntendon; ++i) add_tendon(i);
    scene_.centre = vec3(m_.stat.center);
    scene_.extent = m_.stat.extent;
    scene_.azimuth_deg = static_cast<double>(m_.vis.global.azimuth);
    scene_.elevation_deg = static_cast<double>(m_.vis.global.elevation);
    scene_.vertical_fov_deg = static_cast<double>(m_.vis.global.fovy);
    scene_.near_per_extent = static_cast<double>(m_.vis.map.znear);
    return std::move(scene_);
  }

 private:
  std::string name(int address) const { return m_.names + address; }

  void add_mesh(int mesh) {
    auto surface = std::make_shared<Surface>();
    const int first = m_.mesh_vertadr[mesh], count = m_.mesh_vertnum[mesh];
    for (int v = first; v < first + count; ++v) {
      surface->positions.emplace_back(m_.mesh_vert[3 * v], m_.mesh_vert[3 * v + 1], m_.mesh_vert[3 * v + 2]);
      surface->normals.emplace_back(m_.mesh_normal[3 * v], m_.mesh_normal[3 * v + 1],
                                    m_.mesh_normal[3 * v + 2]);
    }
    if (const int uv = m_.mesh_texcoordadr[mesh]; uv >= 0) {
      for (int v = uv; v < uv + count; ++v)
        surface->uvs.emplace_back(m_.mesh_texcoord[2 * v], m_.mesh_texcoord[2 * v + 1]);
    }
    const int* corner = m_.mesh_face + 3 * m_.mesh_faceadr[mesh];
    surface->indices.assign(corner, corner + 3 * m_.mesh_facenum[mesh]);
    scene_.meshes.push_back(std::move(surface));
  }

  void add_height_field(int index) {
    auto field = std::make_shared<MjcfHeightField>();
    const mjtNum* size = m_.hfield_size + 4 * index;
    field->half = {size[0], size[1]};
    field->height = size[2];
    field->base = size[3];
    field->rows = static_cast<size_t>(m_.hfield_nrow[index]);
    field->columns = static_cast<size_t>(m_.hfield_ncol[index]);
    const float* heights = m_.hfield_data + m_.hfield_adr[index];
    field->data.assign(heights, heights + field->rows * field->columns);
    scene_.height_fields.push_back(std::move(field));
  }

  void add_texture(int index) {
    MjcfTexture texture;
    texture.name = name(m_.name_texadr[index]);
    texture.is_cube = m_.tex_type[index] != mjTEXTURE_2D;
    const auto width = static_cast<uint32_t>(m_.tex_width[index]),
               height = static_cast<uint32_t>(m_.tex_height[index]);
    const uint8_t* pixels = m_.tex_rgb + m_.tex_adr[index];
    const size_t count = size_t{width} * height;
    if (!texture.is_cube) {
      if (Result<std::vector<std::byte>> png = png_of({pixels, 3 * count}, width, height, 3))
        texture.image = Image{texture.name, std::move(*png)};
    } else if (count > 0) {
      glm::dvec3 sum(0);
      for (size_t i = 0; i < count; ++i)
        sum += glm::dvec3(
            linear_from_srgb(glm::vec3(pixels[3 * i], pixels[3 * i + 1], pixels[3 * i + 2]) / 255.0f));
      texture.mean_color = glm::vec3(sum / static_cast<double>(count));
    }
    scene_.textures.push_back(std::move(texture));
  }

  void add_material(int index) {
    MjcfMaterial material;
    material.name = name(m_.name_matadr[index]);
    material.rgba = rgba_at(m_.mat_rgba + 4 * index);
    material.emission = m_.mat_emission[index];
    material.specular = m_.mat_specular[index];
    material.shininess = m_.mat_shininess[index];
    material.reflectance = m_.mat_reflectance[index];
    material.texture = index_at(m_.mat_texid[index]);
    material.texture_repeats = {m_.mat_texrepeat[2 * index], m_.mat_texrepeat[2 * index + 1]};
    material.texture_is_uniform = m_.mat_texuniform[index] != 0;
    scene_.materials.push_back(std::move(material));
  }

  void add_geom(int index) {
    MjcfGeom geom;
    geom.name = name(m_.name_geomadr[index]);
    geom.body = static_cast<size_t>(m_.geom_bodyid[index]);
    geom.size = vec3(m_.geom_size + 3 * index);
    geom.pose = {vec3(m_.geom_pos + 3 * index), quat(m_.geom_quat + 4 * index)};
    geom.group = m_.geom_group[index];
    geom.rgba = rgba_at(m_.geom_rgba + 4 * index);
    geom.material = index_at(m_.geom_matid[index]);
    switch (m_.geom_type[index]) {
      case mjGEOM_PLANE:
        geom.shape = MjcfShape::plane;
        break;
      case mjGEOM_HFIELD:
        geom.shape = MjcfShape::height_field;
        break;
      case mjGEOM_SPHERE:
        geom.shape = MjcfShape::sphere;
        break;
      case mjGEOM_CAPSULE:
        geom.shape = MjcfShape::capsule;
        break;
      case mjGEOM_ELLIPSOID:
        geom.shape = MjcfShape::ellipsoid;
        break;
      case mjGEOM_CYLINDER:
        geom.shape = MjcfShape::cylinder;
        break;
      case mjGEOM_BOX:
        geom.shape = MjcfShape::box;
        break;
      default:  // of other types nothing is drawn: they have no mesh
        geom.shape = MjcfShape::mesh;
    }
    if (geom.shape == MjcfShape::mesh || geom.shape == MjcfShape::height_field)
      geom.data = index_at(m_.geom_dataid[index]);
    scene_.geoms.push_back(std::move(geom));
  }

  void add_light(int index) {
    MjcfLight light;
    light.name = name(m_.name_lightadr[index]);
    light.body = static_cast<size_t>(m_.light_bodyid[index]);
    light.position = vec3(d_.light_xpos + 3 * index);
    light.direction = vec3(d_.light_xdir + 3 * index);
    const float* diffuse = m_.light_diffuse + 3 * index;
    light.diffuse = {diffuse[0], diffuse[1], diffuse[2]};
    light.cutoff_deg = static_cast<double>(m_.light_cutoff[index]);
    light.type = m_.light_directional[index] ? Light::Type::directional
                 : light.cutoff_deg > 90     ? Light::Type::point
                                             : Light::Type::spot;
    light.is_active = is_scene_light(m_, index);
    scene_.lights.push_back(std::move(light));
  }

  void add_tendon(int index) {
    MjcfTendon tendon;
    tendon.name = name(m_.name_tendonadr[index]);
    tendon.max_points = max_tendon_points(m_, index);
    tendon.rgba = rgba_at(m_.tendon_rgba + 4 * index);
    tendon.material = index_at(m_.tendon_matid[index]);
    if (tendon.max_points > 0) tendon_pieces(m_, d_, index, tendon.pieces);
    scene_.tendons.push_back(std::move(tendon));
  }

  const mjModel& m_;
  const mjData& d_;
  MjcfScene scene_;
};

}  // namespace

MjcfScene compiled_scene(const mjModel& model, const mjData& data) {
  return CompiledReader(model, data).read();
}

void add_mjcf(const mjModel& model, const mjData& data, const ReadOptions& options, Model& to) {
  add_mjcf(compiled_scene(model, data), options, to);
  if (model.nskin > 0) to.warnings.push_back("skins are not shown: " + std::to_string(model.nskin));
}

}  // namespace fire3dv::convert
