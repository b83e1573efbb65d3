#include "adapters/gazebo/scene/scene_model.h"

#include <cstddef>
#include <utility>

#include "adapters/gazebo/scene/appearance.h"
#include "base/text.h"
#include "convert/readers.h"
#include "convert/sdf/add_sdf.h"
#include "convert/sdf/files/sdf_files.h"
#include "convert/sdf/sdf_warnings.h"

namespace fire3dv::gazebo {
namespace {

void add_items(const TopLevel& item, convert::SdfScene& scene, convert::SdfWarnings& warnings) {
  const size_t first = scene.items.size();
  std::vector<std::string> said;
  for (const Entity& entity : item.entities) {
    const std::string where = std::string(name_of(entity.kind)) + " " + quote(entity.name);
    convert::SdfItem made;
    made.kind = entity.kind;
    if (entity.parent != kNoParent) made.parent = first + entity.parent;
    made.translation = entity.pose.translation;
    made.rotation = entity.pose.rotation;
    if (entity.visual) {
      made.transparency = entity.visual->transparency();
      made.shape = sdf_shape(entity.visual->geometry(), where, said);
      if (entity.visual->has_material()) made.material = sdf_material(entity.visual->material(), where, said);
    }
    if (entity.light) made.light = sdf_light(*entity.light, where, said);
    if (entity.sensor) made.camera = sdf_camera(entity.sensor->camera());
    scene.items.push_back(std::move(made));
    scene.node_names.push_back(item.added_node.empty() ? entity.name : own_name(entity));
    for (const std::string& warning : std::exchange(said, {})) warnings.add(warning);
  }
}

}  // namespace

convert::Model scene_model(const std::vector<TopLevel>& items,
                           const std::vector<std::filesystem::path>& resource_folders,
                           const std::string& name) {
  convert::Model model;
  model.name = convert::sanitize_text(name, 256);
  convert::SdfScene scene;
  convert::SdfWarnings warnings({}, model);
  for (const TopLevel& item : items) add_items(item, scene, warnings);
  convert::SdfFiles files(resource_folders, "--resource-path");
  convert::add_sdf(scene, {}, convert::ReadOptions(), files, model);
  return model;
}

}  // namespace fire3dv::gazebo
