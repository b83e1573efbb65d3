// Posed MJCF model as plain data: what is drawn, in MuJoCo's order and frames (Z up, metres). Made by the
// MJCF reader, or from a compiled model by a publisher; add_mjcf makes nodes, meshes and materials of it.
#pragma once

#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "convert/joints.h"
#include "convert/model.h"
#include "convert/readers.h"

namespace fire3dv::convert {

struct MjcfPose {
  glm::dvec3 position{0};
  glm::dquat rotation{1, 0, 0, 0};

  glm::dvec3 operator*(const glm::dvec3& point) const { return position + rotation * point; }
  MjcfPose operator*(const MjcfPose& child) const {
    return {position + rotation * child.position, glm::normalize(rotation * child.rotation)};
  }
};

enum class MjcfShape { plane, height_field, sphere, capsule, ellipsoid, cylinder, box, mesh };

struct MjcfTexture {
  std::string name;
  bool is_cube = false;
  std::optional<Image> image;  // of 2D textures
  glm::vec3 mean_color{1};     // linear; of cube textures
  bool has_opacity = false;
};

struct MjcfMaterial {
  std::string name;
  std::array<float, 4> rgba{1, 1, 1, 1};  // displayed (sRGB)
  float emission = 0, specular = 0.5f, shininess = 0.5f, reflectance = 0;
  std::optional<float> metallic, roughness;  // empty: from reflectance, specular and shininess
  std::optional<size_t> texture, normal_texture;
  glm::dvec2 texture_repeats{1};
  bool texture_is_uniform = false;  // repeats per unit of length
};

struct MjcfHeightField {
  glm::dvec2 half{1};  // metres
  double height = 1, base = 0.1;
  size_t rows = 0, columns = 0;
  std::vector<float> data;  // 0 to 1, rows from -Y to +Y
};

struct MjcfGeom {
  std::string name;
  size_t body = 0;
  MjcfShape shape = MjcfShape::sphere;
  glm::dvec3 size{0};  // as in MuJoCo: radii and half lengths
  MjcfPose pose;       // in the body
  int group = 0;
  std::array<float, 4> rgba{0.5f, 0.5f, 0.5f, 1};  // displayed (sRGB)
  std::optional<size_t> material, data;            // data: index of the mesh or height field
};

struct MjcfBody {
  std::string name;
  std::optional<size_t> parent;  // precedes its children; empty: the world
  MjcfPose world_pose;
};

struct MjcfCamera {
  std::string name;
  size_t body = 0;
  MjcfPose world_pose;  // looks along -Z
  double vertical_fov_deg = 45;
  double pixel_aspect = 1;  // as of convert::Camera
  glm::dvec2 principal_point{0};
  std::optional<double> height_m;  // orthographic
};

struct MjcfLight {
  std::string name;
  size_t body = 0;
  glm::dvec3 position{0}, direction{0, 0, -1};  // in the world
  Light::Type type = Light::Type::spot;
  glm::vec3 diffuse{0.7f};  // displayed (sRGB)
  double cutoff_deg = 45;   // half angle of a spot
  bool is_active = true;
};

// Straight segment of a tendon, in the world frame.
struct TendonPiece {
  glm::dvec3 from, to;
  double radius_m;
};

struct MjcfTendon {
  std::string name;
  size_t max_points = 0;  // over all poses; 0: not drawn
  std::vector<TendonPiece> pieces;
  std::array<float, 4> rgba{0.5f, 0.5f, 0.5f, 1};
  std::optional<size_t> material;
};

// Mesh that follows bodies. vertices, normals: in the bind pose.
struct MjcfSkin {
  struct Bone {
    size_t body = 0;
    MjcfPose bind;  // of the body in the frame of the vertices
  };
  std::string name;
  int group = 0;
  std::array<float, 4> rgba{0.5f, 0.5f, 0.5f, 1};
  std::optional<size_t> material;
  Surface surface;  // influences: of the bones
  std::vector<Bone> bones;
};

struct MjcfScene {
  std::vector<MjcfBody> bodies;  // the world first
  std::vector<MjcfGeom> geoms;   // by body
  std::vector<MjcfCamera> cameras;
  std::vector<MjcfLight> lights;
  std::vector<MjcfTendon> tendons;
  std::vector<MjcfSkin> skins;
  std::vector<MjcfMaterial> materials;
  std::vector<MjcfTexture> textures;
  std::optional<Image> sky;                            // of the skybox: equirectangular, in the frame of glTF
  std::vector<std::shared_ptr<const Surface>> meshes;  // in the frame of their geoms; null: left out
  std::vector<std::shared_ptr<const MjcfHeightField>> height_fields;
  Kinematics kinematics;  // Body::node: index into bodies; the world is no body of it

  glm::dvec3 centre{0};  // of the model in its default pose
  double extent = 1;
  // Initial view of MuJoCo's viewer.
  double azimuth_deg = 90, elevation_deg = -45, vertical_fov_deg = 45;
  double near_per_extent = 0.01, far_per_extent = 50;
  // The file sets <global> or <statistic>. Otherwise a camera before the free one frames what is drawn, from
  // three-quarter front.
  bool is_view_given = true;
};

// Groups 0 to 2, as in MuJoCo's viewer at start. By convention, collision geoms are in groups 3 and higher.
bool is_shown_group(int group);

// MuJoCo's precedence for geoms and tendons, in displayed (sRGB) colours: their own colour counts where it
// differs from the default.
const std::array<float, 4>& mjcf_color(const std::array<float, 4>& own, const std::array<float, 4>* material);

// True for planes with a size of 0, which reach the horizon.
bool is_infinite_plane(const MjcfGeom& geom);

// Excludes lights that are off, black or without direction.
bool is_scene_light(const MjcfLight& light);

// Adds nodes for bodies, cameras, lights, tendons and skins, named as in MjcfNames.
void add_mjcf(const MjcfScene& scene, const ReadOptions& options, Model& model);

}  // namespace fire3dv::convert
