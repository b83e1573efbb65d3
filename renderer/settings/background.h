// Background of pixels without geometry.
#pragma once

#include <glm/glm.hpp>
#include <optional>

namespace fire3dv::settings {

// Colours are linear and shown as they are: without exposure and tone mapping.
struct Background {
  bool show_environment = false;         // the environment image instead of the colours
  glm::vec3 color{0.16f, 0.18f, 0.21f};  // towards the ground and the horizon
  std::optional<glm::vec3> zenith;       // overhead; nullopt: the same colour
  bool show_sky = false;                 // the scene's sky instead of the colours, if it has one

  bool operator==(const Background&) const = default;
  static Background gradient();
  static Background automatic();  // the scene's sky, else the gradient: the default of the programs
};

}  // namespace fire3dv::settings
