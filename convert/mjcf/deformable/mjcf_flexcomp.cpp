// flexcomp elements: a deformable object with a body for each of its points, or for the nodes of a lattice
// around it.
#include <algorithm>
#include <string>
#include <utility>

#include "convert/mjcf/assets/mjcf_mesh.h"
#include "convert/mjcf/bodies/mjcf_bodies.h"
#include "convert/mjcf/deformable/mjcf_flexes.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

constexpr size_t kMaxGridPoints = 250'000, kMaxGridBones = 65'535;
constexpr double kMaxPins = 1e6;

std::array<int, 3> counts_of(const MjcfAttributes& from, const char* name, int otherwise) {
  const auto given = from.vec3(name);
  std::array<int, 3> counts{otherwise, otherwise, otherwise};
  for (int k = 0; given && k < 3; ++k)
    counts[static_cast<size_t>(k)] = static_cast<int>(std::clamp((*given)[k], -1.0, 1e6));
  return counts;
}

Result<FlexShape> shape_from_mesh(MjcfSource& source, const MjcfAttributes& from, int dimension) {
  const Result<MeshData> mesh = read_mjcf_mesh_data(source, from.element());
  if (!mesh) return mesh.error();
  FlexShape shape;
  shape.dimension = dimension;
  if (dimension == 3) shape.points.push_back(from.vec3("origin").value_or(glm::dvec3(0)));
  const auto first = static_cast<uint32_t>(shape.points.size());
  for (const glm::vec3& vertex : mesh->vertices) shape.points.emplace_back(vertex);
  const bool has_uvs = mesh->uv_faces.size() == mesh->faces.size() && dimension == 2;
  if (has_uvs) shape.uvs = mesh->uvs;
  for (size_t i = 0; i < mesh->faces.size(); ++i) {
    const auto& [a, b, c] = mesh->faces[i];
    if (dimension == 1) {
      shape.elements.insert(shape.elements.end(), {a, b});
      continue;
    }
    if (dimension == 3) {  // tetrahedra without volume are left out
      const glm::dvec3 origin = shape.points[0],
                       edges[] = {shape.points[first + a] - origin, shape.points[first + b] - origin,
                                  shape.points[first + c] - origin};
      if (glm::dot(glm::cross(edges[0], edges[1]), edges[2]) < 1e-15) continue;
      shape.elements.push_back(0);
    }
    shape.elements.insert(shape.elements.end(), {first + a, first + b, first + c});
    if (has_uvs)
      shape.uv_elements.insert(shape.uv_elements.end(), mesh->uv_faces[i].begin(), mesh->uv_faces[i].end());
  }
  return shape;
}

Result<FlexShape> shape_of(MjcfSource& source, const MjcfAttributes& from, const std::string& type,
                           const std::array<int, 3>& count, int dimension) {
  FlexShape shape;
  shape.dimension = dimension;
  if (type == "gmsh")
    return Error{"GMSH files are not supported; convert the file to OBJ and use type=\"mesh\""};
  if (type == "mesh") {
    Result<FlexShape> made = shape_from_mesh(source, from, dimension);
    if (!made) return made.error();
    shape = std::move(*made);
  } else if (type == "direct") {
    if (Result<void> done = read_flex_shape(from, "point", shape); !done) return done.error();
  } else {
    return flex_grid({type, count, from.vec3("spacing").value_or(glm::dvec3(0.02))}, dimension);
  }
  if (shape.points.size() > kMaxGridPoints)
    return Error{"it has more than " + std::to_string(kMaxGridPoints) + " points"};
  if (shape.elements.empty()) return Error{"it has no elements"};
  for (const uint32_t point : shape.elements)
    if (point >= shape.points.size())
      return Error{"an element names point " + std::to_string(point) + " of " +
                   std::to_string(shape.points.size()) + ", counted from 0"};
  const glm::dvec3 scale = from.vec3("scale").value_or(glm::dvec3(1));
  for (glm::dvec3& point : shape.points) point *= scale;
  return shape;
}

// Marks points of pin elements: by number, or by cell of the grid.
class Pins {
 public:
  Pins(const MjcfAttributes& from, int dimension, const std::array<int, 3>& count, std::vector<bool>& pinned)
      : from_(from), dimension_(static_cast<size_t>(dimension)), count_(count), pinned_(pinned) {}

  void read(const MjcfElement& pin) {
    for (const double id : numbers(pin, "id")) mark(id);
    const std::vector<double> ranges = numbers(pin, "range");
    for (size_t i = 0; i + 2 <= ranges.size(); i += 2)
      for (double id = std::max(ranges[i], 0.0); id <= std::min(ranges[i + 1], kMaxPins); ++id) mark(id);
    const std::vector<double> cells = numbers(pin, "grid");
    for (size_t i = 0; i + dimension_ <= cells.size(); i += dimension_) mark_grid(&cells[i], &cells[i]);
    const std::vector<double> boxes = numbers(pin, "gridrange");
    for (size_t i = 0; i + 2 * dimension_ <= boxes.size(); i += 2 * dimension_)
      mark_grid(&boxes[i], &boxes[i + dimension_]);
  }

