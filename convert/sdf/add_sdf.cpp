#include "convert/sdf/add_sdf.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/text.h"
#include "convert/mesh/mesh_store.h"
#include "convert/sdf/names.h"
#include "convert/sdf/sdf_kinematics.h"
#include "convert/sdf/sdf_materials.h"
#include "convert/sdf/sdf_shapes.h"
#include "convert/sdf/sdf_warnings.h"
#include "convert/surfaces.h"

namespace fire3dv::convert {
namespace {

glm::dquat sensor_from_camera() {
  const float* m = kSensorFromCamera;
  return glm::quat_cast(glm::dmat3(m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]));
}

class SceneBuilder {
 public:
  SceneBuilder(const SdfScene& scene, const std::filesystem::path& file, const ReadOptions& options,
               SdfFiles& files, Model& model)
      : scene_(scene),
        model_(model),
        warnings_(file, model),
        meshes_(model, options.max_triangles),
        materials_(files, warnings_, model),
        shapes_(files, options, materials_, model) {}

  void build() {
    name_items();
    for (size_t i = 0; i < scene_.items.size(); ++i) add_item(i);
    extend_grounds();
    if (scene_.view) add_camera(*scene_.view, view_name_, std::nullopt);
    for (size_t i = 0; i < scene_.items.size(); ++i) {
      if (scene_.items[i].light) add_light(i);
      if (scene_.items[i].camera) add_camera(*scene_.items[i].camera, names_[i], i);
    }
    std::vector<std::string> warnings;
    add_sdf_kinematics(scene_, model_, warnings);
    for (const std::string& warning : warnings) warn(warning);
    if (const std::string invisible = describe_invisible(model_); !invisible.empty())
      warn("visual " + invisible + ", as in Gazebo");
    if (transparent_visuals_ > 0) {
      const size_t others = transparent_visuals_ - 1;
      warn("visual " + quote(first_transparent_) +
           (others > 0 ? " and " + std::to_string(others) + " more" : "") + (others > 0 ? " have" : " has") +
           " a <transparency> of 1, which is not drawn, as in Gazebo");
    }
    if (!lights_by_metre_.empty())
      warn("lights whose <attenuation> is not <quadratic> alone are matched at 1 m: " + lights_by_metre_);
  }

 private:
  void warn(const std::string& text) { warnings_.add(text); }

  void name_items() {
    if (!scene_.node_names.empty()) {
      FIRE3DV_ASSERT(scene_.node_names.size() == scene_.items.size());
      names_ = scene_.node_names;
      return;
    }
    SdfNames names;
    std::vector<std::string> scopes;
    for (const SdfItem& item : scene_.items)
      scopes.push_back(scoped_sdf_name(item.parent ? scopes[*item.parent] : "", item.name, item.kind));
    names_.resize(scene_.items.size());
    for (const SdfEntity kind :
         {SdfEntity::model, SdfEntity::link, SdfEntity::visual, SdfEntity::light, SdfEntity::sensor})
      for (size_t i = 0; i < scene_.items.size(); ++i)
        if (scene_.items[i].kind == kind) names_[i] = names.take(scopes[i], kind);
    view_name_ = names.take("gui camera", SdfEntity::sensor);
  }

  void add_item(size_t index) {
    const SdfItem& item = scene_.items[index];
    Node node;
    node.name = names_[index];
    node.parent = item.parent;
    node.translation = item.translation;
    node.rotation = item.rotation;
    if (item.shape) node.mesh = mesh_of(item, node.name);
    model_.nodes.push_back(std::move(node));
  }

  std::optional<size_t> mesh_of(const SdfItem& item, const std::string& name) {
    if (std::isfinite(item.transparency) && item.transparency >= 1) {
      if (transparent_visuals_++ == 0) first_transparent_ = name;
      return std::nullopt;
    }
    Mesh mesh;
    mesh.name = name;
    if (!meshes_.take_shape(mesh)) {
      if (!std::exchange(reported_full_, true))
        warn("visual " + quote(name) + " and those after it are left out: " + meshes_.why_full());
      return std::nullopt;
    }
    if (Result<void> added = shapes_.add(item, mesh); !added) {
      warn("visual " + quote(name) + " is left out: " + added.error().message);
      return std::nullopt;
    }
    for (const std::string& note : shapes_.take_notes()) warn("visual " + quote(name) + ": " + note);
    return meshes_.add(std::move(mesh));
  }

