#include "convert/mjcf/xml/mjcf_attributes.h"

#include <charconv>
#include <cmath>
#include <numbers>
#include <utility>

#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

constexpr std::string_view kXmlBlanks = " \t\r\n";
constexpr double kMinVectorLength = 1e-14;

// Parses numbers and returns how much of the text they are.
size_t parse_numbers(std::string_view text, size_t most, std::vector<double>& to) {
  size_t at = 0;
  while (to.size() < most) {
    const size_t begin = text.find_first_not_of(kXmlBlanks, at);
    if (begin == text.npos) return text.size();
    const char* from = text.data() + begin + (text[begin] == '+' ? 1 : 0);
    double value = 0;
    const auto [end, error] = std::from_chars(from, text.data() + text.size(), value);
    if (error != std::errc() || !std::isfinite(value)) return begin;
    at = static_cast<size_t>(end - text.data());
    if (at < text.size() && kXmlBlanks.find(text[at]) == kXmlBlanks.npos) return begin;
    to.push_back(value);
  }
  const size_t rest = text.find_first_not_of(kXmlBlanks, at);
  return rest == text.npos ? text.size() : rest;
}

std::optional<glm::dquat> frame_quat(glm::dvec3 x, glm::dvec3 y) {
  if (glm::length(x) < kMinVectorLength) return std::nullopt;
  x = glm::normalize(x);
  y -= x * glm::dot(x, y);
  if (glm::length(y) < kMinVectorLength) return std::nullopt;
  y = glm::normalize(y);
  return glm::quat_cast(glm::dmat3(x, y, glm::cross(x, y)));
}

}  // namespace

double MjcfCompiler::radians(double angle) const {
  return degrees ? angle * std::numbers::pi / 180 : angle;
}

glm::dquat mjcf_euler_rotation(const glm::dvec3& angles, const MjcfCompiler& compiler) {
  glm::dquat all(1, 0, 0, 0);
  for (int i = 0; i < 3; ++i) {
    const char letter = compiler.euler_sequence[static_cast<size_t>(i)];
    const bool is_fixed = letter >= 'A' && letter <= 'Z';
    glm::dvec3 axis(0);
    axis[is_fixed ? letter - 'X' : letter - 'x'] = 1;
    const glm::dquat turn = glm::angleAxis(compiler.radians(angles[i]), axis);
    all = is_fixed ? turn * all : all * turn;
  }
  return all;
}

std::vector<double> mjcf_numbers(std::string_view text, size_t most) {
  std::vector<double> numbers;
  parse_numbers(text, most, numbers);
  return numbers;
}

bool is_mjcf_numbers(std::string_view text, size_t most) {
  std::vector<double> numbers;
  return parse_numbers(text, most, numbers) == text.size();
}

void MjcfDefaults::read(const MjcfElement& section, MjcfMessages& messages) {
  const std::string name = section.text("class");
  if (!name.empty()) by_name_.emplace(name, kMain);  // older models rename the main class
  read_class(section, kMain, messages);
}

void MjcfDefaults::read_class(const MjcfElement& section, size_t index, MjcfMessages& messages) {
  for (const MjcfElement& child : section.children) {
    if (child.kind != "default") {
      const auto [known, is_new] = classes_[index].elements.emplace(child.kind, child);
      if (is_new) continue;
      std::vector<std::pair<std::string, std::string>> attributes = child.attributes;  // the first one counts
      attributes.insert(attributes.end(), known->second.attributes.begin(), known->second.attributes.end());
      known->second.attributes = std::move(attributes);
      continue;
    }
    const std::string name = child.text("class");
    if (name.empty()) {
      messages.warn(child.where() + ": a nested class without a name is ignored: add the attribute class");
      continue;
    }
    const auto [known, is_new] = by_name_.emplace(name, classes_.size());
    if (is_new) classes_.push_back({index, {}});
    read_class(child, known->second, messages);
  }
}

std::optional<size_t> MjcfDefaults::find(std::string_view name) const {
  const auto known = by_name_.find(name);
  if (known == by_name_.end()) return std::nullopt;
  return known->second;
}

std::vector<const MjcfElement*> MjcfDefaults::chain(size_t index, std::string_view kind) const {
  std::vector<const MjcfElement*> found;
  for (;; index = classes_[index].parent) {
    const auto& elements = classes_[index].elements;
    if (const auto element = elements.find(kind); element != elements.end())
      found.push_back(&element->second);
    if (index == classes_[index].parent) return found;
  }
}

MjcfAttributes::MjcfAttributes(const MjcfElement& element, const MjcfDefaults& defaults, size_t class_index,
                               MjcfMessages& messages, std::string_view default_kind)
    : element_(element), layers_{&element}, messages_(messages) {
  const auto inherited = defaults.chain(class_index, default_kind.empty() ? element.kind : default_kind);
  layers_.insert(layers_.end(), inherited.begin(), inherited.end());
}

const std::string* MjcfAttributes::find(std::string_view name) const {
  for (const MjcfElement* layer : layers_)
    if (const std::string* value = layer->find(name)) return value;
  return nullptr;
}

std::string MjcfAttributes::text(std::string_view name) const {
  const std::string* const value = find(name);
  return value ? *value : std::string();
}

