// MJCF as libmujoco compiles it: includes, defaults and units are its business, and so is the initial pose.
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <memory>
#include <mutex>
#include <numbers>
#include <set>
#include <utility>

#include "renderer/scene/files.h"
#include "tools/convert/colors.h"
#include "tools/convert/lights.h"
#include "tools/convert/mesh_store.h"
#include "tools/convert/mjcf_files.h"
#include "tools/convert/mjcf_looks.h"
#include "tools/convert/readers.h"
#include "tools/convert/shapes.h"

namespace fire3dv::convert {
namespace {

// libmujoco ends the process on a fault unless a handler does not return. Both stand for the whole process.
std::mutex faults_mutex;
std::jmp_buf after_fault;
char fault_text[1024];
std::vector<std::string>* warnings_said;

void on_fault(const char* text) {
  std::snprintf(fault_text, sizeof fault_text, "%s", text);
  std::longjmp(after_fault, 1);
}

void on_warning(const char* text) {
  constexpr size_t kMost = 100;
  if (warnings_said->size() < kMost) warnings_said->push_back(std::string("MuJoCo: ") + text);
}

std::string one_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  for (char& c : text)
    if (c == '\n') c = ' ';
  return text;
}

// Nothing with a destructor may stand between this and a fault.
mjModel* compile(const char* file, char* error, int error_size) {
  if (setjmp(after_fault) != 0) {
    std::snprintf(error, static_cast<size_t>(error_size), "%s", fault_text);
    return nullptr;
  }
  return mj_loadXML(file, nullptr, error, error_size);
}

mjData* pose(const mjModel* model) {
  if (setjmp(after_fault) != 0) return nullptr;
  mjData* data = mj_makeData(model);
  if (!data) return nullptr;
  if (model->nkey > 0)
    mj_resetDataKeyframe(model, data, 0);
  else
    mj_resetData(model, data);
  mj_kinematics(model, data);
  mj_comPos(model, data);
  mj_camlight(model, data);
  return data;
}

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
  Reader(const mjModel& m, const mjData& d, size_t most_triangles, Model& model)
      : m_(m), d_(d), model_(model), looks_(m, model), meshes_(model, most_triangles) {}

  void read() {
    add_free_camera();
    const size_t first_body = model_.nodes.size();
    for (int body = 0; body < m_.nbody; ++body) names_.insert(body_name(body));
    for (int body = 0; body < m_.nbody; ++body) add_body(body, first_body);
    for (int camera = 0; camera < m_.ncam; ++camera) add_camera(camera, first_body);
    for (int light = 0; light < m_.nlight; ++light) add_light(light, first_body);
    if (m_.nskin > 0) model_.warnings.push_back("skins are not shown: " + std::to_string(m_.nskin));
    if (model_.meshes.empty()) model_.warnings.push_back("no geoms of the groups 0 to 2: nothing is seen");
  }

 private:
  const char* name_at(int address) const { return m_.names + address; }

  std::string body_name(int body) const {
    const std::string name = name_at(m_.name_bodyadr[body]);
    return name.empty() ? "body_" + std::to_string(body) : name;  // MuJoCo calls body 0 "world"
  }

  // Streams find nodes by name: what is no body does not take a body's.
  std::string free_name(std::string name, const std::string& kind) {
    if (name.empty()) name = kind;
    if (names_.insert(name).second) return name;
    for (int i = 0;; ++i) {
      const std::string other = name + " " + kind + (i ? " " + std::to_string(i) : "");
      if (names_.insert(other).second) return other;
    }
  }

