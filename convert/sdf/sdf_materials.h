// Materials of an SDF scene, as Gazebo shows them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "convert/model.h"
#include "convert/sdf/files/sdf_files.h"
#include "convert/sdf/sdf_scene.h"
#include "convert/sdf/sdf_warnings.h"

namespace fire3dv::convert {

// Colours of a material of Gazebo Classic, linear. Empty for an unknown name.
struct SdfScriptColors {
  glm::vec4 diffuse{1};
  glm::vec3 emissive{0};
};
std::optional<SdfScriptColors> sdf_script_colors(const std::string& name);

class SdfMaterials {
 public:
  // All are borrowed.
  SdfMaterials(SdfFiles& files, SdfWarnings& warnings, Model& model)
      : files_(files), warnings_(warnings), model_(model) {}

  // Returns the material of a visual: its own or Gazebo's grey, with its transparency.
  size_t material(const SdfItem& visual);
  // Returns a material of a mesh file with the transparency of the visual.
  size_t of_mesh(size_t material, double transparency);

 private:
  Material made(const SdfItem& visual);
  void add_maps(const SdfMaterial& from, Material& to);
  std::optional<size_t> image(const SdfUri& uri, const char* map);
  std::optional<size_t> metallic_roughness(std::optional<size_t> metalness, std::optional<size_t> roughness);
  bool has_alpha(size_t image) const;
  void warn(const std::string& text) { warnings_.add(text); }

  SdfFiles& files_;
  SdfWarnings& warnings_;
  Model& model_;
  std::map<std::string, size_t> materials_;  // by all that they consist of
  std::map<std::pair<size_t, double>, size_t> transparent_;
  std::map<std::filesystem::path, std::optional<size_t>> images_;
  std::map<std::pair<std::optional<size_t>, std::optional<size_t>>, std::optional<size_t>> packed_;
};

}  // namespace fire3dv::convert