std::optional<std::vector<double>> MjcfAttributes::parse(std::string_view name, const std::string& text,
                                                         size_t count) const {
  std::vector<double> values;
  if (parse_numbers(text, count, values) == text.size() && values.size() == count) return values;
  warn(std::string(name) + "=" + quote(text.substr(0, 100)) + " is not " +
       (count == 1 ? "a number" : std::to_string(count) + " numbers") + "; its default is used");
  return std::nullopt;
}

std::optional<std::vector<double>> MjcfAttributes::numbers(std::string_view name, size_t count) const {
  const std::string* const text = find(name);
  return text ? parse(name, *text, count) : std::nullopt;
}

std::optional<double> MjcfAttributes::number(std::string_view name) const {
  const auto values = numbers(name, 1);
  return values ? std::optional((*values)[0]) : std::nullopt;
}

int MjcfAttributes::integer(std::string_view name, int otherwise) const {
  const std::optional<double> value = number(name);
  if (!value || std::abs(*value) > 2e9) return otherwise;
  return static_cast<int>(*value);
}

bool MjcfAttributes::flag(std::string_view name, bool otherwise) const {
  const std::string* const value = find(name);
  if (!value) return otherwise;
  if (*value == "true" || *value == "false") return *value == "true";
  warn(std::string(name) + "=" + quote(*value) + " is neither true nor false; its default is used");
  return otherwise;
}

std::optional<glm::dvec2> MjcfAttributes::vec2(std::string_view name) const {
  const auto v = numbers(name, 2);
  return v ? std::optional(glm::dvec2((*v)[0], (*v)[1])) : std::nullopt;
}

std::optional<glm::dvec3> MjcfAttributes::vec3(std::string_view name) const {
  const auto v = numbers(name, 3);
  return v ? std::optional(glm::dvec3((*v)[0], (*v)[1], (*v)[2])) : std::nullopt;
}

std::optional<glm::dvec4> MjcfAttributes::vec4(std::string_view name) const {
  const auto v = numbers(name, 4);
  return v ? std::optional(glm::dvec4((*v)[0], (*v)[1], (*v)[2], (*v)[3])) : std::nullopt;
}

glm::dvec3 MjcfAttributes::size(const glm::dvec3& otherwise) const {
  glm::dvec3 size = otherwise;
  for (auto layer = layers_.rbegin(); layer != layers_.rend(); ++layer) {
    const std::string* const text = (*layer)->find("size");
    if (!text) continue;
    std::vector<double> values;
    if (parse_numbers(*text, 3, values) != text->size())
      warn("size=" + quote(text->substr(0, 100)) + " is not one to three numbers");
    for (size_t i = 0; i < values.size(); ++i) size[static_cast<int>(i)] = values[i];
  }
  return size;
}

std::optional<glm::dquat> MjcfAttributes::alternative(const MjcfElement& from,
                                                      const MjcfCompiler& compiler) const {
  const auto values = [&](const char* name, size_t count) {
    const std::string* const text = from.find(name);
    return text ? parse(name, *text, count) : std::nullopt;
  };
  std::optional<glm::dquat> made;
  if (const auto v = values("axisangle", 4)) {
    const glm::dvec3 axis((*v)[0], (*v)[1], (*v)[2]);
    if (glm::length(axis) >= kMinVectorLength)
      made = glm::angleAxis(compiler.radians((*v)[3]), glm::normalize(axis));
    else
      warn("the axis of axisangle has no direction");
  } else if (const auto xy = values("xyaxes", 6)) {
    made = frame_quat({(*xy)[0], (*xy)[1], (*xy)[2]}, {(*xy)[3], (*xy)[4], (*xy)[5]});
    if (!made) warn("xyaxes spans no plane");
  } else if (const auto z = values("zaxis", 3)) {
    made = mjcf_z_rotation({(*z)[0], (*z)[1], (*z)[2]});
    if (!made) warn("zaxis has no direction");
  } else if (const auto e = values("euler", 3)) {
    made = mjcf_euler_rotation({(*e)[0], (*e)[1], (*e)[2]}, compiler);
  }
  return made;
}

glm::dquat MjcfAttributes::rotation(const MjcfCompiler& compiler) const {
  // An orientation of any kind replaces quat, also one of a default class, as in MuJoCo.
  for (const MjcfElement* layer : layers_)
    if (const auto made = alternative(*layer, compiler)) return *made;
  const std::optional<glm::dvec4> own = vec4("quat");
  if (!own) return {1, 0, 0, 0};
  if (glm::length(*own) < kMinVectorLength) return {1, 0, 0, 0};
  return glm::normalize(glm::dquat(own->x, own->y, own->z, own->w));
}

std::optional<glm::dquat> mjcf_z_rotation(const glm::dvec3& z) {
  if (glm::length(z) < kMinVectorLength) return std::nullopt;
  glm::dvec3 axis = glm::cross(glm::dvec3(0, 0, 1), glm::normalize(z));
  const double sine = glm::length(axis);
  axis = sine < 1e-10 ? glm::dvec3(1, 0, 0) : axis / sine;
  return glm::angleAxis(std::atan2(sine, glm::normalize(z).z), axis);
}

}  // namespace fire3dv::convert
