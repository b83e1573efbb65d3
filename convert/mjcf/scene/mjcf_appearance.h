// Appearance of an MJCF model's geoms: surfaces, and metallic-roughness materials that approximate MuJoCo's
// specular shading.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>

#include "convert/mjcf/scene/mjcf_scene.h"
#include "convert/model.h"

namespace fire3dv::convert {

class MjcfAppearance {
 public:
  MjcfAppearance(const MjcfScene& scene, Model& model) : scene_(scene), model_(model) {}

  // Neither in a hidden group nor transparent.
  bool is_shown(const MjcfGeom& geom) const;
  bool is_shown(const MjcfSkin& skin) const;
  // In the geom's frame.
  Surface surface(const MjcfGeom& geom) const;
  size_t material(const MjcfGeom& geom) { return material(geom.material, color(geom.rgba, geom.material)); }
  size_t material(const MjcfTendon& tendon) {
    return material(tendon.material, color(tendon.rgba, tendon.material));
  }
  size_t material(const MjcfSkin& skin) { return material(skin.material, color(skin.rgba, skin.material)); }

 private:
  const std::array<float, 4>& color(const std::array<float, 4>& own, std::optional<size_t> material) const;
  size_t material(std::optional<size_t> index, const std::array<float, 4>& rgba);
  std::optional<size_t> image(size_t texture);
  glm::dvec2 repeats(const MjcfGeom& geom, const glm::dvec2& half) const;
  void project_texture(const MjcfGeom& geom, Surface& surface) const;
  bool has_flat_texture(const MjcfGeom& geom) const;

  const MjcfScene& scene_;
  Model& model_;
  std::map<std::pair<std::optional<size_t>, std::array<float, 4>>, size_t> materials_;
  std::map<size_t, std::optional<size_t>> images_;
};

}  // namespace fire3dv::convert
