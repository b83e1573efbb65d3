// Materials of Gazebo's visuals as glTF materials, with their textures. One per visual and mesh; equal ones
// are shared.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "adapters/gazebo/scene/resources.h"
#include "gazebo.pb.h"
#include "tools/convert/model.h"

namespace fire3dv::gazebo {

class Materials {
 public:
  // Both are borrowed.
  Materials(convert::Model& model, const Resources& resources) : model_(model), resources_(resources) {}

  // Index of the material of a visual with a material, or of a shape without one.
  size_t of_visual(const pb::Visual& visual, const std::string& node);
  // Copy of a mesh file's material with the transparency of the visual.
  size_t with_transparency(size_t material, double transparency);

 private:
  std::optional<size_t> image(const std::string& uri, const std::string& where);
  std::optional<size_t> packed_image(const pb::Material::Pbr& pbr, const std::string& where);

  convert::Model& model_;
  const Resources& resources_;
  std::map<std::string, size_t> by_message_;
  std::map<std::pair<size_t, double>, size_t> transparent_;
  std::map<std::filesystem::path, std::optional<size_t>> images_;
  std::map<std::pair<std::string, std::string>, std::optional<size_t>> packed_;
};

}  // namespace fire3dv::gazebo
