// Nodes, meshes, cameras and lights of a posed MJCF model.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "convert/mesh/mesh_store.h"
#include "convert/mjcf/scene/mjcf_appearance.h"
#include "convert/mjcf/scene/mjcf_names.h"
#include "convert/mjcf/scene/mjcf_scene.h"
#include "convert/mjcf/scene/tendon_frames.h"
#include "convert/mjcf/scene/view_frame.h"
#include "convert/model.h"
#include "convert/surfaces.h"

namespace fire3dv::convert {
namespace {

class SceneBuilder {
 public:
  SceneBuilder(const MjcfScene& scene, const ReadOptions& options, Model& model)
      : scene_(scene),
        options_(options),
        model_(model),
        appearance_(scene, model),
        names_(scene),
        meshes_(model, options.max_triangles),
        frame_(kThreeQuarterFront, glm::radians(scene.vertical_fov_deg)) {}

  void build() {
    if (!scene_.is_view_given) add_overview();
    add_free_camera();
    first_body_ = model_.nodes.size();
    has_bounded_geoms_.assign(scene_.bodies.size(), false);
    for (const MjcfGeom& geom : scene_.geoms)
      if (appearance_.is_shown(geom) && !is_infinite_plane(geom)) has_bounded_geoms_[geom.body] = true;
    size_t geom = 0;
    for (size_t body = 0; body < scene_.bodies.size(); ++body) {
      const size_t first = geom;
      while (geom < scene_.geoms.size() && scene_.geoms[geom].body == body) ++geom;
      add_body(body, first, geom);
    }
    model_.kinematics = scene_.kinematics;
    for (Body& body : model_.kinematics.bodies) body.node += first_body_;
    for (size_t camera = 0; camera < scene_.cameras.size(); ++camera) add_camera(camera);
    for (size_t light = 0; light < scene_.lights.size(); ++light) add_light(light);
    for (size_t i = 0; i < scene_.geoms.size(); ++i) add_geom(i);
    for (size_t tendon = 0; tendon < scene_.tendons.size(); ++tendon) add_tendon(tendon);
    for (size_t skin = 0; skin < scene_.skins.size(); ++skin) add_skin(skin);
    if (!scene_.is_view_given) frame_overview();
    if (scene_.sky) {
      model_.sky_image = model_.images.size();
      model_.images.push_back(*scene_.sky);
    }
    if (model_.meshes.empty()) model_.warnings.push_back("no geoms of the groups 0 to 2: nothing is visible");
  }

 private:
  // Adds the initial view of MuJoCo's viewer.
  void add_free_camera() {
    const double azimuth = glm::radians(scene_.azimuth_deg), elevation = glm::radians(scene_.elevation_deg);
    const glm::dvec3 forward(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                             std::sin(elevation));
    const glm::dvec3 right(std::sin(azimuth), -std::cos(azimuth), 0);
    Camera camera;
    camera.name = "free camera";
    camera.vertical_fov_rad = static_cast<float>(glm::radians(scene_.vertical_fov_deg));
    camera.near_m = near_m();
    Node node;
    node.name = names_.free_camera;
    node.translation = scene_.centre - 1.5 * scene_.extent * forward;
    node.rotation = glm::quat_cast(glm::dmat3(right, glm::cross(right, forward), -forward));
    node.camera = model_.cameras.size();
    model_.cameras.push_back(camera);
    model_.nodes.push_back(node);
  }

  // Adds the first camera of a model without a view of its own; frame_overview() places it.
  void add_overview() {
    Camera camera;
    camera.name = "overview";
    camera.vertical_fov_rad = static_cast<float>(glm::radians(scene_.vertical_fov_deg));
    Node node;
    node.name = names_.overview;
    node.camera = model_.cameras.size();
    overview_ = model_.nodes.size();
    model_.cameras.push_back(std::move(camera));
    model_.nodes.push_back(std::move(node));
  }

  // Places the overview so that all but planes fills its image.
  void frame_overview() {
    const std::optional<glm::dmat4> pose = frame_.pose();
    if (!pose) return;
    Node& node = model_.nodes[overview_];
    node.translation = glm::dvec3((*pose)[3]);
    node.rotation = glm::quat_cast(glm::dmat3(*pose));
    model_.cameras[*node.camera].near_m = static_cast<float>(std::max(frame_.near_m(), 1e-5));
  }

