// Entities of a Gazebo world, read from its Scene message: models, links, visuals, lights and sensors, each
// with a unique node name and its pose in its parent. The message is untrusted: counts are limited, ids may
// repeat.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "convert/sdf/names.h"
#include "gazebo.pb.h"

namespace fire3dv::gazebo {

constexpr size_t kNoParent = SIZE_MAX;

struct RigidPose {
  glm::dvec3 translation{0};
  glm::dquat rotation{1, 0, 0, 0};
};

// A missing position is the origin, a missing orientation the identity. Nullopt: not finite, or no rotation.
std::optional<RigidPose> rigid_pose(const pb::Pose& pose);
RigidPose operator*(const RigidPose& a, const RigidPose& b);

struct Entity {
  uint32_t id = 0;
  convert::SdfEntity kind = convert::SdfEntity::model;
  std::string name;  // scoped name; unique
  std::string node;  // of the renderer's scene: the name, or a path below an added node; empty: too long
  size_t parent = kNoParent;  // index into the list; precedes its children
  RigidPose pose;             // in the parent
  bool is_posed = false;      // by a pose topic; else by the scene
  // What it shows; owned by the message.
  const pb::Visual* visual = nullptr;
  const pb::Light* light = nullptr;
  const pb::Sensor* sensor = nullptr;  // cameras only
};

// Model or light of the world with everything below it.
struct TopLevel {
  std::shared_ptr<const pb::Scene> message;  // owner of what the entities show
  std::string digest;                        // of everything but ids and poses of models and links
  std::vector<Entity> entities;              // the first is the model or light itself
  bool is_in_file = false;                   // nodes of the renderer's scene file; else of an added asset
  bool is_streamed = false;                  // the renderer has its nodes: its poses are published
  std::string added_node;                    // root of the added asset; empty: none

  uint32_t id() const { return entities.front().id; }
};

// Reads all models and lights. Entities have no names yet. Leaves out what exceeds the limits, with a
// warning.
std::vector<TopLevel> read_entities(const pb::Scene& scene, std::vector<std::string>& warnings);

// Gives names to the entities of new models and lights, all models first, then all links, and so on.
void name_entities(const std::vector<TopLevel*>& items, convert::SdfNames& names);

// Root of the .glb file of an added asset.
inline constexpr const char* kAssetRoot = "gazebo";
// The last part of a scoped name, which names a node in an added asset.
std::string own_name(const Entity& entity);
// Makes the item a part of an asset below this node. Nodes of assets are found by their paths alone.
void place_below(TopLevel& item, const std::string& added_node);

bool is_camera(const pb::Sensor& sensor);

}  // namespace fire3dv::gazebo
