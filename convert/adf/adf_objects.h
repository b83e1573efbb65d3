// Objects of an AMBF scene in creation order, with the properties that depend on all of them: unique names,
// parents, light intensities. write() converts them to nodes of a Model.
#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "convert/adf/adf_joints.h"
#include "convert/adf/adf_yaml.h"
#include "convert/model.h"

namespace fire3dv::convert {

struct AdfObject {
  enum class Kind { body, soft_body, ghost, camera, light };
  Kind kind = Kind::body;
  std::string identifier;  // namespace and block id
  std::string parent;      // as the block names it; empty: none
  std::string location;    // file and line, for warnings
  std::string id;          // of the block
  size_t file = 0;         // number of its model file
  double scale = 1;        // of a body; pivots of joints are multiplied with it
  glm::dvec3 translation{0};
  glm::dquat rotation{1, 0, 0, 0};
  std::optional<size_t> mesh;
  bool dropped_by_ambf = false;  // AMBF drops objects without mesh; their names do not count there

  Camera camera;
  std::optional<double> eye_separation_m;
  Light light;
  glm::dvec3 attenuation{1, 0, 0};  // coefficients: constant, linear, quadratic
};

class AdfObjects {
 public:
  explicit AdfObjects(AdfReport& report) : report_(report) {}

  // Returns false when the object limit is reached.
  bool add(AdfObject object);
  void add(AdfJoint joint) { joints_.push_back(std::move(joint)); }
  bool empty() const { return objects_.empty(); }
  // Writes nodes, cameras, lights and joints to the model, parents before their children.
  void write(Model& model);

 private:
  void find_names();
  void find_parents();
  std::optional<size_t> parent_of(size_t child) const;
  void drop_loops();
  glm::dmat4 world_from(size_t object) const;
  glm::dvec3 center(const Model& model) const;
  void write_node(Model& model, size_t object);
  void write_joints(Model& model);

  AdfReport& report_;
  std::vector<AdfObject> objects_;
  std::vector<AdfJoint> joints_;
  std::vector<std::string> names_;
  std::vector<std::optional<size_t>> parents_;
  std::vector<std::optional<size_t>> nodes_;
  glm::dvec3 center_{0};
};

// Rotation of AMBF's camera frame at `position` that looks at a point, and of a light along `direction`.
// Empty where AMBF has none. Right-handed.
std::optional<glm::dquat> adf_camera_rotation(const glm::dvec3& position, const glm::dvec3& look_at,
                                              const glm::dvec3& up);
std::optional<glm::dquat> adf_light_rotation(const glm::dvec3& direction);

}  // namespace fire3dv::convert
