#include <algorithm>
#include <cctype>
#include <cstdio>

#include "renderer/gui/panels.h"

namespace fire3dv::gui {

std::string grouped(uint64_t number) {
  std::string text = std::to_string(number);
  for (size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, " ");
  return text;
}

std::string short_number(double number) {
  constexpr const char* kUnits[] = {"", " k", " M", " G"};
  size_t unit = 0;
  while (number >= 999.5 && unit + 1 < std::size(kUnits)) {
    number /= 1000;
    ++unit;
  }
  char text[48];
  std::snprintf(text, sizeof text,
                unit == 0        ? "%.0f%s"
                : number < 99.95 ? "%.1f%s"
                                 : "%.0f%s",
                number, kUnits[unit]);
  return text;
}

std::string bytes_text(uint64_t bytes) {
  constexpr const char* kUnits[] = {"B", "KiB", "MiB", "GiB", "TiB"};
  double number = static_cast<double>(bytes);
  size_t unit = 0;
  while (number >= 1000 && unit + 1 < std::size(kUnits)) {
    number /= 1024;
    ++unit;
  }
  char text[48];
  std::snprintf(text, sizeof text, unit == 0 || number >= 99.95 ? "%.0f %s" : "%.1f %s", number,
                kUnits[unit]);
  return text;
}

bool contains_no_case(std::string_view text, std::string_view wanted) {
  const auto same = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
  };
  return std::search(text.begin(), text.end(), wanted.begin(), wanted.end(), same) != text.end();
}

std::string node_label(const scene::Scene& scene, uint32_t node) {
  if (node >= scene.nodes.size()) return "-";
  const scene::Node& n = scene.nodes[node];
  if (!n.name.empty()) return n.name;
  const char* kind = n.camera != scene::kNone  ? "camera"
                     : n.light != scene::kNone ? "light"
                     : n.mesh != scene::kNone  ? "mesh"
                                               : "node";
  return std::string(kind) + " " + std::to_string(node);
}

}  // namespace fire3dv::gui
