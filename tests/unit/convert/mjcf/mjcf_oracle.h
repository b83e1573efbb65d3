// Comparison of a scene that the MJCF reader made with the same model compiled by libmujoco.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "adapters/mujoco/compiled/compiled_scene.h"
#include "convert/mjcf/scene/mjcf_scene.h"

namespace fire3dv::convert {

class MjcfOracle {
 public:
  MjcfOracle(const MjcfScene& read, const MjcfScene& compiled) : read_(read), compiled_(compiled) {}

  // One line per difference; empty: the scenes are equal to 1e-6 of the extent.
  std::vector<std::string> differences() {
    near("extent", read_.extent, compiled_.extent, 1e-5);
    near("centre", read_.centre, compiled_.centre, 1e-5);
    near("azimuth", read_.azimuth_deg, compiled_.azimuth_deg);
    near("elevation", read_.elevation_deg, compiled_.elevation_deg);
    near("field of view", read_.vertical_fov_deg, compiled_.vertical_fov_deg);
    if (count("bodies", read_.bodies, compiled_.bodies))
      for (size_t i = 0; i < read_.bodies.size(); ++i) compare_body(i);
    if (count("geoms", read_.geoms, compiled_.geoms))
      for (size_t i = 0; i < read_.geoms.size(); ++i) compare_geom(i);
    if (count("cameras", read_.cameras, compiled_.cameras))
      for (size_t i = 0; i < read_.cameras.size(); ++i) compare_camera(i);
    if (count("lights", read_.lights, compiled_.lights))
      for (size_t i = 0; i < read_.lights.size(); ++i) compare_light(i);
    if (count("tendons", read_.tendons, compiled_.tendons))
      for (size_t i = 0; i < read_.tendons.size(); ++i) compare_tendon(i);
    return std::move(differences_);
  }

 private:
  void differ(const std::string& what) {
    if (differences_.size() < 20) differences_.push_back(what);
  }
  template <typename List>
  bool count(const std::string& what, const List& a, const List& b) {
    if (a.size() != b.size())
      differ(what + ": " + std::to_string(a.size()) + " instead of " + std::to_string(b.size()));
    return a.size() == b.size();
  }
  void near(const std::string& what, double a, double b, double tolerance = 1e-6) {
    if (!(std::abs(a - b) <= tolerance * std::max(1.0, std::abs(b))))
      differ(what + ": " + std::to_string(a) + " instead of " + std::to_string(b));
  }
  void near(const std::string& what, const glm::dvec3& a, const glm::dvec3& b, double tolerance = 1e-6) {
    const double size = std::max({1.0, glm::length(b), compiled_.extent});
    if (!(glm::distance(a, b) <= tolerance * size)) differ(what + ": " + text(a) + " instead of " + text(b));
  }
  void near(const std::string& what, const MjcfPose& a, const MjcfPose& b) {
    near(what + " position", a.position, b.position);
    near(what + " x axis", a.rotation * glm::dvec3(1, 0, 0), b.rotation * glm::dvec3(1, 0, 0));
    near(what + " y axis", a.rotation * glm::dvec3(0, 1, 0), b.rotation * glm::dvec3(0, 1, 0));
  }
  void same(const std::string& what, const std::string& a, const std::string& b) {
    if (a != b) differ(what + ": \"" + a + "\" instead of \"" + b + "\"");
  }
  static std::string text(const glm::dvec3& v) {
    return "(" + std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z) + ")";
  }

  void compare_body(size_t i) {
    const MjcfBody &a = read_.bodies[i], &b = compiled_.bodies[i];
    const std::string what = "body " + std::to_string(i) + " " + b.name;
    same(what + " name", a.name, b.name);
    if (a.parent != b.parent) differ(what + " has another parent");
    near(what, a.world_pose, b.world_pose);
  }

  void compare_geom(size_t i) {
    const MjcfGeom &a = read_.geoms[i], &b = compiled_.geoms[i];
    const std::string what = "geom " + std::to_string(i) + " " + b.name;
    same(what + " name", a.name, b.name);
    if (a.body != b.body || a.shape != b.shape || a.group != b.group)
      differ(what + " has another body, shape or group");
    for (size_t k = 0; k < 4; ++k)
      near(what + " rgba", static_cast<double>(a.rgba[k]), static_cast<double>(b.rgba[k]));
    same(what + " material", a.material ? read_.materials[*a.material].name : "",
         b.material ? compiled_.materials[*b.material].name : "");
    if (a.material && b.material)
      compare_material(read_.materials[*a.material], compiled_.materials[*b.material]);
    if (a.body != b.body || a.shape != b.shape) return;
    const MjcfPose world_a = read_.bodies[a.body].world_pose * a.pose,
                   world_b = compiled_.bodies[b.body].world_pose * b.pose;
    if (a.shape == MjcfShape::mesh) {
      compare_meshes(what, a, world_a, b, world_b);
      return;
    }
    if (a.shape == MjcfShape::height_field) {
      near(what, world_a, world_b);
      compare_fields(what, a, b);
      return;
    }
    const int sizes = a.shape == MjcfShape::sphere                                      ? 1
                      : a.shape == MjcfShape::capsule || a.shape == MjcfShape::cylinder ? 2
                                                                                        : 3;
    for (int k = 0; k < sizes; ++k) near(what + " size", a.size[k], b.size[k]);
    near(what + " position", world_a.position, world_b.position);
    if (a.shape == MjcfShape::sphere) return;
    // Axes of symmetric shapes may point either way.
    for (int k = a.shape == MjcfShape::capsule || a.shape == MjcfShape::cylinder ? 2 : 0; k < 3; ++k) {
      const glm::dvec3 axis_a = glm::mat3_cast(world_a.rotation)[k],
                       axis_b = glm::mat3_cast(world_b.rotation)[k];
      near(what + " axis " + std::to_string(k), axis_a * (glm::dot(axis_a, axis_b) < 0 ? -1.0 : 1.0), axis_b);
    }
  }