  // Box of the meshes of nodes, in the frame of the scene.
  struct Bounds {
    glm::dvec3 low{INFINITY}, high{-INFINITY};
    bool empty() const { return !(low.x <= high.x); }
  };

  // A wide horizontal plane stands for the ground, which has no edge in the simulation.
  void extend_grounds() {
    std::vector<glm::dmat4> world_from_node;
    for (const Node& node : model_.nodes) {
      const glm::dmat4 pose = matrix_of(node.translation, node.rotation);
      world_from_node.push_back(node.parent ? world_from_node[*node.parent] * pose : pose);
    }
    std::vector<size_t> grounds;
    Bounds rest;
    for (size_t i = 0; i < scene_.items.size(); ++i) {
      if (!model_.nodes[i].mesh) continue;
      if (may_be_ground(scene_.items[i], world_from_node[i]))
        grounds.push_back(i);
      else
        add_bounds(model_.meshes[*model_.nodes[i].mesh], world_from_node[i], rest);
    }
    if (rest.empty()) return;
    const double extent = glm::length(rest.high - rest.low);
    for (const size_t ground : grounds) {
      const SdfShape& shape = *scene_.items[ground].shape;
      constexpr double kWide = 5;  // scene extents
      const double side = std::min(shape.size.x, shape.size.y);
      if (!(side >= kWide * extent)) continue;
      const glm::dvec2 half = glm::dvec2(shape.size) / 2.0;
      constexpr double kLargestShare = 0.01;  // of the plane in the file, of the extent
      Mesh mesh = model_.meshes[*model_.nodes[ground].mesh];
      const size_t material = mesh.surfaces[0].material;
      mesh.surfaces.clear();
      const Surface surface =
          horizon_plane(glm::dvec2(0), std::max({extent, 0.1, kLargestShare * side}), 1.0 / half);
      add_surface(mesh, surface, glm::mat4_cast(*plane_rotation(shape)), material);
      mesh.unbounded = true;
      model_.nodes[ground].mesh = meshes_.add(std::move(mesh));
    }
  }

  static bool may_be_ground(const SdfItem& item, const glm::dmat4& world_from_item) {
    constexpr double kSmallest_m = 20, kLevel = 0.999;
    if (!item.shape || item.shape->type != SdfShape::Type::plane) return false;
    if (!(std::min(item.shape->size.x, item.shape->size.y) >= kSmallest_m)) return false;
    const std::optional<glm::dquat> rotation = plane_rotation(*item.shape);
    return rotation && (world_from_item * glm::dvec4(*rotation * glm::dvec3(0, 0, 1), 0)).z > kLevel;
  }

  static void add_bounds(const Mesh& mesh, const glm::dmat4& world_from_mesh, Bounds& bounds) {
    for (const Surface& surface : mesh.surfaces) {
      for (const glm::vec3& position : surface.positions) {
        const glm::dvec3 at(world_from_mesh * glm::dvec4(position, 1));
        bounds.low = glm::min(bounds.low, at);
        bounds.high = glm::max(bounds.high, at);
      }
    }
  }

