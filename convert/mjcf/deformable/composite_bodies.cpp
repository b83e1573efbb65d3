// Composites of MuJoCo 2: particles, grids, ropes, loops, cloth and shells.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "convert/mjcf/deformable/composite_parts.h"

#include "base/text.h"

namespace fire3dv::convert {
namespace {

const glm::dquat kNoTurn(1, 0, 0, 0);

double spacing_of(const CompositeParts& parts) {
  return parts.from.number("spacing", 0);
}

Result<void> check(const CompositeParts& parts) {
  if (!(spacing_of(parts) > 0)) return Error{"its spacing is not positive"};
  if (parts.geom_type != "sphere" && parts.geom_type != "capsule" && parts.geom_type != "ellipsoid")
    return Error{"its geom is not a sphere, capsule or ellipsoid"};
  return {};
}

std::string cell_name(int x, int y) {
  return std::to_string(x) + "_" + std::to_string(y);
}

void set_sheet(const CompositeParts& parts, Composite& to) {
  std::vector<SheetBone> bones;
  for (int x = 0; x < parts.count[0]; ++x)
    for (int y = 0; y < parts.count[1]; ++y) bones.push_back({parts.prefix + "B" + cell_name(x, y), {}});
  to.skin = sheet_skin(parts.count[0], parts.count[1], bones);
  const std::vector<double> inflation = mjcf_numbers(parts.child("skin")->text("inflate"), 1);
  if (!inflation.empty()) to.inflation = inflation[0];
}

void add_slides(const CompositeParts& parts, const std::string& name, MjcfElement& body) {
  constexpr glm::dvec3 kAxes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (size_t i = 0; i < 3; ++i)
    body.children.push_back(parts.joint(
        "slide", name.empty() ? name : parts.prefix + "J" + std::to_string(i) + "_" + name, {}, kAxes[i]));
}

bool is_pinned(const CompositeParts& parts, int x, int y) {
  for (const MjcfElement& child : parts.from.element().children) {
    if (child.kind != "pin") continue;
    const std::vector<double> cell = mjcf_numbers(child.text("coord"), 2);
    if (cell.size() == 2 && cell[0] == x && cell[1] == y) return true;
  }
  return false;
}

// Hinges that bend, and those that the composite asks for, at a point of the body.
void add_hinges(const CompositeParts& parts, const std::string& name, const glm::dvec3& anchor,
                const glm::dvec3& along, MjcfElement& body) {
  const std::vector<glm::dvec3> bends = along.x != 0 ? std::vector<glm::dvec3>{{0, 1, 0}, {0, 0, 1}}
                                                     : std::vector<glm::dvec3>{{1, 0, 0}, {0, 0, 1}};
  for (size_t i = 0; i < 2; ++i)
    body.children.push_back(
        parts.joint("hinge", parts.prefix + "J" + std::to_string(i) + "_" + name, anchor, bends[i]));
  const glm::dvec3 axis = along.x != 0 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  if (parts.has_joint("twist"))
    body.children.push_back(parts.joint("hinge", parts.prefix + "JT" + name, anchor, axis));
  if (parts.has_joint("stretch"))
    body.children.push_back(parts.joint("slide", parts.prefix + "JS" + name, anchor, axis));
}

// Numbers after the prefix and B in the name of the root body.
std::vector<int> root_cell(const CompositeParts& parts) {
  const std::string start = parts.prefix + "B";
  if (!parts.parent.starts_with(start)) return {};
  std::string rest = parts.parent.substr(start.size());
  std::replace(rest.begin(), rest.end(), '_', ' ');
  std::vector<int> cell;
  for (const double number : mjcf_numbers(rest, 2))
    cell.push_back(static_cast<int>(std::clamp(number, -1.0, 1e6)));
  return cell;
}

class Cloth {
 public:
  explicit Cloth(const CompositeParts& parts) : parts_(parts), spacing_(spacing_of(parts)) {}