 private:
  std::vector<double> numbers(const MjcfElement& pin, const char* attribute) const {
    const std::string* const text = pin.find(attribute);
    return text ? mjcf_numbers(*text, kMaxGridPoints) : std::vector<double>();
  }

  void mark(double id) {
    if (id >= 0 && id < static_cast<double>(pinned_.size()))
      pinned_[static_cast<size_t>(id)] = true;
    else if (!std::exchange(has_reported_, true))
      from_.warn("a pin names a point that does not exist");
  }

  void mark_grid(const double* low, const double* high) {
    std::array<int, 3> first{0, 0, 0}, last{0, 0, 0};
    for (size_t k = 0; k < dimension_; ++k) {
      first[k] = static_cast<int>(std::clamp(low[k], 0.0, static_cast<double>(count_[k])));
      last[k] = static_cast<int>(std::clamp(high[k], -1.0, static_cast<double>(count_[k] - 1)));
    }
    const double row = dimension_ > 1 ? count_[1] : 1, column = dimension_ > 2 ? count_[2] : 1;
    for (int x = first[0]; x <= last[0]; ++x)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int z = first[2]; z <= last[2]; ++z) mark((x * row + y) * column + z);
  }

  const MjcfAttributes& from_;
  const size_t dimension_;
  const std::array<int, 3> count_;
  std::vector<bool>& pinned_;
  bool has_reported_ = false;
};

// Removes points without elements.
void compact(FlexShape& shape, std::vector<bool>& pinned) {
  std::vector<bool> used(shape.points.size(), false);
  for (const uint32_t point : shape.elements) used[point] = true;
  std::vector<uint32_t> new_index(shape.points.size(), 0);
  uint32_t count = 0;
  for (size_t i = 0; i < used.size(); ++i) {
    new_index[i] = count;
    if (!used[i]) continue;
    shape.points[count] = shape.points[i];
    pinned[count++] = pinned[i];
  }
  shape.points.resize(count);
  for (uint32_t& point : shape.elements) point = new_index[point];
}

// Weights of the eight nodes of the cell around a point, and their indices.
Influences lattice_influences(const glm::dvec3& share, const std::array<int, 3>& cells,
                              const std::vector<uint16_t>& bones) {
  std::array<int, 3> cell{};
  glm::dvec3 inside(0);
  for (int k = 0; k < 3; ++k) {
    const int count = cells[static_cast<size_t>(k)];
    const double at = std::clamp(share[k], 0.0, 1.0) * count;
    cell[static_cast<size_t>(k)] = std::min(static_cast<int>(at), count - 1);
    inside[k] = at - cell[static_cast<size_t>(k)];
  }
  Influences made;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    int index = 0;
    for (int k = 0; k < 3; ++k) {
      const int upper = corner >> k & 1;
      weight *= upper ? inside[k] : 1 - inside[k];
      index = index * (cells[static_cast<size_t>(k)] + 1) + cell[static_cast<size_t>(k)] + upper;
    }
    made.joints[static_cast<size_t>(corner)] = bones[static_cast<size_t>(index)];
    made.weights[static_cast<size_t>(corner)] = static_cast<float>(weight);
  }
  return made;
}

}  // namespace

// Adds a body at a point of its parent that slides along axes.
Result<size_t> MjcfBodyReader::add_flex_body(const std::string& name, const glm::dvec3& position,
                                             const std::vector<glm::dvec3>& axes, double mass,
                                             const Scope& scope) {
  if (Result<void> done = count_objects(); !done) return done.error();
  MjcfTreeBody body;
  body.name = scope.name(name);
  body.parent = scope.body;
  body.pose.position = position;
  body.given_mass.emplace();
  body.given_mass->add(mass, glm::dvec3(0));
  for (const glm::dvec3& axis : axes) {
    MjcfJoint joint;
    joint.type = MjcfJoint::Type::slide;
    joint.axis = axis;
    body.joints.push_back(joint);
  }
  tree_.body_index.emplace(body.name, tree_.bodies.size());
  tree_.bodies.push_back(std::move(body));
  return tree_.bodies.size() - 1;
}

