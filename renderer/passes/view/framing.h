// Camera placement that fits a set of points into the image.
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/scene/model/bounds.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::passes {

// Share of the image's width or height that stays free on each side.
constexpr float kFramingMargin = 0.05f;

// World-space points that enclose all mesh instances at these node transforms: vertices (every n-th one of
// more than 200,000), or box corners of deformed and small primitives; the box around everything if there are
// more than 100,000 primitives. Left out are unbounded meshes, floors much wider than all other meshes, a few
// small meshes without which the rest is shown at least 1.4 times as large (outliers), and infinite and NaN
// points.
std::vector<glm::vec3> framing_points(const scene::Scene& scene, std::span<const glm::mat4> world_from_node);

// Bounding box of all mesh instances but those outliers; floors count. Empty without meshes.
scene::Box bounds_without_outliers(const scene::Scene& scene, std::span<const glm::mat4> world_from_node);

// world_from_camera of a perspective camera with this orientation (its scale and position do not count), as
// near as possible with all points inside the image minus the margins, and the points to_border inside the
// image. Its distance is at least camera.near_m from each of the points. Returns the orientation at the
// origin if there are no points.
glm::mat4 fit_into_view(const scene::Camera& camera, float image_aspect, const glm::mat4& orientation,
                        std::span<const glm::vec3> points, std::span<const glm::vec3> to_border = {});

// True if the camera at this pose shows all of the points, the margins included.
bool shows_all(const scene::Camera& camera, float image_aspect, const glm::mat4& world_from_camera,
               std::span<const glm::vec3> points);

// Shadows of points on the horizontal plane y = height_m, of those above it and below the light. light: its
// position, or with w 0 the direction towards it.
std::vector<glm::vec3> shadows_on_ground(std::span<const glm::vec3> points, float height_m,
                                         const glm::vec4& light);

// Shadows on that plane at rest, of each light of the file, or the key light.
std::vector<std::vector<glm::vec3>> ground_shadows(const scene::Scene& scene,
                                                   std::span<const glm::vec3> points, float height_m);

// Orientation of the default view: from the right, in front and above, looking at the origin.
glm::mat4 default_orientation();

}  // namespace fire3dv::passes
