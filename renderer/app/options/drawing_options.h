// Options about the look of images, the same for all programs that draw.
#pragma once

#include <string>

#include "renderer/app/options/options.h"

namespace CLI {
class App;
}

namespace fire3dv::app {

constexpr const char* kDrawingGroup = "Drawing";

// Values that take_drawing_texts() converts after the whole command line is known.
struct DrawingTexts {
  std::string background, exposure = "auto", key_light = "auto";
  std::string shadows = "auto", shadow_rays = "hybrid", tone_map = "neutral", fxaa = "on",
              ray_effects = "off";
};

// Both arguments outlive the parsing.
void add_drawing_options(CLI::App& app, Options& options, DrawingTexts& texts);
// Returns an error message for invalid values, else an empty text.
std::string take_drawing_texts(const DrawingTexts& texts, Options& options);

}  // namespace fire3dv::app
