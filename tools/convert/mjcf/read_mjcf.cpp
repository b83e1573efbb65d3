// Reader for MJCF as compiled by libmujoco, which handles includes, defaults, units and the initial pose.
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "renderer/scene/files.h"
#include "tools/convert/mesh/mesh_store.h"
#include "tools/convert/mesh/surfaces.h"
#include "tools/convert/mjcf/mjcf_appearance.h"
#include "tools/convert/mjcf/mjcf_files.h"
#include "tools/convert/mjcf/mjcf_load.h"
#include "tools/convert/mjcf/mjcf_nodes.h"
#include "tools/convert/model.h"
#include "tools/convert/readers.h"

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

class Reader {
 public:
  Reader(const mjModel& m, const mjData& d, const ReadOptions& options, Model& model)
      : m_(m),
        d_(d),
        options_(options),
        model_(model),
        appearance_(m, model),
        names_(m),
        meshes_(model, options.most_triangles) {}

  void read() {
    add_free_camera();
    const size_t first_body = model_.nodes.size();
    for (int body = 0; body < m_.nbody; ++body) add_body(body, first_body);
    for (int camera = 0; camera < m_.ncam; ++camera) add_camera(camera, first_body);
    for (int light = 0; light < m_.nlight; ++light) add_light(light, first_body);
    if (options_.geoms_apart)
      for (int geom = 0; geom < m_.ngeom; ++geom) add_geom(geom, first_body);
    for (int tendon = 0; tendon < m_.ntendon; ++tendon) add_tendon(tendon);
    if (m_.nskin > 0) model_.warnings.push_back("skins are not shown: " + std::to_string(m_.nskin));
    if (model_.meshes.empty()) model_.warnings.push_back("no geoms of the groups 0 to 2: nothing is visible");
  }

 private:
  const char* name_at(int address) const { return m_.names + address; }

  // Adds the initial view of MuJoCo's viewer.
  void add_free_camera() {
    const double azimuth = glm::radians(static_cast<double>(m_.vis.global.azimuth));
    const double elevation = glm::radians(static_cast<double>(m_.vis.global.elevation));
    const glm::dvec3 forward(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                             std::sin(elevation));
    const glm::dvec3 right(std::sin(azimuth), -std::cos(azimuth), 0);
    const double distance = 1.5 * m_.stat.extent;
    Camera camera;
    camera.name = "free camera";
    camera.vertical_fov_rad = glm::radians(m_.vis.global.fovy);
    camera.near_m = static_cast<float>(m_.vis.map.znear * m_.stat.extent);
    Node node;
    node.name = names_.free_camera;
    node.translation = vec3(m_.stat.center) - distance * forward;
    node.rotation = glm::quat_cast(glm::dmat3(right, glm::cross(right, forward), -forward));
    node.camera = model_.cameras.size();
    model_.cameras.push_back(camera);
    model_.nodes.push_back(node);
  }

  void add_body(int body, size_t first_body) {
    Node node;
    node.name = names_.bodies[static_cast<size_t>(body)];
    const glm::dquat world_turn = quat(d_.xquat + 4 * body);
    if (body == 0) {
      node.translation = vec3(d_.xpos);
      node.rotation = world_turn;
    } else {
      const int parent = m_.body_parentid[body];
      node.parent = first_body + static_cast<size_t>(parent);
      const glm::dquat to_parent = glm::conjugate(quat(d_.xquat + 4 * parent));
      node.translation = to_parent * (vec3(d_.xpos + 3 * body) - vec3(d_.xpos + 3 * parent));
      node.rotation = to_parent * world_turn;
    }
    if (!options_.geoms_apart) node.mesh = mesh_of(m_.body_geomadr[body], m_.body_geomnum[body], node.name);
    model_.nodes.push_back(std::move(node));
  }

  // Adds a geom as a child node of its body.
  void add_geom(int geom, size_t first_body) {
    if (!appearance_.is_shown(geom)) return;
    Node node;
    node.parent = first_body + static_cast<size_t>(m_.geom_bodyid[geom]);
    node.name = names_.geoms[static_cast<size_t>(geom)];
    node.translation = vec3(m_.geom_pos + 3 * geom);
    node.rotation = quat(m_.geom_quat + 4 * geom);
    node.mesh = mesh_of(geom, 1, node.name);
    model_.nodes.push_back(std::move(node));
  }

  // Builds the mesh in the frame of the body, or of a geom with its own node.
  std::optional<size_t> mesh_of(int first_geom, int geoms, const std::string& name) {
    Mesh mesh;
    mesh.name = name;
    for (int geom = first_geom; geom < first_geom + geoms; ++geom) {
      if (!appearance_.is_shown(geom)) continue;
      if (!has_room(mesh)) break;
      const glm::dmat4 mesh_from_geom =
          options_.geoms_apart ? glm::dmat4(1)
                               : matrix_of(vec3(m_.geom_pos + 3 * geom), quat(m_.geom_quat + 4 * geom));
      add_surface(mesh, appearance_.shape(geom), mesh_from_geom, appearance_.material(geom));
    }
    return meshes_.add(std::move(mesh));
  }

  // Returns a node in the frame of its body, with which it moves.
  Node node_in_body(int body, const glm::dvec3& place, const glm::dquat& turn, size_t first_body) const {
    const glm::dquat to_body = glm::conjugate(quat(d_.xquat + 4 * body));
    Node node;
    node.parent = first_body + static_cast<size_t>(body);
    node.translation = to_body * (place - vec3(d_.xpos + 3 * body));
    node.rotation = to_body * turn;
    return node;
  }

