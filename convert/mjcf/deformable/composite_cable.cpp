// Cables: chains of bodies with ball joints along a curve.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "convert/mjcf/deformable/composite_parts.h"

#include "base/text.h"

namespace fire3dv::convert {
namespace {

constexpr size_t kMaxCableVertices = 1001;
constexpr double kMinCableLength = 1e-14;

Result<std::vector<glm::dvec3>> curve_of(const CompositeParts& parts) {
  std::istringstream words(parts.from.text("curve"));
  std::vector<std::string> curves;
  for (std::string word; words >> word;) curves.push_back(word);
  if (curves.size() > 3) return Error{"its curve has more than three components"};
  for (const std::string& curve : curves)
    if (curve != "s" && curve != "cos(s)" && curve != "sin(s)" && curve != "0")
      return Error{"its curve " + quote(curve) + " is none of s, cos(s), sin(s) and 0"};
  glm::dvec3 size(1, 0, 0);
  const std::vector<double> sizes = mjcf_numbers(parts.from.text("size"), 3);
  for (size_t k = 0; k < sizes.size(); ++k) size[static_cast<int>(k)] = sizes[k];
  const glm::dvec4 q = parts.from.vec4("quat").value_or(glm::dvec4(1, 0, 0, 0));
  const glm::dquat rotation = glm::length(q) > kMinCableLength
                                  ? glm::normalize(glm::dquat(q.x, q.y, q.z, q.w))
                                  : glm::dquat(1, 0, 0, 0);
  std::vector<glm::dvec3> points;
  for (int i = 0; i < parts.count[0]; ++i) {
    const double share = static_cast<double>(i) / (parts.count[0] - 1);
    const double angle = std::numbers::pi * share * size[2];
    glm::dvec3 point(0);
    for (size_t k = 0; k < curves.size(); ++k) {
      double& to = point[static_cast<int>(k)];
      if (curves[k] == "s") to = share * size[0];
      if (curves[k] == "cos(s)") to = size[1] * std::cos(angle);
      if (curves[k] == "sin(s)") to = size[1] * std::sin(angle);
    }
    points.push_back(rotation * point);
  }
  return points;
}

Result<std::vector<glm::dvec3>> vertices_of(const CompositeParts& parts) {
  const std::string text = parts.from.text("vertex");
  if (text.empty() && parts.count[0] < 2) return Error{"its count is less than 2"};
  if (text.empty() && static_cast<size_t>(parts.count[0]) > kMaxCableVertices)
    return Error{"it has more than " + std::to_string(kMaxCableVertices) + " vertices"};
  if (text.empty()) return curve_of(parts);
  const std::vector<double> numbers = mjcf_numbers(text, 3 * kMaxCableVertices + 1);
  if (numbers.size() % 3 != 0 || numbers.size() < 6 || !is_mjcf_numbers(text, 3 * kMaxCableVertices + 1))
    return Error{"vertex is not three numbers for each of 2 to " + std::to_string(kMaxCableVertices) +
                 " vertices"};
  std::vector<glm::dvec3> points;
  for (size_t i = 0; i < numbers.size(); i += 3)
    points.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
  return points;
}

// Frames along a polygon without twist: X along each edge.
std::vector<glm::dquat> frames_of(const std::vector<glm::dvec3>& points) {
  std::vector<glm::dquat> frames;
  glm::dvec3 normal(0, 1, 0), before(0);
  for (size_t i = 0; i + 1 < points.size(); ++i) {
    const glm::dvec3 tangent = glm::normalize(points[i + 1] - points[i]);
    glm::dvec3 binormal(0);
    if (i == 0) {
      if (points.size() > 2) binormal = glm::cross(tangent, glm::normalize(points[2] - points[1]));
      if (glm::length(binormal) < 1e-7)  // straight
        binormal =
            glm::cross(tangent, std::abs(tangent.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(-1, 0, 0));
      normal = glm::normalize(glm::cross(glm::normalize(binormal), tangent));
    } else {
      const glm::dvec3 axis = glm::cross(before, tangent);
      const double sine = glm::length(axis);
      if (sine > kMinCableLength)
        normal = glm::angleAxis(std::atan2(sine, glm::dot(before, tangent)), axis / sine) * normal;
      normal = glm::normalize(normal - tangent * glm::dot(tangent, normal));
    }
    frames.push_back(glm::quat_cast(glm::dmat3(tangent, normal, glm::cross(tangent, normal))));
    before = tangent;
  }
  return frames;
}

void add_skin(const CompositeParts& parts, const std::vector<std::string>& names, Composite& to) {
  const size_t bodies = names.size();
  std::vector<SheetBone> bones;
  for (size_t i = 0; i <= bodies; ++i)
    for (const double side : {-1.0, 1.0}) {
      const double end = i == bodies ? 2 * parts.geom_size.x : 0;
      bones.push_back({names[std::min(i, bodies - 1)], {end, side * parts.geom_size.y, 0}});
    }
  to.skin = sheet_skin(static_cast<int>(bodies) + 1, 2, bones);
  to.inflation = 2 * parts.geom_size.z;
}

}  // namespace

Result<void> expand_cable(const CompositeParts& parts, Composite& to) {
  const std::string& shape = parts.geom_type;
  if (shape != "capsule" && shape != "cylinder" && shape != "box")
    return Error{"a cable needs a geom of the type capsule, cylinder or box"};
  const Result<std::vector<glm::dvec3>> points = vertices_of(parts);
  if (!points) return points.error();
  for (size_t i = 0; i + 1 < points->size(); ++i)
    if (!(glm::distance((*points)[i], (*points)[i + 1]) > kMinCableLength))
      return Error{"two of its vertices are equal"};
  const std::vector<glm::dquat> frames = frames_of(*points);
  const std::string initial = parts.from.text("initial");
  const size_t bodies = frames.size();
  std::vector<std::string> names;
  for (size_t i = 0; i < bodies; ++i)
    names.push_back(parts.prefix + (i == 0            ? "B_first"
                                    : i + 1 == bodies ? "B_last"
                                                      : "B_" + std::to_string(i)));
  std::optional<MjcfElement> inner;
  for (size_t i = bodies; i-- > 0;) {
    const double length = glm::distance((*points)[i], (*points)[i + 1]);
    const bool is_first = i == 0, is_last = i + 1 == bodies;
    MjcfElement body =
        is_first ? parts.body(names[i], (*points)[0] + parts.from.vec3("offset").value_or(glm::dvec3(0)),
                              frames[0])
                 : parts.body(names[i], {glm::distance((*points)[i - 1], (*points)[i]), 0, 0},
                              glm::conjugate(frames[i - 1]) * frames[i]);
    const glm::dquat z_to_x = *mjcf_z_rotation({-1, 0, 0});
    const std::string name = parts.prefix + "G" + std::to_string(i);
    if (shape == "box")
      body.children.push_back(parts.geom(name, shape, {length / 2, parts.geom_size.y, parts.geom_size.z},
                                         {length / 2, 0, 0}, {1, 0, 0, 0}));
    else
      body.children.push_back(
          parts.geom(name, shape, {parts.geom_size.x, length / 2, 0}, {length / 2, 0, 0}, z_to_x));
    const std::string joint = parts.prefix + "J" +
                              (is_first  ? "_first"
                               : is_last ? "_last"
                                         : "_" + std::to_string(i));
    if (!is_first || initial != "none")
      body.children.push_back(
          parts.joint(is_first && initial == "free" ? "free" : "ball", joint, {}, {0, 0, 1}));
    if (is_first || is_last)
      body.children.push_back(
          parts.site(parts.prefix + (is_last ? "S_last" : "S_first"), {is_last ? length : 0, 0, 0}));
    if (inner) body.children.push_back(std::move(*inner));
    inner = std::move(body);
  }
  to.children.push_back(std::move(*inner));
  if (shape == "box") add_skin(parts, names, to);
  return {};
}

}  // namespace fire3dv::convert
