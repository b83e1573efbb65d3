// Elements and values of 3MF's XML: names without namespaces, numbers, colours and transforms.
#pragma once

#include <tinyxml2.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "base/error.h"
#include "base/text.h"

namespace fire3dv::convert {

using tinyxml2::XMLElement;

// Names without the prefix of their namespace, which files choose.
inline std::string_view local_name(const char* name) {
  const std::string_view text(name);
  const size_t colon = text.find(':');
  return colon == std::string_view::npos ? text : text.substr(colon + 1);
}

inline bool is(const XMLElement& element, std::string_view name) {
  return local_name(element.Name()) == name;
}

inline std::optional<std::string> attribute(const XMLElement& element, std::string_view name) {
  for (const tinyxml2::XMLAttribute* a = element.FirstAttribute(); a; a = a->Next())
    if (local_name(a->Name()) == name) return a->Value();
  return std::nullopt;
}

// Calls visit(child) for each child of that name until it returns an error.
template <typename Visit>
Result<void> each(const XMLElement* parent, std::string_view name, Visit&& visit) {
  const XMLElement* child = parent ? parent->FirstChildElement() : nullptr;
  for (; child; child = child->NextSiblingElement()) {
    if (!is(*child, name)) continue;
    if (Result<void> done = visit(*child); !done) return done;
  }
  return {};
}

inline const XMLElement* child_of(const XMLElement& parent, std::string_view name) {
  const XMLElement* child = parent.FirstChildElement();
  while (child && !is(*child, name)) child = child->NextSiblingElement();
  return child;
}

inline Error at_line(const XMLElement& element, const std::string& why) {
  return Error{"line " + std::to_string(element.GetLineNum()) + ", <" +
               std::string(local_name(element.Name())) + ">: " + why};
}

inline std::optional<double> number(const std::string& text) {
  double value = 0;
  const size_t first = std::min(text.find_first_not_of(" \t\r\n+"), text.size());
  const auto [end, error] = std::from_chars(text.data() + first, text.data() + text.size(), value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  return value;
}

inline std::optional<uint32_t> index_of(const XMLElement& element, std::string_view name) {
  const std::optional<std::string> text = attribute(element, name);
  uint32_t value = 0;
  if (!text || std::from_chars(text->data(), text->data() + text->size(), value).ec != std::errc())
    return std::nullopt;
  return value;
}

// #RRGGBB or #RRGGBBAA, displayed (sRGB).
inline std::optional<glm::vec4> color_of(const XMLElement& element, std::string_view name) {
  const std::optional<std::string> text = attribute(element, name);
  if (!text || !text->starts_with('#') || (text->size() != 7 && text->size() != 9)) return std::nullopt;
  glm::vec4 color(1);
  for (size_t i = 1; i < text->size(); i += 2) {
    unsigned value = 0;
    const char* const first = text->data() + i;
    if (std::from_chars(first, first + 2, value, 16).ptr != first + 2) return std::nullopt;
    color[static_cast<int>(i / 2)] = static_cast<float>(value) / 255;
  }
  return color;
}

inline Result<glm::dmat4> transform_of(const XMLElement& element) {
  glm::dmat4 matrix(1);
  const std::optional<std::string> text = attribute(element, "transform");
  if (!text) return matrix;
  // Twelve numbers; row vectors are multiplied from the left, so that rows are columns here.
  const char* at = text->data();
  const char* const end = at + text->size();
  for (int i = 0; i < 12; ++i) {
    while (at < end && (*at == ' ' || *at == '\t' || *at == '\n' || *at == '\r')) ++at;
    const auto [next, error] = std::from_chars(at, end, matrix[i / 3][i % 3]);
    if (error != std::errc() || !std::isfinite(matrix[i / 3][i % 3]))
      return at_line(element, "its transform is not made of twelve numbers");
    at = next;
  }
  return matrix;
}

}  // namespace fire3dv::convert