  void compare_material(const MjcfMaterial& a, const MjcfMaterial& b) {
    const std::string what = "material " + b.name;
    for (size_t k = 0; k < 4; ++k)
      near(what + " rgba", static_cast<double>(a.rgba[k]), static_cast<double>(b.rgba[k]));
    near(what + " emission", static_cast<double>(a.emission), static_cast<double>(b.emission));
    near(what + " specular", static_cast<double>(a.specular), static_cast<double>(b.specular));
    near(what + " shininess", static_cast<double>(a.shininess), static_cast<double>(b.shininess));
    near(what + " reflectance", static_cast<double>(a.reflectance), static_cast<double>(b.reflectance));
    near(what + " repeats", glm::dvec3(a.texture_repeats, 0), glm::dvec3(b.texture_repeats, 0));
    if (a.texture_is_uniform != b.texture_is_uniform) differ(what + " is uniform or not");
    if (a.texture.has_value() != b.texture.has_value()) {
      differ(what + " has a texture or not");
    } else if (a.texture) {
      const MjcfTexture &ta = read_.textures[*a.texture], &tb = compiled_.textures[*b.texture];
      if (ta.is_cube != tb.is_cube) differ(what + " is a cube or not");
      if (ta.is_cube) near(what + " mean colour", glm::dvec3(ta.mean_color), glm::dvec3(tb.mean_color), 0.03);
    }
  }

  // Vertices of the compiled mesh that it draws must be among ours, in the world.
  void compare_meshes(const std::string& what, const MjcfGeom& a, const MjcfPose& world_a, const MjcfGeom& b,
                      const MjcfPose& world_b) {
    if (!a.data || !b.data) return differ(what + " has no mesh");
    const Surface &mesh_a = *read_.meshes[*a.data], &mesh_b = *compiled_.meshes[*b.data];
    if (mesh_a.indices.size() != mesh_b.indices.size())
      differ(what + " triangles: " + std::to_string(mesh_a.indices.size() / 3) + " instead of " +
             std::to_string(mesh_b.indices.size() / 3));
    constexpr size_t kSamples = 200;
    const size_t step = std::max<size_t>(1, mesh_b.indices.size() / kSamples);
    for (size_t i = 0; i < mesh_b.indices.size(); i += step) {
      const glm::dvec3 point = world_b * glm::dvec3(mesh_b.positions[mesh_b.indices[i]]);
      double nearest = 1e300;
      for (const glm::vec3& p : mesh_a.positions)
        nearest = std::min(nearest, glm::distance(world_a * glm::dvec3(p), point));
      if (nearest > 1e-5 * std::max(0.1, compiled_.extent)) {
        differ(what + " lacks the vertex " + text(point) + " by " + std::to_string(nearest));
        return;
      }
    }
  }

  void compare_fields(const std::string& what, const MjcfGeom& a, const MjcfGeom& b) {
    const MjcfHeightField &fa = *read_.height_fields[*a.data], &fb = *compiled_.height_fields[*b.data];
    near(what + " half", glm::dvec3(fa.half, fa.height), glm::dvec3(fb.half, fb.height));
    near(what + " base", fa.base, fb.base);
    if (fa.rows != fb.rows || fa.columns != fb.columns) return differ(what + " has other rows or columns");
    for (size_t i = 0; i < fa.data.size(); ++i)
      near(what + " elevation", static_cast<double>(fa.data[i]), static_cast<double>(fb.data[i]));
  }

  void compare_camera(size_t i) {
    const MjcfCamera &a = read_.cameras[i], &b = compiled_.cameras[i];
    const std::string what = "camera " + std::to_string(i) + " " + b.name;
    same(what + " name", a.name, b.name);
    if (a.body != b.body) differ(what + " has another body");
    near(what, a.world_pose, b.world_pose);
    near(what + " field of view", a.vertical_fov_deg, b.vertical_fov_deg);
  }

  void compare_light(size_t i) {
    const MjcfLight &a = read_.lights[i], &b = compiled_.lights[i];
    const std::string what = "light " + std::to_string(i) + " " + b.name;
    same(what + " name", a.name, b.name);
    if (a.body != b.body || a.type != b.type) differ(what + " has another body or type");
    if (is_scene_light(a) != is_scene_light(b)) differ(what + " is off or on");
    near(what + " position", a.position, b.position);
    near(what + " direction", a.direction, b.direction);
    near(what + " diffuse", glm::dvec3(a.diffuse), glm::dvec3(b.diffuse));
    near(what + " cutoff", a.cutoff_deg, b.cutoff_deg);
  }

  void compare_tendon(size_t i) {
    const MjcfTendon &a = read_.tendons[i], &b = compiled_.tendons[i];
    const std::string what = "tendon " + std::to_string(i) + " " + b.name;
    same(what + " name", a.name, b.name);
    if (a.max_points != b.max_points) differ(what + " has another number of points");
    if (!count(what + " pieces", a.pieces, b.pieces)) return;
    for (size_t k = 0; k < a.pieces.size(); ++k) {
      near(what + " start", a.pieces[k].from, b.pieces[k].from, 1e-5);
      near(what + " end", a.pieces[k].to, b.pieces[k].to, 1e-5);
      near(what + " radius", a.pieces[k].radius_m, b.pieces[k].radius_m);
    }
  }

  const MjcfScene &read_, &compiled_;
  std::vector<std::string> differences_;
};

}  // namespace fire3dv::convert
