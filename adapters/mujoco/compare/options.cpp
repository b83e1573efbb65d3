#include "adapters/mujoco/compare/options.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "adapters/mujoco/image_names.h"
#include "protocol/base/command_line.h"

namespace fire3dv::mujoco {

std::optional<CompareOptions> parse_compare_options(int argc, char** argv, int* exit_code) {
  CompareOptions options;
  std::string images = "free camera:640x480";
  CLI::App app{"Compares images and step times of FIRE-3DV and MuJoCo's offscreen renderer.",
               "fire3dv-mujoco-compare"};
  app.formatter(std::make_shared<HelpFormatter>("MODEL.xml --to URI [OPTIONS]"));
  app.set_help_flag("-h,--help", "print this help and exit");
  app.footer(
      "Exit status: 0 done, 1 error, 2 wrong usage, 77 no OpenGL without a display.\n"
      "Details: man fire3dv-mujoco-compare.");
  const auto add = [&](const char* name, auto& value, const char* type, const char* text, const char* group) {
    return app.add_option(name, value, text)->type_name(type)->group(group)->capture_default_str();
  };
  constexpr const char *kImages = "Images", *kSpeed = "Speed";
  app.add_option("model", options.model, "MJCF file")->required();
  app.add_option("--to", options.uri, "URI of a fire3dv --headless --on-request")
      ->type_name("URI")
      ->required();
  add("--timeout", options.timeout_s, "SECONDS", "limit of the wait for one image", "Options")
      ->check(number_between(0.1, 86400));
  add("--images", images, "CAMERA[:WxH]", "camera and image size", kImages);
  add("--frames", options.frames, "N", "compared images; with --speed, images per round", kImages)
      ->check(number_between(1, 1e6));
  CLI::Option* const speed =
      app.add_flag("--speed", options.speed, "time steps with images, alternately with MuJoCo")
          ->group(kSpeed);
  add("--every", options.every_s, "SECONDS", "simulated time between compared images", kImages)
      ->excludes(speed)
      ->check(check_number);
  bool no_reflections = false;
  app.add_flag("--no-reflections", no_reflections, "no reflections of MuJoCo's floors")->group(kImages);
  app.add_option("--pictures", options.pictures, "folder for both images side by side")
      ->excludes(speed)
      ->type_name("DIR")
      ->group(kImages);
  add("--blocks", options.blocks, "N", "rounds", kSpeed)->needs(speed)->check(number_between(1, 1e6));
  add("--samples", options.view.samples, "N", "MuJoCo's samples per pixel", kSpeed)
      ->needs(speed)
      ->check(number_between(0, 16));
  add("--shadow-texels", options.view.shadow_texels, "N", "side of MuJoCo's shadow maps; 0: no shadows",
      kSpeed)
      ->needs(speed)
      ->check(number_between(0, 16384));
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