Result<void> MjcfBodyReader::read_flexcomp(const MjcfElement& element, const Scope& scope) {
  MjcfSource& source = *scope.source;
  const MjcfAttributes from = source.attributes(element, scope.class_index);
  const auto leave_out = [&](const std::string& reason) {
    from.warn("is left out: " + reason);
    return Result<void>();
  };
  const std::string given = from.text("type"), type = given.empty() ? "grid" : given, dof = from.text("dof");
  const bool is_direct = type == "mesh" || type == "direct";
  const int dimension = from.integer("dim", 2);
  if (dimension < 1 || dimension > 3) return leave_out("dim is not from 1 to 3");
  const std::array<int, 3> count = counts_of(from, "count", 10);
  Result<FlexShape> read = shape_of(source, from, type, count, dimension);
  if (!read) return leave_out(read.error().message);
  FlexShape& shape = *read;
  const MjcfPose pose{from.vec3("pos").value_or(glm::dvec3(0)), from.rotation(source.compiler())};
  glm::dvec3 low(1e300), high(-1e300);
  for (glm::dvec3& point : shape.points) {
    point = pose * point;
    low = glm::min(low, point);
    high = glm::max(high, point);
  }
  const bool is_lattice = dof == "trilinear" || dof == "quadratic";
  std::array<int, 3> cells = is_direct ? counts_of(from, "cellcount", 1) : std::array<int, 3>{1, 1, 1};
  const int order = dof == "quadratic" ? 2 : 1;
  size_t nodes = 0;
  if (is_lattice) {
    nodes = 1;
    for (int& cell : cells) {
      if (cell < 1 || cell > 1000) return leave_out("cellcount is not from 1 to 1000");
      cell *= order;
      nodes *= static_cast<size_t>(cell) + 1;
    }
    if (nodes > kMaxGridBones)
      return leave_out("it has more than " + std::to_string(kMaxGridBones) + " nodes");
  }
  const bool is_rigid = from.flag("rigid", false);
  std::vector<bool> pinned(std::max(shape.points.size(), nodes), is_rigid);
  Pins pins(from, dimension,
            is_lattice && !is_direct ? std::array<int, 3>{order + 1, order + 1, order + 1} : count, pinned);
  for (const MjcfElement& child : element.children)
    if (child.kind == "pin" && !is_rigid) pins.read(child);
  if (dof == "radial") pinned[0] = true;
  if (is_direct) compact(shape, pinned);

  MjcfSkin skin = flex_appearance(source, from, assets_);
  skin.name = scope.name(skin.name);
  skin.bones.push_back({scope.body, {}});
  const std::string name = from.name() + "_";
  // Adds a body and its bone; bone 0 is the parent.
  const auto add_bone = [&](const std::string& own, const glm::dvec3& position,
                            const std::vector<glm::dvec3>& axes, size_t all) -> Result<uint16_t> {
    const Result<size_t> body =
        add_flex_body(name + own, position, axes, from.number("mass", 1) / static_cast<double>(all), scope);
    if (!body) return body.error();
    if (skin.bones.size() > kMaxGridBones) {
      from.warn("more than " + std::to_string(kMaxGridBones) +
                " of its points are bodies; the others do not move");
      return uint16_t{0};
    }
    skin.bones.push_back({*body, {position, glm::dquat(1, 0, 0, 0)}});
    return static_cast<uint16_t>(skin.bones.size() - 1);
  };
  std::vector<Influences> influences(shape.points.size());
  for (Influences& each : influences) each.weights[0] = 1;
  const std::vector<glm::dvec3> all_axes{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  if (is_lattice && !is_rigid) {
    std::vector<uint16_t> bones(nodes, 0);
    const glm::dvec3 side = high - low;
    for (int x = 0, node = 0; x <= cells[0]; ++x)
      for (int y = 0; y <= cells[1]; ++y)
        for (int z = 0; z <= cells[2]; ++z, ++node) {
          if (pinned[static_cast<size_t>(node)]) continue;
          const glm::dvec3 at = low + side * glm::dvec3(x, y, z) / glm::dvec3(cells[0], cells[1], cells[2]);
          const auto bone = add_bone(std::to_string(x) + "_" + std::to_string(y) + "_" + std::to_string(z),
                                     at, all_axes, nodes);
          if (!bone) return bone.error();
          bones[static_cast<size_t>(node)] = *bone;
        }
    if (order == 2)
      from.warn("it is shown as a linear lattice of its nodes, since dof=\"quadratic\" is not supported");
    for (size_t i = 0; i < shape.points.size(); ++i) {
      glm::dvec3 share(0);
      for (int k = 0; k < 3; ++k) share[k] = side[k] > 0 ? (shape.points[i][k] - low[k]) / side[k] : 0;
      influences[i] = lattice_influences(share, cells, bones);
    }
  } else if (!is_rigid) {
    for (size_t i = 0; i < shape.points.size(); ++i) {
      if (pinned[i]) continue;
      const glm::dvec3& point = shape.points[i];
      std::vector<glm::dvec3> axes = all_axes;
      if (dof == "2d") axes.pop_back();
      if (dof == "radial") axes = {glm::length(point) > 0 ? glm::normalize(point) : glm::dvec3(0, 0, 1)};
      const auto bone = add_bone(std::to_string(i), point, axes, shape.points.size());
      if (!bone) return bone.error();
      influences[i].joints[0] = *bone;
    }
  }
  const bool is_flat = from.flag("flatskin", false) || type == "box" || type == "cylinder" ||
                       (type == "grid" && dimension == 3);
  set_flex_surface(shape, influences, from.number("radius", 0.005), is_flat, skin);
  tree_.skins.push_back({std::move(skin), 0});
  return {};
}

}  // namespace fire3dv::convert