  // Extends what is framed. Planes are ground.
  void add_to_frame(const MjcfGeom& geom, const Surface& surface) {
    if (geom.shape == MjcfShape::plane) return;
    const MjcfPose pose = scene_.bodies[geom.body].world_pose * geom.pose;
    for (const glm::vec3& position : surface.positions) frame_.add(pose * glm::dvec3(position));
  }

  float near_m() const { return static_cast<float>(scene_.near_per_extent * scene_.extent); }

  void add_body(size_t index, size_t first_geom, size_t end_geom) {
    const MjcfBody& body = scene_.bodies[index];
    Node node;
    if (body.parent) {
      node = node_in_body(*body.parent, body.world_pose.position, body.world_pose.rotation);
    } else {
      node.translation = body.world_pose.position;
      node.rotation = body.world_pose.rotation;
    }
    node.name = names_.bodies[index];
    if (!options_.geoms_apart) node.mesh = mesh_of(first_geom, end_geom, node.name);
    model_.nodes.push_back(std::move(node));
  }

  // Infinite planes, which are not framed, are apart from the other geoms of their body.
  bool has_own_node(const MjcfGeom& geom) const {
    return options_.geoms_apart || (is_infinite_plane(geom) && has_bounded_geoms_[geom.body]);
  }

  // Adds a geom with a node of its own as a child node of its body.
  void add_geom(size_t index) {
    const MjcfGeom& geom = scene_.geoms[index];
    if (!appearance_.is_shown(geom) || !has_own_node(geom)) return;
    Node node;
    node.parent = first_body_ + geom.body;
    node.name = names_.geoms[index];
    node.translation = geom.pose.position;
    node.rotation = geom.pose.rotation;
    node.mesh = mesh_of(index, index + 1, node.name, true);
    model_.nodes.push_back(std::move(node));
  }

  // Builds the mesh in the frame of the body, or of a geom with its own node.
  std::optional<size_t> mesh_of(size_t first_geom, size_t end_geom, const std::string& name,
                                bool is_of_geom = false) {
    Mesh mesh;
    mesh.name = name;
    for (size_t i = first_geom; i < end_geom; ++i) {
      const MjcfGeom& geom = scene_.geoms[i];
      if (!appearance_.is_shown(geom) || has_own_node(geom) != is_of_geom) continue;
      mesh.unbounded |= is_infinite_plane(geom);
      if (!has_room(mesh)) break;
      const Surface surface = appearance_.surface(geom);
      if (surface.indices.empty()) continue;
      if (!scene_.is_view_given) add_to_frame(geom, surface);
      const glm::dmat4 mesh_from_geom =
          is_of_geom ? glm::dmat4(1) : matrix_of(geom.pose.position, geom.pose.rotation);
      add_surface(mesh, surface, mesh_from_geom, appearance_.material(geom));
    }
    return meshes_.add(std::move(mesh));
  }

  // Returns a node in the frame of its body, with which it moves.
  Node node_in_body(size_t body, const glm::dvec3& position, const glm::dquat& rotation) const {
    const MjcfPose& pose = scene_.bodies[body].world_pose;
    const glm::dquat to_body = glm::conjugate(pose.rotation);
    Node node;
    node.parent = first_body_ + body;
    node.translation = to_body * (position - pose.position);
    node.rotation = to_body * rotation;
    return node;
  }

  void add_camera(size_t index) {
    const MjcfCamera& from = scene_.cameras[index];
    Camera camera;
    camera.name = from.name.empty() ? "camera_" + std::to_string(index) : from.name;
    camera.vertical_fov_rad = static_cast<float>(glm::radians(from.vertical_fov_deg));
    camera.near_m = near_m();
    camera.pixel_aspect = static_cast<float>(from.pixel_aspect);
    camera.principal_point = glm::vec2(from.principal_point);
    if (from.height_m) {
      camera.height_m = static_cast<float>(*from.height_m);
      camera.far_m = static_cast<float>(scene_.far_per_extent * scene_.extent);
    }
    Node node = node_in_body(from.body, from.world_pose.position, from.world_pose.rotation);
    node.name = names_.cameras[index];
    node.camera = model_.cameras.size();
    model_.cameras.push_back(camera);
    model_.nodes.push_back(std::move(node));
  }

