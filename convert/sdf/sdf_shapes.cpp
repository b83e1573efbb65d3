#include "convert/sdf/sdf_shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/text.h"
#include "convert/sdf/sdf_prism.h"
#include "convert/surfaces.h"

namespace fire3dv::convert {
namespace {

constexpr double kLargest = 1e9;  // metres

// The first `count` numbers are positive and finite.
bool are_sizes(const glm::dvec3& size, int count) {
  for (int i = 0; i < count; ++i)
    if (!(size[i] > 0 && size[i] <= kLargest)) return false;
  return true;
}

// Shortest rotation from Z to the direction.
std::optional<glm::dquat> rotation_from_z(const glm::dvec3& direction) {
  const double length = glm::length(direction);
  if (!(length > 1e-9) || !std::isfinite(length)) return std::nullopt;
  const glm::dvec3 to = direction / length;
  if (to.z < -1 + 1e-12) return glm::dquat(0, 1, 0, 0);
  return glm::normalize(glm::dquat(1 + to.z, -to.y, to.x, 0));
}

void move_to_centre(std::vector<Surface>& surfaces) {
  glm::vec3 low(std::numeric_limits<float>::max()), high(-low);
  for (const Surface& surface : surfaces)
    for (const glm::vec3& position : surface.positions) {
      low = glm::min(low, position);
      high = glm::max(high, position);
    }
  const glm::vec3 centre = 0.5f * low + 0.5f * high;
  for (Surface& surface : surfaces)
    for (glm::vec3& position : surface.positions) position -= centre;
}

}  // namespace

std::optional<glm::dquat> plane_rotation(const SdfShape& plane) {
  return rotation_from_z(plane.normal);
}

SdfShapes::SdfShapes(SdfFiles& files, const ReadOptions& options, SdfMaterials& materials, Model& model)
    : files_(files), materials_(materials), mesh_files_(model) {
  if (options.dae_up) mesh_files_.apply_dae_up();
  mesh_files_.set_smooth_angle(options.smooth_angle_deg);
  if (options.gltf_up.value_or(false)) mesh_files_.apply_gltf_up();
}

Result<void> SdfShapes::add(const SdfItem& visual, Mesh& mesh) {
  using Type = SdfShape::Type;
  const SdfShape& shape = *visual.shape;
  if (shape.type == Type::mesh) return add_mesh(visual, mesh);
  if (shape.type == Type::polyline) return add_polylines(visual, mesh);
  const int sizes = shape.type == Type::box || shape.type == Type::ellipsoid ? 3
                    : shape.type == Type::sphere                             ? 1
                                                                             : 2;
  if (!are_sizes(shape.size, sizes))
    return Error{"a size of its <geometry> is not positive, or beyond 1e9 m"};
  const double radius = shape.size.x, half_length = shape.size.y / 2;
  glm::dmat4 transform(1);
  Surface surface;
  switch (shape.type) {
    case Type::box:
      surface = box(shape.size / 2.0);
      break;
    case Type::sphere:
      surface = ellipsoid(glm::dvec3(radius));
      break;
    case Type::ellipsoid:
      surface = ellipsoid(shape.size);
      break;
    case Type::cylinder:
      surface = cylinder(radius, half_length);
      break;
    case Type::cone:
      surface = cone(radius, half_length);
      break;
    case Type::capsule:
      surface = capsule(radius, half_length);
      break;
    default: {
      const std::optional<glm::dquat> rotation = plane_rotation(shape);
      if (!rotation) return Error{"the <normal> of its <plane> has no direction"};
      transform = glm::mat4_cast(*rotation);
      surface = rectangle(shape.size.x / 2, shape.size.y / 2, glm::dvec2(1));
    }
  }
  add_surface(mesh, surface, transform, materials_.material(visual));
  return {};
}

Result<void> SdfShapes::add_polylines(const SdfItem& visual, Mesh& mesh) {
  constexpr size_t kMaxPoints = 100'000, kMaxLines = 1'000;
  const std::vector<SdfShape::Polyline>& lines = visual.shape->polylines;
  for (const SdfShape::Polyline& line : lines) polyline_points_ += line.points.size();
  if (polyline_points_ > kMaxPoints || lines.size() > kMaxLines)
    return Error{"it has more than " + std::to_string(kMaxLines) +
                 " polylines, or those of the scene have more than " + std::to_string(kMaxPoints) +
                 " points: use a mesh"};
  Prisms prisms = prisms_of(lines);
  if (prisms.surfaces.empty()) return Error{"its <polyline> is not a polygon of finite size"};
  for (const Surface& surface : prisms.surfaces)
    add_surface(mesh, surface, glm::dmat4(1), materials_.material(visual));
  notes_.insert(notes_.end(), prisms.notes.begin(), prisms.notes.end());
  return {};
}

Result<void> SdfShapes::add_mesh(const SdfItem& visual, Mesh& mesh) {
  const SdfShape& shape = *visual.shape;
  const Result<std::filesystem::path> file = files_.resolve(shape.mesh.uri, shape.mesh.from);
  if (!file) return file.error();
  glm::dmat4 scaled(1);
  for (int axis = 0; axis < 3; ++axis) {
    if (shape.size[axis] == 0 || !(std::abs(shape.size[axis]) <= kLargest))
      return Error{"a <scale> of 0 is invisible, and one beyond 1e9 is not drawn"};
    scaled[axis] *= shape.size[axis];
  }
  mesh_files_.allow_images_below(files_.image_folders());
  Result<std::vector<Surface>> surfaces = shape.submesh.empty()
                                              ? mesh_files_.surfaces(*file)
                                              : mesh_files_.surfaces_of_node(*file, shape.submesh);
  if (!surfaces) return surfaces.error();
  if (shape.is_centred && !shape.submesh.empty()) move_to_centre(*surfaces);
  for (const Surface& surface : *surfaces) {
    const size_t material = visual.material ? materials_.material(visual)
                                            : materials_.of_mesh(surface.material, visual.transparency);
    add_surface(mesh, surface, scaled, material);
  }
  return {};
}

}  // namespace fire3dv::convert
