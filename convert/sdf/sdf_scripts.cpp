// Colours of the materials of Gazebo Classic, which worlds name in <script>.
#include <algorithm>
#include <iterator>
#include <string_view>

#include "convert/sdf/sdf_materials.h"

namespace fire3dv::convert {
namespace {

struct Script {
  std::string_view name;  // without "Gazebo/"
  float r, g, b;
  bool glows = false;
};

constexpr Script kScripts[] = {
    {"Black", 0, 0, 0},
    {"BlackTransparent", 0, 0, 0},
    {"Blue", 0, 0, 1},
    {"BlueGlow", 0, 0, 1, true},
    {"BlueLaser", 0, 0, 1},
    {"BlueTransparent", 0, 0, 1},
    {"DarkGray", 0.175f, 0.175f, 0.175f},
    {"DarkGrey", 0.175f, 0.175f, 0.175f},
    {"DarkMagentaTransparent", 0.6f, 0, 0.6f},
    {"DarkYellow", 0.7f, 0.7f, 0},
    {"FlatBlack", 0.1f, 0.1f, 0.1f},
    {"Gold", 0.8f, 0.64869f, 0.120759f},
    {"Gray", 0.7f, 0.7f, 0.7f},
    {"Green", 0, 1, 0},
    {"GreenGlow", 0, 1, 0, true},
    {"GreenTransparent", 0, 1, 0},
    {"Grey", 0.7f, 0.7f, 0.7f},
    {"GreyTransparent", 0.5f, 0.5f, 0.5f},
    {"Indigo", 0.33f, 0, 0.5f},
    {"LightBlueLaser", 0.5f, 0.5f, 1},
    {"LightOff", 1, 0, 0, true},
    {"LightOn", 0, 1, 0, true},
    {"Orange", 1, 0.5088f, 0.0468f},
    {"OrangeTransparent", 1, 0.44f, 0},
    {"Purple", 1, 0, 1},
    {"PurpleGlow", 1, 0, 1, true},
    {"Red", 1, 0, 0},
    {"RedBright", 0.87f, 0.26f, 0.07f},
    {"RedGlow", 1, 0, 0, true},
    {"SkyBlue", 0, 0, 1},
    {"Turquoise", 0, 1, 1},
    {"TurquoiseGlow", 0, 1, 1, true},
    {"White", 1, 1, 1},
    {"WhiteGlow", 1, 1, 1, true},
    {"Yellow", 1, 1, 0},
    {"YellowGlow", 1, 1, 0, true},
    {"YellowTransparent", 1, 1, 0},
    {"ZincYellow", 0.9725f, 0.9529f, 0.2078f},
};

}  // namespace

std::optional<SdfScriptColors> sdf_script_colors(const std::string& name) {
  constexpr std::string_view kPrefix = "Gazebo/";
  std::string_view rest = name;
  if (!rest.starts_with(kPrefix)) return std::nullopt;
  rest.remove_prefix(kPrefix.size());
  const auto* const known = std::ranges::find(kScripts, rest, &Script::name);
  if (known == std::end(kScripts)) return std::nullopt;
  const glm::vec3 color(known->r, known->g, known->b);
  return SdfScriptColors{glm::vec4(color, 1), known->glows ? color : glm::vec3(0)};
}

}  // namespace fire3dv::convert