  // What MuJoCo's own viewer shows first.
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
    node.name = free_name(camera.name, "camera");
    node.translation = vec3(m_.stat.center) - distance * forward;
    node.rotation = glm::quat_cast(glm::dmat3(right, glm::cross(right, forward), -forward));
    node.camera = model_.cameras.size();
    model_.cameras.push_back(camera);
    model_.nodes.push_back(node);
  }

  void add_body(int body, size_t first_body) {
    Node node;
    node.name = body_name(body);
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
    node.mesh = mesh_of(body, node.name);
    model_.nodes.push_back(std::move(node));
  }

  std::optional<size_t> mesh_of(int body, const std::string& name) {
    Mesh mesh;
    mesh.name = name;
    for (int i = 0; i < m_.body_geomnum[body]; ++i) {
      const int geom = m_.body_geomadr[body] + i;
      if (!looks_.is_shown(geom)) continue;
      if (!meshes_.take_shape(mesh)) {
        if (!std::exchange(said_full_, true))
          model_.warnings.push_back("body \"" + name +
                                    "\" and those after it lack geoms: " + meshes_.why_full());
        break;
      }
      add_surface(mesh, looks_.shape(geom),
                  matrix_of(vec3(m_.geom_pos + 3 * geom), quat(m_.geom_quat + 4 * geom)),
                  looks_.material(geom));
    }
    return meshes_.keep(std::move(mesh));
  }

  // In the frame of its body, where it moves with it.
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
    node.name = free_name(camera.name, "camera");
    node.camera = model_.cameras.size();
    model_.cameras.push_back(camera);
    model_.nodes.push_back(std::move(node));
  }

  void add_light(int index, size_t first_body) {
    const glm::dvec3 direction = vec3(d_.light_xdir + 3 * index), place = vec3(d_.light_xpos + 3 * index);
    if (!m_.light_active[index] || !(glm::length(direction) > 0)) return;
    Light light;
    light.name = name_at(m_.name_lightadr[index]);
    if (light.name.empty()) light.name = "light_" + std::to_string(index);
    const float* diffuse = m_.light_diffuse + 3 * index;
    const glm::vec3 color = linear_from_srgb(glm::vec3(diffuse[0], diffuse[1], diffuse[2]));
    const float brightest = std::max({color.r, color.g, color.b});
    if (!(brightest > 0)) return;
    light.color = color / brightest;
    // MuJoCo's light has no unit: a white surface that faces it looks white. So it does at this intensity,
    // pi lux at the surface, for those that shine from somewhere where the middle of the scene is.
    light.intensity = brightest * std::numbers::pi_v<float>;
    if (m_.light_directional[index]) {
      light.type = Light::Type::directional;
    } else {
      const glm::dvec3 way = vec3(m_.stat.center) - place;
      light.intensity *= static_cast<float>(std::max(glm::dot(way, way), 1e-4));
      const float cutoff = m_.light_cutoff[index];
      light.type = cutoff > 90 ? Light::Type::point : Light::Type::spot;
      light.outer_cone_rad = glm::radians(cutoff);
      light.inner_cone_rad = 0.8f * light.outer_cone_rad;  // its exponent softens the edge likewise
    }
    Node node = node_in_body(m_.light_bodyid[index], place, shining(direction), first_body);
    node.name = free_name(light.name, "light");
    node.light = model_.lights.size();
    model_.lights.push_back(light);
    model_.nodes.push_back(std::move(node));
  }

  const mjModel& m_;
  const mjData& d_;
  Model& model_;
  MjcfLooks looks_;
  std::set<std::string> names_;
  MeshStore meshes_;
  bool said_full_ = false;
};

}  // namespace

Result<Model> read_mjcf(const std::filesystem::path& file, const ReadOptions& options) {
  Model model;
  Result<Sources> files = mjcf_files(file);
  if (!files) return files.error();
  model.sources = std::move(*files);
  model.name = file.stem().string();

  const std::lock_guard lock(faults_mutex);
  warnings_said = &model.warnings;
  mju_user_error = on_fault;
  mju_user_warning = on_warning;
  char text[1024] = "";
  const std::unique_ptr<mjModel, decltype(&mj_deleteModel)> compiled(compile(file.c_str(), text, sizeof text),
                                                                     &mj_deleteModel);
  if (!compiled) return Error{scene::quote(file.string()) + ": " + one_line(text)};
  if (*text) model.warnings.push_back("MuJoCo: " + one_line(text));
  const std::unique_ptr<mjData, decltype(&mj_deleteData)> posed(pose(compiled.get()), &mj_deleteData);
  if (!posed) return Error{scene::quote(file.string()) + ": it cannot be posed: " + one_line(fault_text)};
  Reader(*compiled, *posed, options.most_triangles, model).read();
  return model;
}

}  // namespace fire3dv::convert