  void add_light(size_t index) {
    const SdfLight& from = *scene_.items[index].light;
    Light light;
    light.name = names_[index];
    light.type = from.type;
    const float peak = std::max({from.diffuse.r, from.diffuse.g, from.diffuse.b});
    // The power of a light of OGRE is its intensity * pi.
    double intensity = from.intensity * std::numbers::pi * static_cast<double>(peak);
    if (from.type != Light::Type::directional) {
      const double at_one_metre = from.constant + from.linear + from.quadratic;
      const bool is_physical = from.constant == 0 && from.linear == 0;
      intensity /= at_one_metre;
      if (!is_physical) lights_by_metre_ += (lights_by_metre_.empty() ? "" : ", ") + quote(names_[index]);
    }
    if (from.is_off) {
      light.intensity = 0;
    } else if (peak > 0 && std::isfinite(intensity) && intensity > 0) {
      light.color = glm::max(from.diffuse / peak, 0.0f);
      light.intensity = static_cast<float>(std::min(intensity, 1e9));
    } else {
      warn("light " + quote(names_[index]) +
           " is dark: its colour, <intensity> or <attenuation> has no finite, "
           "positive value");
      light.intensity = 0;
    }
    if (from.type == Light::Type::spot) {
      const auto half = [](double angle_rad) { return std::isfinite(angle_rad) ? angle_rad / 2 : 0; };
      light.outer_cone_rad =
          static_cast<float>(std::clamp(half(from.outer_angle_rad), 1e-3, std::numbers::pi / 2));
      light.inner_cone_rad =
          std::clamp(static_cast<float>(half(from.inner_angle_rad)), 0.0f, light.outer_cone_rad);
    }
    Node node;
    node.name = sdf_light_name(names_[index]);
    node.parent = index;
    const double length = glm::length(from.direction);
    if (from.type != Light::Type::point && length > 1e-9 && std::isfinite(length))
      node.rotation = shining(from.direction);
    node.light = model_.lights.size();
    model_.lights.push_back(std::move(light));
    model_.nodes.push_back(std::move(node));
  }

  void add_camera(const SdfCamera& from, const std::string& name, std::optional<size_t> parent) {
    constexpr double kMaxSide = 1e6;  // pixels
    if (!(from.width <= kMaxSide && from.height <= kMaxSide && std::isfinite(from.horizontal_fov_rad)))
      return warn("camera " + quote(name) +
                  " is left out: its <image> is larger than a million pixels, or a "
                  "number is not finite");
    const double width = std::max(from.width, 1.0), height = std::max(from.height, 1.0);
    double aspect = width / height;
    double half_height = std::tan(std::clamp(from.horizontal_fov_rad, 1e-3, 3.1) / 2) / aspect;
    if (from.focal_px && from.focal_px->x > 0 && from.focal_px->y > 0) {
      half_height = height / 2 / from.focal_px->y;
      aspect *= from.focal_px->y / from.focal_px->x;
    }
    Camera camera;
    camera.name = name;
    if (from.focal_px && from.focal_px->x > 0 && from.focal_px->y > 0 && from.focal_px->x != from.focal_px->y)
      camera.pixel_aspect = static_cast<float>(from.focal_px->y / from.focal_px->x);
    camera.principal_point = glm::vec2(from.principal_px / height);
    camera.vertical_fov_rad = static_cast<float>(2 * std::atan(half_height));
    if (std::isfinite(aspect)) camera.aspect = static_cast<float>(aspect);
    if (from.near_m > 0 && from.near_m < 1e6) camera.near_m = static_cast<float>(from.near_m);
    if (from.far_m > from.near_m && from.far_m < 1e9) camera.far_m = static_cast<float>(from.far_m);
    Node node;
    node.name = parent ? sdf_view_name(name) : name;
    node.parent = parent;
    node.translation = from.translation;
    node.rotation = glm::normalize(from.rotation) * sensor_from_camera();
    node.camera = model_.cameras.size();
    model_.cameras.push_back(std::move(camera));
    model_.nodes.push_back(std::move(node));
  }

  const SdfScene& scene_;
  Model& model_;
  SdfWarnings warnings_;
  MeshStore meshes_;
  SdfMaterials materials_;
  SdfShapes shapes_;
  std::vector<std::string> names_;  // by item
  std::string view_name_, lights_by_metre_, first_transparent_;
  size_t transparent_visuals_ = 0;
  bool reported_full_ = false;
};

}  // namespace

void add_sdf(const SdfScene& scene, const std::filesystem::path& file, const ReadOptions& options,
             SdfFiles& files, Model& model) {
  SceneBuilder(scene, file, options, files, model).build();
}

}  // namespace fire3dv::convert
