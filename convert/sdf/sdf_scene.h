// Contents of an SDF file, or of a running world of Gazebo, as plain data: entities with their poses, shapes
// and materials, and joints. Files are read by libsdformat (library/sdf_reader.h), worlds from their messages
// (adapters/gazebo); the rules of what they look like (add_sdf.h) are the same.
#pragma once

#include <cstddef>
#include <filesystem>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "convert/joints.h"
#include "convert/model.h"
#include "convert/sdf/names.h"

namespace fire3dv::convert {

// Name of a file, with the file that names it.
struct SdfUri {
  std::string uri;             // empty: none
  std::filesystem::path from;  // empty: a running world
};

// Pose of the glTF camera, which looks along -Z with +Y up, in the frame of a sensor, which looks along +X
// with +Z up: three rows of four.
inline constexpr float kSensorFromCamera[12] = {0, 0, -1, 0, -1, 0, 0, 0, 0, 1, 0, 0};

struct SdfShape {
  enum class Type { box, sphere, cylinder, cone, capsule, ellipsoid, plane, polyline, mesh };
  struct Polyline {
    double height = 1;
    std::vector<glm::dvec2> points;
  };
  Type type = Type::box;
  // Box: edge lengths; ellipsoid: radii; sphere, cylinder, cone, capsule: radius and length in x and y;
  // plane: edge lengths in x and y; mesh: scale.
  glm::dvec3 size{1};
  glm::dvec3 normal{0, 0, 1};  // of a plane
  SdfUri mesh;
  std::string submesh;  // empty: the whole mesh
  bool is_centred = false;
  std::vector<Polyline> polylines;
};

struct SdfMaterial {
  // Colours are linear, as Gazebo takes them.
  glm::vec4 diffuse{0, 0, 0, 1};
  glm::vec3 specular{0}, emissive{0};
  std::string script;  // name of a material of Gazebo Classic; empty: none
  bool is_pbr = false, is_double_sided = false;
  float metalness = 0.5f, roughness = 0.5f;
  SdfUri albedo_map, normal_map, metalness_map, roughness_map, occlusion_map, emissive_map;
};

struct SdfLight {
  Light::Type type = Light::Type::point;
  glm::vec3 diffuse{1};  // linear
  double intensity = 1;
  bool is_off = false;                              // dark, without a warning
  double constant = 1, linear = 1, quadratic = 0;   // attenuation
  glm::dvec3 direction{0, 0, -1};                   // in the frame of the light
  double inner_angle_rad = 0, outer_angle_rad = 0;  // full angles
};

struct SdfCamera {
  glm::dvec3 translation{0};  // in the frame of the sensor; +X forward, +Z up
  glm::dquat rotation{1, 0, 0, 0};
  double horizontal_fov_rad = 1.047;
  double width = 320, height = 240;
  double near_m = 0.1, far_m = 100;
  std::optional<glm::dvec2> focal_px;  // replaces the field of view
  glm::dvec2 principal_px{0};          // from the image's centre, right and down
};

struct SdfItem {
  SdfEntity kind = SdfEntity::model;
  std::string name;
  std::optional<size_t> parent;  // precedes its children; empty: the world
  glm::dvec3 translation{0};     // in the parent
  glm::dquat rotation{1, 0, 0, 0};
  // Of visuals.
  std::optional<SdfShape> shape;
  std::optional<SdfMaterial> material;
  double transparency = 0;
  std::optional<SdfLight> light;
  std::optional<SdfCamera> camera;
};

struct SdfJoint {
  struct Axis {
    glm::dvec3 direction{0, 0, 1};  // in the frame of the child
    std::optional<std::pair<double, double>> limits;
    // follower = multiplier * leader + offset
    struct Mimic {
      std::string joint;
      double multiplier = 1, offset = 0;
    };
    std::optional<Mimic> mimic;
  };
  std::string name;
  size_t model = 0;              // index into SdfScene::items
  std::optional<size_t> parent;  // link; empty: the world
  size_t child = 0;              // link
  Joint::Type type = Joint::Type::fixed;
  glm::dvec3 anchor{0};    // in the frame of the child
  std::vector<Axis> axes;  // one; two of universal joints, which turn one after the other
};

struct SdfScene {
  std::string name;  // of the world; empty for a model alone
  // Where Gazebo's window starts, in the world; empty: a view of the whole scene does.
  std::optional<SdfCamera> view;
  std::vector<SdfItem> items;
  // Names of the nodes, by item, if the caller has given them; else empty: scoped names, made unique.
  std::vector<std::string> node_names;
  std::vector<SdfJoint> joints;
};

}  // namespace fire3dv::convert