  MjcfElement geom(int x, int y) const {
    const double half = std::numbers::sqrt2 / 2;
    return parts_.geom(parts_.prefix + "G" + cell_name(x, y), parts_.geom_type, parts_.geom_size, {},
                       (x + y) % 2 ? glm::dquat(half, half, 0, 0) : glm::dquat(0.5, 0.5, 0.5, 0.5));
  }
  // Bodies of a column from a row on, upwards or downwards; each holds the next.
  void add_column(int x, int y, int step, MjcfElement& to) const {
    const int last = step > 0 ? parts_.count[1] - 1 : 0;
    std::optional<MjcfElement> inner;
    for (int row = last; row != y; row -= step) {
      MjcfElement body = made(x, row, {0, step * spacing_, 0});
      if (inner) body.children.push_back(std::move(*inner));
      inner = std::move(body);
    }
    if (inner) to.children.push_back(std::move(*inner));
  }
  void add_row(int x, int y, int step, MjcfElement& to) const {
    const int last = step > 0 ? parts_.count[0] - 1 : 0;
    std::optional<MjcfElement> inner;
    for (int column = last; column != x; column -= step) {
      MjcfElement body = made(column, y, {step * spacing_, 0, 0});
      for (const int side : {1, -1}) add_column(column, y, side, body);
      if (inner) body.children.push_back(std::move(*inner));
      inner = std::move(body);
    }
    if (inner) to.children.push_back(std::move(*inner));
  }

 private:
  MjcfElement made(int x, int y, const glm::dvec3& way) const {
    MjcfElement body = parts_.body(parts_.prefix + "B" + cell_name(x, y), way, kNoTurn);
    body.children.push_back(geom(x, y));
    body.children.push_back(parts_.site(parts_.prefix + "S" + cell_name(x, y), {}));
    add_hinges(parts_, cell_name(x, y), -way, way, body);
    return body;
  }

