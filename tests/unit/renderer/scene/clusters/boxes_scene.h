// Small test scene of boxes at given positions.
#pragma once

#include <vector>

#include "renderer/scene/model/scene.h"

namespace fire3dv::app {

// A 2 m box at each position, named "box0", "box1", ... below "top"; a camera 10 m in front of all.
inline scene::Scene boxes_at(const std::vector<glm::vec3>& places) {
  scene::Scene scene;
  scene.materials.emplace_back();
  scene::Primitive cube;
  cube.index_count = 36;
  cube.bounds_min = glm::vec3(-1);
  cube.bounds_max = glm::vec3(1);
  scene.primitives.push_back(cube);
  scene.meshes.push_back({"cube", 0, 1, 0});
  scene.cameras.emplace_back();
  scene::Node top;
  top.name = top.path = "top";
  scene.nodes.push_back(top);
  for (size_t i = 0; i < places.size(); ++i) {
    scene::Node box;
    box.name = "box" + std::to_string(i);
    box.path = "top/" + box.name;
    box.parent = 0;
    box.translation = places[i];
    box.mesh = 0;
    scene.nodes.push_back(box);
  }
  scene::Node eye;
  eye.name = eye.path = "eye";
  eye.translation = {0, 0, 10};
  eye.camera = 0;
  scene.nodes.push_back(eye);
  for (scene::Node& node : scene.nodes) {
    node.parent_from_node = scene::parent_from_parts(node.translation, node.rotation, node.scale);
    node.world_from_node = node.parent == scene::kNone
                               ? node.parent_from_node
                               : scene.nodes[node.parent].world_from_node * node.parent_from_node;
  }
  scene.bounds_min = glm::vec3(-5);
  scene.bounds_max = glm::vec3(5);
  return scene;
}

}  // namespace fire3dv::app
