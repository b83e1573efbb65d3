// Reader of the body tree: bodies, joints, geoms, sites, cameras and lights, with frames, replicas and
// attached models in place.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>

#include "convert/mjcf/assets/mjcf_source.h"
#include "convert/mjcf/bodies/mjcf_tree.h"
#include "convert/mjcf/scene/mjcf_scene.h"

namespace fire3dv::convert {

// Keeps the attached models, to which the tree's copies refer.
class MjcfBodyReader {
 public:
  // assets: receives the meshes, materials, textures and height fields that are used.
  MjcfBodyReader(MjcfScene& assets, MjcfTree& tree) : assets_(assets), tree_(tree) {}

  // Reads all worldbody elements. The error says which limit the model exceeds.
  Result<void> read(MjcfSource& source);

 private:
  // Where an element is read: its model file, body, frame, class, and the affixes of names.
  struct Scope {
    MjcfSource* source;
    size_t body;
    MjcfPose frame;  // in the body
    size_t class_index;
    std::string prefix, suffix;
    int attachments = 0;  // nested

    std::string name(const std::string& own) const { return own.empty() ? own : prefix + own + suffix; }
  };

  Result<void> read_children(const MjcfElement& section, const Scope& scope);
  Result<void> read_child(const MjcfElement& element, const Scope& scope);
  Result<void> read_body(const MjcfElement& element, const Scope& scope);
  Result<void> read_frame(const MjcfElement& element, const Scope& scope);
  Result<void> read_replicate(const MjcfElement& element, const Scope& scope);
  Result<void> read_attach(const MjcfElement& element, const Scope& scope);
  Result<void> read_flexcomp(const MjcfElement& element, const Scope& scope);
  Result<size_t> add_flex_body(const std::string& name, const glm::dvec3& position,
                               const std::vector<glm::dvec3>& axes, double mass, const Scope& scope);
  Result<void> read_composite(const MjcfElement& element, const Scope& scope);
  void read_inertial(const MjcfElement& element, const Scope& scope);
  void read_joint(const MjcfElement& element, const Scope& scope);
  void read_geom(const MjcfElement& element, const Scope& scope);
  void read_site(const MjcfElement& element, const Scope& scope);
  void read_camera(const MjcfElement& element, const Scope& scope);
  void read_light(const MjcfElement& element, const Scope& scope);
  bool shape_mesh(const MjcfAttributes& from, const Scope& scope, MjcfTreeGeom& made, MjcfPose& mass_pose,
                  double& volume);
  Result<MjcfSource*> attached_source(const MjcfElement& attach, const Scope& scope);
  Result<MjcfSource*> open_asset(const MjcfElement& asset, const Scope& scope);
  void add_copy(const Scope& scope);
  Result<void> count_objects();

  MjcfScene& assets_;
  MjcfTree& tree_;
  std::map<const MjcfElement*, std::unique_ptr<MjcfSource>> attached_;
  size_t objects_ = 0;
};

}  // namespace fire3dv::convert
