#include "convert/mjcf/deformable/composite_parts.h"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace fire3dv::convert {
namespace {

std::string text_of(std::initializer_list<double> numbers) {
  std::string text;
  for (const double number : numbers) {
    char digits[40];
    std::snprintf(digits, sizeof digits, "%.17g", number);
    text += (text.empty() ? "" : " ") + std::string(digits);
  }
  return text;
}

std::string text_of(const glm::dvec3& v) {
  return text_of({v.x, v.y, v.z});
}

std::string text_of(const glm::dquat& q) {
  return text_of({q.w, q.x, q.y, q.z});
}

}  // namespace

CompositeParts::CompositeParts(const MjcfAttributes& attributes, std::string body)
    : from(attributes), parent(std::move(body)), prefix(from.text("prefix")), type(from.text("type")) {
  const std::vector<double> counts = mjcf_numbers(from.text("count"), 3);
  for (size_t k = 0; k < counts.size(); ++k) count[k] = static_cast<int>(std::clamp(counts[k], -1.0, 1e6));
  const MjcfElement* const geom = child("geom");
  geom_type = geom ? geom->text("type") : std::string();
  if (geom_type.empty()) geom_type = "sphere";
  const std::vector<double> sizes = geom ? mjcf_numbers(geom->text("size"), 3) : std::vector<double>();
  for (size_t k = 0; k < sizes.size(); ++k) geom_size[static_cast<int>(k)] = sizes[k];
}

MjcfElement CompositeParts::element(const char* kind, const std::string& name) const {
  MjcfElement made;
  made.kind = kind;
  made.file = from.element().file;
  made.line = from.element().line;
  if (!name.empty()) made.attributes.emplace_back("name", name);
  return made;
}

MjcfElement CompositeParts::body(const std::string& name, const glm::dvec3& position,
                                 const glm::dquat& rotation) const {
  MjcfElement made = element("body", name);
  made.attributes.emplace_back("pos", text_of(position));
  made.attributes.emplace_back("quat", text_of(rotation));
  return made;
}

MjcfElement CompositeParts::geom(const std::string& name, const std::string& shape, const glm::dvec3& size,
                                 const glm::dvec3& position, const glm::dquat& rotation) const {
  MjcfElement made = element("geom", name);
  const MjcfElement* const own = child("geom");
  const auto copy = [&](const char* attribute, const char* otherwise) {
    const std::string* const given = own ? own->find(attribute) : nullptr;
    if (given || otherwise) made.attributes.emplace_back(attribute, given ? *given : otherwise);
  };
  // Values without a default class: that of the body does not count.
  made.attributes.emplace_back("type", shape);
  made.attributes.emplace_back("size", text_of(size));
  made.attributes.emplace_back("pos", text_of(position));
  made.attributes.emplace_back("quat", text_of(rotation));
  copy("rgba", ".5 .5 .5 1");
  copy("material", "");
  copy("density", "1000");
  copy("mass", nullptr);
  copy("contype", "1");
  copy("conaffinity", "1");
  copy("group", shows_geoms ? "0" : "3");
  return made;
}

MjcfElement CompositeParts::joint(const char* kind, const std::string& name, const glm::dvec3& position,
                                  const glm::dvec3& axis) const {
  MjcfElement made = element("joint", name);
  made.attributes.emplace_back("type", kind);
  made.attributes.emplace_back("pos", text_of(position));
  made.attributes.emplace_back("axis", text_of(axis));
  made.attributes.emplace_back("ref", "0");
  return made;
}

MjcfElement CompositeParts::site(const std::string& name, const glm::dvec3& position) const {
  MjcfElement made = element("site", name);
  made.attributes.emplace_back("pos", text_of(position));
  return made;
}

bool CompositeParts::has_joint(const char* kind) const {
  const auto& children = from.element().children;
  return std::any_of(children.begin(), children.end(), [&](const MjcfElement& each) {
    return each.kind == "joint" && each.text("kind") == kind;
  });
}

const MjcfElement* CompositeParts::child(const char* kind) const {
  for (const MjcfElement& each : from.element().children)
    if (each.kind == kind) return &each;
  return nullptr;
}

SkinData sheet_skin(int columns, int rows, const std::vector<SheetBone>& bones) {
  SkinData skin;
  const auto side = static_cast<uint32_t>(bones.size());
  for (uint32_t back = 0; back < 2; ++back)
    for (uint32_t i = 0; i < side; ++i) {
      skin.vertices.emplace_back(0);
      skin.uvs.emplace_back(
          static_cast<float>(i / static_cast<uint32_t>(rows)) / static_cast<float>(columns - 1),
          static_cast<float>(i % static_cast<uint32_t>(rows)) / static_cast<float>(rows - 1));
    }
  for (uint32_t i = 0; i < side; ++i)
    skin.bones.push_back({bones[i].body, -bones[i].position, {1, 0, 0, 0}, {i, side + i}, {1, 1}});
  const auto at = [&](int x, int y, bool is_back) {
    return static_cast<uint32_t>(x * rows + y) + (is_back ? side : 0);
  };
  const auto quad = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    skin.faces.push_back({a, b, c});
    skin.faces.push_back({a, c, d});
  };
  for (int x = 0; x + 1 < columns; ++x)
    for (int y = 0; y + 1 < rows; ++y) {
      quad(at(x, y, false), at(x + 1, y, false), at(x + 1, y + 1, false), at(x, y + 1, false));
      quad(at(x, y, true), at(x, y + 1, true), at(x + 1, y + 1, true), at(x + 1, y, true));
    }
  const int right = columns - 1, top = rows - 1;
  for (int x = 0; x < right; ++x) {
    quad(at(x, 0, false), at(x, 0, true), at(x + 1, 0, true), at(x + 1, 0, false));
    quad(at(x, top, false), at(x + 1, top, false), at(x + 1, top, true), at(x, top, true));
  }
  for (int y = 0; y < top; ++y) {
    quad(at(0, y, false), at(0, y + 1, false), at(0, y + 1, true), at(0, y, true));
    quad(at(right, y, false), at(right, y, true), at(right, y + 1, true), at(right, y + 1, false));
  }
  return skin;
}

}  // namespace fire3dv::convert