  void add_camera(int index, size_t first_body) {
    Camera camera;
    camera.name = name_at(m_.name_camadr[index]);
    if (camera.name.empty()) camera.name = "camera_" + std::to_string(index);
    camera.vertical_fov_rad = static_cast<float>(glm::radians(m_.cam_fovy[index]));
    camera.near_m = static_cast<float>(m_.vis.map.znear * m_.stat.extent);
    Node node = node_in_body(m_.cam_bodyid[index], vec3(d_.cam_xpos + 3 * index),
                             quat_of_matrix(d_.cam_xmat + 9 * index), first_body);
    node.name = names_.cameras[static_cast<size_t>(index)];
    node.camera = model_.cameras.size();
    model_.cameras.push_back(camera);
    model_.nodes.push_back(std::move(node));
  }

  void add_light(int index, size_t first_body) {
    const glm::dvec3 direction = vec3(d_.light_xdir + 3 * index), place = vec3(d_.light_xpos + 3 * index);
    if (!is_scene_light(m_, index)) return;
    Light light;
    light.name = name_at(m_.name_lightadr[index]);
    if (light.name.empty()) light.name = "light_" + std::to_string(index);
    const float* diffuse = m_.light_diffuse + 3 * index;
    const glm::vec3 color = linear_from_srgb(glm::vec3(diffuse[0], diffuse[1], diffuse[2]));
    const float brightest = std::max({color.r, color.g, color.b});
    light.color = color / brightest;
    // MuJoCo's lights have no unit: a white surface that faces one appears white. That is pi lux at the
    // surface; for positional lights, at the scene centre.
    light.intensity = brightest * std::numbers::pi_v<float>;
    if (m_.light_directional[index]) {
      light.type = Light::Type::directional;
    } else {
      const glm::dvec3 way = vec3(m_.stat.center) - place;
      light.intensity *= static_cast<float>(std::max(glm::dot(way, way), 1e-4));
      const float cutoff = m_.light_cutoff[index];
      light.type = cutoff > 90 ? Light::Type::point : Light::Type::spot;
      light.outer_cone_rad = glm::radians(cutoff);
      light.inner_cone_rad = 0.8f * light.outer_cone_rad;  // approximates the soft edge of MuJoCo's exponent
    }
    Node node = node_in_body(m_.light_bodyid[index], place, shining(direction), first_body);
    node.name = names_.lights[static_cast<size_t>(index)];
    node.light = model_.lights.size();
    model_.lights.push_back(light);
    model_.nodes.push_back(std::move(node));
  }

  // Adds unit cylinders and balls, which the pose scales.
  void add_tendon(int tendon) {
    std::vector<TendonPiece> scratch;
    std::vector<TendonFrame> frames;
    tendon_frames(m_, d_, tendon, scratch, frames);
    if (frames.empty()) return;
    const auto& pieces = names_.tendon_pieces[static_cast<size_t>(tendon)];
    const auto& ends = names_.tendon_ends[static_cast<size_t>(tendon)];
    const size_t material = appearance_.tendon_material(tendon);
    const auto piece_mesh = add_mesh(pieces.front(), cylinder(1, 1), material);
    const auto end_mesh = add_mesh(ends.front(), ellipsoid(glm::dvec3(1)), material);
    for (size_t i = 0; i < frames.size(); ++i) {
      const bool is_piece = i < pieces.size();
      Node node;
      node.name = is_piece ? pieces[i] : ends[i - pieces.size()];
      node.translation = frames[i].place;
      node.rotation = glm::quat_cast(frames[i].turn);
      node.scale = frames[i].scale;
      node.mesh = is_piece ? piece_mesh : end_mesh;
      model_.nodes.push_back(std::move(node));
    }
  }

  std::optional<size_t> add_mesh(const std::string& name, const Surface& surface, size_t material) {
    Mesh mesh;
    mesh.name = name;
    if (has_room(mesh)) add_surface(mesh, surface, glm::dmat4(1), material);
    return meshes_.add(std::move(mesh));
  }

  bool has_room(const Mesh& mesh) {
    if (meshes_.take_shape(mesh)) return true;
    if (!std::exchange(said_full_, true))
      model_.warnings.push_back("\"" + mesh.name + "\" and those after it lack geoms: " + meshes_.why_full());
    return false;
  }

  const mjModel& m_;
  const mjData& d_;
  const ReadOptions& options_;
  Model& model_;
  MjcfAppearance appearance_;
  const MjcfNames names_;
  MeshStore meshes_;
  bool said_full_ = false;
};

}  // namespace

void add_mjcf(const mjModel& compiled, const mjData& posed, const ReadOptions& options, Model& model) {
  Reader(compiled, posed, options, model).read();
}

Result<Model> read_mjcf(const std::filesystem::path& file, const ReadOptions& options) {
  Model model;
  Result<Sources> files = mjcf_files(file, options.package_folders);
  if (!files) return files.error();
  model.sources = std::move(*files);
  model.name = file.stem().string();
  const Result<MjcfModel> compiled = compile_mjcf(file, &model.warnings);
  if (!compiled) return compiled.error();
  const Result<MjcfData> posed = pose_mjcf(**compiled, &model.warnings);
  if (!posed) return Error{quote(file.string()) + ": " + posed.error().message};
  add_mjcf(**compiled, **posed, options, model);
  return model;
}

}  // namespace fire3dv::convert
