// Appearance of ADF bodies: mesh files and AMBF's built-in shapes, with materials of the file or colours of
// the body, by AMBF's precedence. Bodies of equal appearance share a mesh.
#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "convert/adf/adf_yaml.h"
#include "convert/mesh/mesh_files.h"
#include "convert/mesh/mesh_store.h"
#include "convert/model.h"

namespace fire3dv::convert {

// Meshes of AMBF's built-in shapes, centred as in AMBF, along Z. Without material.

Surface box_surface(const glm::dvec3& full_extents);
Surface ellipsoid_surface(const glm::dvec3& semi_axes);
// Closed at both ends; a top radius of 0 makes a cone.
Surface cylinder_surface(double height, double bottom_radius, double top_radius);
// Square of 100 x 100 at `offset` along the normal, which need not be normalised.
Surface plane_surface(const glm::dvec3& normal, double offset);

// Search folders for a block's mesh.
struct AdfSearchPaths {
  std::filesystem::path file_folder;  // folder of the model file
  std::string visual_path;            // the file's "high resolution path"
};

struct AdfAppearance {
  std::optional<size_t> mesh;
  bool mesh_is_missing = false;  // AMBF drops such bodies
};

class AdfVisuals {
 public:
  AdfVisuals(Model& model, size_t max_triangles)
      : model_(model), files_(model), store_(model, max_triangles) {}

  AdfAppearance appearance_of(const AdfValue& block, const std::string& name,
                              const AdfSearchPaths& search_paths);
  void allow_images_below(const std::filesystem::path& folder) { files_.allow_images_below(folder); }
  void set_smooth_angle(std::optional<double> angle_deg) { files_.set_smooth_angle(angle_deg); }

 private:
  struct Color;
  Color color_of(const AdfValue& block) const;
  std::optional<std::vector<Surface>> file_surfaces(const AdfValue& block, const std::string& name,
                                                    const AdfSearchPaths& search_paths, double scale);
  std::vector<Surface> shape_surfaces(const AdfValue& block, double scale);
  Surface shape_surface(const AdfValue& shape, const AdfValue& geometry, double scale);
  size_t colored(size_t material, const Color& color, const std::string& name);
  size_t plain_material();

  Model& model_;
  MeshFiles files_;
  MeshStore store_;
  std::map<std::string, std::optional<size_t>> meshes_;  // mesh files, keyed by everything that affects their
                                                         // appearance
  std::map<std::string, size_t> materials_;
  std::optional<size_t> plain_;
};

}  // namespace fire3dv::convert
