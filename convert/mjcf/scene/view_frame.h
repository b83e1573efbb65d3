// Camera that shows all of a set of points, from a given direction. Points are added one by one and not
// stored.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>

namespace fire3dv::convert {

class ViewFrame {
 public:
  // to_eye: direction, not along Z, which is up.
  ViewFrame(const glm::dvec3& to_eye, double vertical_fov_rad);

  void add(const glm::dvec3& point);
  // World from camera, which looks along -Z: as near as possible with all points in an image of 4:3, with a
  // margin. Empty without points, or where they are one point or not finite.
  std::optional<glm::dmat4> pose() const;
  double near_m() const;  // near plane of that camera

 private:
  double radius() const;

  glm::dmat3 world_from_camera_;
  std::array<double, 2> tangents_;  // of half the image's angles, right and up
  // Bounds of each point's half-spaces of eye positions, in camera axes.
  std::array<double, 2> above_, below_;
  glm::dvec3 low_{1e30}, high_{-1e30};  // in camera axes
};

}  // namespace fire3dv::convert