  void add_light(size_t index) {
    const MjcfLight& from = scene_.lights[index];
    if (!is_scene_light(from)) return;
    Light light;
    light.name = from.name.empty() ? "light_" + std::to_string(index) : from.name;
    light.type = from.type;
    const glm::vec3 color = linear_from_srgb(from.diffuse);
    const float brightest = std::max({color.r, color.g, color.b});
    light.color = color / brightest;
    // MuJoCo's lights have no unit: a white surface that faces one appears white. That is pi lux at the
    // surface; for positional lights, at the scene centre.
    light.intensity = brightest * std::numbers::pi_v<float>;
    if (from.type != Light::Type::directional) {
      const glm::dvec3 way = scene_.centre - from.position;
      light.intensity *= static_cast<float>(std::max(glm::dot(way, way), 1e-4));
      light.outer_cone_rad = static_cast<float>(glm::radians(from.cutoff_deg));
      light.inner_cone_rad = 0.8f * light.outer_cone_rad;  // approximates the soft edge of MuJoCo's exponent
    }
    Node node = node_in_body(from.body, from.position, shining(from.direction));
    node.name = names_.lights[index];
    node.light = model_.lights.size();
    model_.lights.push_back(light);
    model_.nodes.push_back(std::move(node));
  }

  // Adds unit cylinders and balls, which the pose scales.
  void add_tendon(size_t index) {
    const MjcfTendon& tendon = scene_.tendons[index];
    std::vector<TendonFrame> frames;
    tendon_frames(tendon.pieces, tendon.max_points, frames);
    if (frames.empty()) return;
    const auto& pieces = names_.tendon_pieces[index];
    const auto& ends = names_.tendon_ends[index];
    const size_t material = appearance_.material(tendon);
    const auto piece_mesh = add_mesh(pieces.front(), cylinder(1, 1), material);
    const auto end_mesh = add_mesh(ends.front(), ellipsoid(glm::dvec3(1)), material);
    for (size_t i = 0; i < frames.size(); ++i) {
      const bool is_piece = i < pieces.size();
      Node node;
      node.name = is_piece ? pieces[i] : ends[i - pieces.size()];
      node.translation = frames[i].position;
      node.rotation = glm::quat_cast(frames[i].turn);
      node.scale = frames[i].scale;
      node.mesh = is_piece ? piece_mesh : end_mesh;
      model_.nodes.push_back(std::move(node));
    }
  }

  void add_skin(size_t index) {
    const MjcfSkin& from = scene_.skins[index];
    if (!appearance_.is_shown(from)) return;
    Mesh mesh;
    mesh.name = names_.skins[index];
    if (!has_room(mesh)) return;
    mesh.surfaces.push_back(from.surface);
    mesh.surfaces[0].material = appearance_.material(from);
    Skin skin;
    skin.name = mesh.name;
    for (const MjcfSkin::Bone& bone : from.bones)
      skin.joints.push_back(
          {first_body_ + bone.body, glm::inverse(matrix_of(bone.bind.position, bone.bind.rotation))});
    Node node;
    node.name = mesh.name;
    node.mesh = meshes_.add(std::move(mesh));
    node.skin = model_.skins.size();
    model_.skins.push_back(std::move(skin));
    model_.nodes.push_back(std::move(node));
  }

  std::optional<size_t> add_mesh(const std::string& name, const Surface& surface, size_t material) {
    Mesh mesh;
    mesh.name = name;
    if (has_room(mesh)) add_surface(mesh, surface, glm::dmat4(1), material);
    return meshes_.add(std::move(mesh));
  }

  bool has_room(const Mesh& mesh) {
    if (meshes_.take_shape(mesh)) return true;
    if (!std::exchange(reported_full_, true))
      model_.warnings.push_back("\"" + mesh.name + "\" and those after it lack geoms: " + meshes_.why_full());
    return false;
  }

  const MjcfScene& scene_;
  const ReadOptions& options_;
  Model& model_;
  MjcfAppearance appearance_;
  const MjcfNames names_;
  MeshStore meshes_;
  size_t first_body_ = 0, overview_ = 0;
  std::vector<bool> has_bounded_geoms_;  // by body: shown ones that are no infinite planes
  ViewFrame frame_;                      // of the overview
  bool reported_full_ = false;
};

}  // namespace

void add_mjcf(const MjcfScene& scene, const ReadOptions& options, Model& model) {
  SceneBuilder(scene, options, model).build();
}

}  // namespace fire3dv::convert
