// Edits of the displayed scene by the user, by node and material number. They stand over those of streams.
#pragma once

#include <cstdint>
#include <map>
#include <set>

#include "renderer/scene/model/scene_edits.h"
#include "renderer/state/edits/addition.h"
#include "renderer/state/edits/node_transform.h"
#include "renderer/state/marker_registry.h"
#include "renderer/state/robot_pose.h"

namespace fire3dv::state {

struct UserEdits {
  std::set<uint32_t> hidden;                // with their descendants
  uint32_t isolated = scene::kNone;         // only this node and its descendants are drawn
  std::map<uint32_t, scene::Light> lights;  // replace those of the file and of streams
  scene::MaterialEdits materials;
  scene::MaterialTextureEdits textures;
  MarkerNamespaces hidden_markers;
  NodeTransforms transforms;   // replace those of the file, of animations and joints, not those of streams
  JointPositions joints;       // of the robot, other than the file's
  std::set<uint32_t> removed;  // with their descendants: not drawn, and without lights
  uint32_t variant = scene::kNone;  // of the file's materials; kNone: its default materials
  Additions additions;
  bool operator==(const UserEdits&) const = default;
};

}  // namespace fire3dv::state
