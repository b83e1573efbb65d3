#include "adapters/mujoco/compare/options.h"

#include <CLI/CLI.hpp>
#include <iostream>

#include "adapters/mujoco/image_names.h"
#include "protocol/base/command_line.h"

namespace fire3dv::mujoco {

std::optional<CompareOptions> parse_compare_options(int argc, char** argv, int* exit_code) {
  CompareOptions options;
  std::string images = "free camera:640x480";
  CLI::App app{
      "Draws a MuJoCo model by MuJoCo's own offscreen renderer and by a FIRE-3DV that shows the model's "
      "scene\n"
      "(fire3dv-mujoco MODEL --scene), and says in a line of a Markdown table how far they agree, or how "
      "long\n"
      "they take. Exit code: 0 done, 1 error, 2 wrong usage, 77 OpenGL without a display is not to be had.",
      "fire3dv-mujoco-compare"};
  app.add_option("model", options.model, "The model, an MJCF file")->required();
  app.add_option("--to", options.uri, "Where FIRE-3DV listens, with --headless --on-request")
      ->type_name("URI")
      ->required();
  app.add_option("--images", images, "Which camera, and the images' size")
      ->type_name("CAMERA[:WxH]")
      ->capture_default_str();
  CLI::Option* const speed = app.add_flag(
      "--speed", options.speed,
      "Time a step with colour, depth and labels in lockstep, in turns; else report how far both agree");
  app.add_option("--frames", options.frames, "How many images to compare; with --speed, in each turn")
      ->check(number_between(1, 1e6))
      ->capture_default_str();
  app.add_option("--blocks", options.blocks, "With --speed: how many turns")
      ->needs(speed)
      ->check(number_between(1, 1e6))
      ->capture_default_str();
  app.add_option("--every", options.every_s, "Simulated seconds between images that are compared")
      ->excludes(speed)
      ->check(check_number)
      ->capture_default_str();
  app.add_option("--samples", options.view.samples, "MuJoCo's samples a pixel, with --speed")
      ->needs(speed)
      ->check(number_between(0, 16))
      ->capture_default_str();
  app.add_option("--shadow-texels", options.view.shadow_texels,
                 "Side of MuJoCo's shadow maps, with --speed; 0: no shadows. MuJoCo's own default is 4096")
      ->needs(speed)
      ->check(number_between(0, 16384))
      ->capture_default_str();
  bool no_reflections = false;
  app.add_flag("--no-reflections", no_reflections, "MuJoCo's floors do not reflect");
  app.add_option("--pictures", options.pictures, "Folder for both renderers' pictures, side by side")
      ->excludes(speed)
      ->type_name("DIR");
  app.add_option("--timeout", options.timeout_s, "Seconds to wait for one image")
      ->check(number_between(0.1, 86400))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
    const Result<ImageSpec> spec = image_spec(images);
    if (!spec) throw CLI::ValidationError("--images", spec.error().message);
    options.view.camera = spec->camera;
    options.view.width = spec->width;
    options.view.height = spec->height;
    options.view.reflections = !no_reflections;
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error, std::cout, std::cerr) == 0 ? 0 : 2;
    return std::nullopt;
  }
  return options;
}

}  // namespace fire3dv::mujoco
