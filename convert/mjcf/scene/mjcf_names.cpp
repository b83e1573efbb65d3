#include "convert/mjcf/scene/mjcf_names.h"

#include <set>

namespace fire3dv::convert {
namespace {

// Replaces control characters, which SPEC.md forbids in node names and which break message lines.
std::string printable(std::string name) {
  for (char& c : name)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return name;
}

class Names {
 public:
  std::string free(const std::string& own, const std::string& kind, size_t index) {
    return free(own.empty() ? kind + "_" + std::to_string(index) : printable(own), kind);
  }

  std::string free(std::string name, const std::string& kind) {
    if (taken_.insert(name).second) return name;
    for (int i = 0;; ++i) {
      std::string other = name + " " + kind + (i ? " " + std::to_string(i) : "");
      if (taken_.insert(other).second) return other;
    }
  }

 private:
  std::set<std::string> taken_;
};

MjcfOwnNames names_in(const MjcfScene& scene) {
  MjcfOwnNames own;
  for (const MjcfBody& body : scene.bodies) own.bodies.push_back(body.name);
  for (const MjcfCamera& camera : scene.cameras) own.cameras.push_back(camera.name);
  for (const MjcfLight& light : scene.lights) own.lights.push_back(light.name);
  for (const MjcfGeom& geom : scene.geoms) own.geoms.push_back(geom.name);
  for (const MjcfTendon& tendon : scene.tendons) own.tendons.emplace_back(tendon.name, tendon.max_points);
  for (const MjcfSkin& skin : scene.skins) own.skins.push_back(skin.name);
  return own;
}

}  // namespace

MjcfNames::MjcfNames(const MjcfScene& scene) : MjcfNames(names_in(scene)) {}

MjcfNames::MjcfNames(const MjcfOwnNames& own)
    : bodies(own.bodies.size()), tendon_pieces(own.tendons.size()), tendon_ends(own.tendons.size()) {
  Names names;
  // Named bodies come first, so that generated names cannot take theirs.
  for (const bool has_name : {true, false})
    for (size_t body = 0; body < bodies.size(); ++body)
      if (own.bodies[body].empty() != has_name) bodies[body] = names.free(own.bodies[body], "body", body);
  free_camera = names.free("free camera", "camera");
  for (size_t i = 0; i < own.cameras.size(); ++i) cameras.push_back(names.free(own.cameras[i], "camera", i));
  for (size_t i = 0; i < own.lights.size(); ++i) lights.push_back(names.free(own.lights[i], "light", i));
  for (size_t i = 0; i < own.tendons.size(); ++i) {
    const auto& [name, points] = own.tendons[i];
    if (points < 2) continue;
    const std::string tendon = name.empty() ? "tendon_" + std::to_string(i) : printable(name);
    for (size_t piece = 0; piece + 1 < points; ++piece)
      tendon_pieces[i].push_back(names.free(tendon + "#" + std::to_string(piece), "tendon"));
    for (size_t end = 0; end < points; ++end)
      tendon_ends[i].push_back(names.free(tendon + "#end " + std::to_string(end), "tendon"));
  }
  for (size_t i = 0; i < own.geoms.size(); ++i) geoms.push_back(names.free(own.geoms[i], "geom", i));
  // Last, so that skins, which no stream moves, do not change names that publishers know.
  for (size_t i = 0; i < own.skins.size(); ++i) skins.push_back(names.free(own.skins[i], "skin", i));
  overview = names.free("overview", "camera");
}

}  // namespace fire3dv::convert