  const CompositeParts& parts_;
  const double spacing_;
};

}  // namespace

Result<void> expand_particles(const CompositeParts& parts, Composite& to) {
  if (Result<void> done = check(parts); !done) return done;
  const bool is_grid = parts.type == "grid";
  if (is_grid && parts.dimensions > 2) return Error{"a grid has one or two dimensions"};
  const glm::dvec3 offset = parts.from.vec3("offset").value_or(glm::dvec3(0));
  const glm::dvec3 counts(parts.count[0], parts.count[1], is_grid ? 0 : parts.count[2]);
  for (int x = 0; x < parts.count[0]; ++x)
    for (int y = 0; y < parts.count[1]; ++y)
      for (int z = 0; z < parts.count[2]; ++z) {
        const std::string name = is_grid ? cell_name(x, y) : std::string();
        const glm::dvec3 position = offset + spacing_of(parts) * (glm::dvec3(x, y, z) - 0.5 * counts);
        MjcfElement body = parts.body(is_grid ? parts.prefix + "B" + name : name, position, kNoTurn);
        body.children.push_back(
            parts.geom(is_grid ? parts.prefix + "G" + name : name, "sphere", parts.geom_size, {}, kNoTurn));
        if (is_grid) body.children.push_back(parts.site(parts.prefix + "S" + name, {}));
        if (!is_grid || !is_pinned(parts, x, y)) add_slides(parts, name, body);
        to.children.push_back(std::move(body));
      }
  if (parts.child("skin") && is_grid && parts.dimensions == 2) set_sheet(parts, to);
  return {};
}

Result<void> expand_rope(const CompositeParts& parts, Composite& to) {
  if (Result<void> done = check(parts); !done) return done;
  const std::vector<int> cell = root_cell(parts);
  if (parts.dimensions > 1) return Error{"a " + parts.type + " has one dimension"};
  if (cell.empty() || cell[0] < 0 || cell[0] >= parts.count[0])
    return Error{"the name of its body is not " + quote(parts.prefix + "B") +
                 " and a number below its count"};
  const double half = std::numbers::sqrt2 / 2, angle = 2 * std::numbers::pi / parts.count[0];
  const bool is_loop = parts.type == "loop";
  const auto geom = [&](int x) {
    return parts.geom(parts.prefix + "G" + std::to_string(x), parts.geom_type, parts.geom_size, {},
                      glm::dquat(half, 0, half, 0));
  };
  to.children.push_back(geom(cell[0]));
  for (const int step : {1, -1}) {
    const int last = step > 0 ? parts.count[0] - 1 : 0;
    const double way = step * spacing_of(parts);
    std::optional<MjcfElement> inner;
    for (int x = last; x != cell[0]; x -= step) {
      glm::dvec3 position(way, 0, 0);
      glm::dquat rotation = kNoTurn;
      if (is_loop) {
        const double radius =
            0.5 * spacing_of(parts) * std::sin(std::numbers::pi - angle) / std::sin(angle / 2);
        position = {step * radius * std::cos(angle / 2), radius * std::sin(angle / 2), 0};
        rotation = glm::angleAxis(step * angle, glm::dvec3(0, 0, 1));
      }
      MjcfElement body = parts.body(parts.prefix + "B" + std::to_string(x), position, rotation);
      body.children.push_back(geom(x));
      add_hinges(parts, std::to_string(x), {-0.5 * way, 0, 0}, {1, 0, 0}, body);
      if (inner) body.children.push_back(std::move(*inner));
      inner = std::move(body);
    }
    if (inner) to.children.push_back(std::move(*inner));
  }
  return {};
}

Result<void> expand_cloth(const CompositeParts& parts, Composite& to) {
  if (Result<void> done = check(parts); !done) return done;
  const std::vector<int> cell = root_cell(parts);
  if (parts.dimensions != 2) return Error{"a cloth has two dimensions"};
  if (cell.size() != 2 || cell[0] < 0 || cell[0] >= parts.count[0] || cell[1] < 0 ||
      cell[1] >= parts.count[1])
    return Error{"the name of its body is not " + quote(parts.prefix + "B") +
                 " and a cell of its grid, as in " + quote(parts.prefix + "B0_0")};
  const Cloth cloth(parts);
  MjcfElement root = parts.element("body", "");
  root.children.push_back(cloth.geom(cell[0], cell[1]));
  root.children.push_back(parts.site(parts.prefix + "S" + cell_name(cell[0], cell[1]), {}));
  for (const int step : {1, -1}) cloth.add_column(cell[0], cell[1], step, root);
  for (const int step : {1, -1}) cloth.add_row(cell[0], cell[1], step, root);
  to.children = std::move(root.children);
  if (parts.child("skin")) set_sheet(parts, to);
  return {};
}

Result<void> expand_shell(const CompositeParts& parts, Composite& to) {
  if (Result<void> done = check(parts); !done) return done;
  if (parts.dimensions != 3) return Error{"a " + parts.type + " has three dimensions"};
  const glm::dvec3 last = glm::dvec3(parts.count[0], parts.count[1], parts.count[2]) - 1.0,
                   half = 0.5 * spacing_of(parts) * last;
  to.children.push_back(
      parts.geom(parts.prefix + "Gcenter", "sphere", {2 * parts.geom_size.x, 0, 0}, {}, kNoTurn));
  for (int x = 0; x < parts.count[0]; ++x)
    for (int y = 0; y < parts.count[1]; ++y)
      for (int z = 0; z < parts.count[2]; ++z) {
        glm::dvec3 point = 2.0 * glm::dvec3(x, y, z) / last - 1.0;
        if (glm::max(std::abs(point.x), glm::max(std::abs(point.y), std::abs(point.z))) < 1 - 1e-9) continue;
        if (parts.type == "cylinder") {
          const double distance = std::max(std::abs(point.x), std::abs(point.y)),
                       length = std::hypot(point.x, point.y);
          if (length > 0) point = {point.x * distance / length, point.y * distance / length, point.z};
        } else if (parts.type == "ellipsoid") {
          point = glm::normalize(point);
        }
        point *= half;
        const std::string name = cell_name(x, y) + "_" + std::to_string(z);
        MjcfElement body =
            parts.body(parts.prefix + "B" + name, point, mjcf_z_rotation(point).value_or(kNoTurn));
        const bool is_capsule = parts.geom_type == "capsule";
        const double depth = parts.geom_size.x + (is_capsule ? parts.geom_size.y : 0);
        body.children.push_back(parts.geom(parts.prefix + "G" + name, is_capsule ? "capsule" : "sphere",
                                           parts.geom_size, {0, 0, -depth}, kNoTurn));
        body.children.push_back(parts.joint("slide", parts.prefix + "J" + name, {}, {0, 0, 1}));
        to.children.push_back(std::move(body));
      }
  return {};
}

}  // namespace fire3dv::convert
