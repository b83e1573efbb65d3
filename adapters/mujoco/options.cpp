#include "adapters/mujoco/options.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <map>

#include "adapters/mujoco/image_names.h"
#include "tools/check_number.h"

namespace fire3dv::mujoco {

std::optional<Options> parse_options(int argc, char** argv, int* exit_code) {
  Options options;
  options.publish.rate_hz = 60;
  CLI::App app{
      "Steps a MuJoCo model and publishes what moves to FIRE-3DV renderers, which find the names in what\n"
      "fire3dv-convert makes of the same file, or in --scene. While it runs it takes lines on its standard\n"
      "input: pause, go, step, reset, quit. Exit code: 0 done or interrupted, 1 error, 2 wrong usage.",
      "fire3dv-mujoco"};
  app.add_option("model", options.model, "The model, an MJCF file")->required();
  app.add_option(
         "--to", options.publish.uris,
         "Where to publish: shm://NAME, tcp://HOST:PORT, tls://HOST:PORT or udp://HOST:PORT; repeatable")
      ->type_name("URI")
      ->allow_extra_args(false);
  app.add_option(
         "--scene", options.scene,
         "Write the model's scene first, each geom a node of its own; without --to, nothing else is done")
      ->type_name("OUT.glb");
  app.add_option("--package-path", options.package_folders,
                 "Folder that the model may read beside its own; may be given several times")
      ->type_name("DIR")
      ->allow_extra_args(false)
      ->check(CLI::ExistingDirectory);
  app.add_option("--rate", options.publish.rate_hz, "Frames a second of simulated time; 0: every step")
      ->check(check_number)
      ->capture_default_str();
  app.add_option("--speed", options.speed, "Simulated seconds a second; 0: as fast as can be")
      ->check(check_number)
      ->capture_default_str();
  app.add_option("--duration", options.duration_s, "Simulated seconds to run for; 0: until interrupted")
      ->check(check_number)
      ->capture_default_str();
  app.add_option("--key", options.keyframe,
                 "Begin at this keyframe, by name or number; default: the first, where there is one");
  const std::map<std::string, Drive> drives{
      {"hold", Drive::hold}, {"sin", Drive::sine}, {"zero", Drive::zero}};
  app.add_option(
         "--ctrl", options.drive,
         "What drives the actuators: hold (what the keyframe says), sin (each swings about that), zero")
      ->transform(CLI::CheckedTransformer(drives).description(""))
      ->type_name("hold|sin|zero")
      ->default_str("hold");
  app.add_flag("--paused", options.paused, "Begin paused, with one frame published");
  app.add_flag("--lockstep", options.lockstep,
               "Wait until a renderer has shown each frame, instead of keeping to the clock on the wall");
  app.add_option("--ack-timeout", options.ack_timeout_s, "Seconds that --lockstep waits for one image")
      ->check(number_between(0.1, 86400))
      ->capture_default_str();
  std::vector<std::string> cameras;
  std::string outputs = "color";
  app.add_option("--images", cameras,
                 "Ask the renderer of the first --to for what this camera sees of each frame; size 640x480 "
                 "where none is named; repeatable")
      ->type_name("CAMERA[:WxH]")
      ->allow_extra_args(false);
  app.add_option("--outputs", outputs,
                 "What these images hold: of color, linear, depth, instance, semantic, normal, motion, "
                 "boxes2d, boxes3d")
      ->type_name("NAME,NAME...")
      ->capture_default_str();
  app.add_option("--out", options.out, "Folder that gets them: PNG, .npy and a list")->type_name("DIR");
  const auto add_file = [&](const char* name, std::string& file, const char* help) {
    app.add_option(name, file, help)->type_name("FILE");
  };
  add_file("--key-file", options.publish.security.key_file, "File of the key that udp:// renderers ask for");
  add_file("--tls-ca", options.publish.security.tls_ca_file, "File of the certificates to trust for tls://");
  add_file("--tls-cert", options.publish.security.tls_certificate_file,
           "Own certificate, for tls:// renderers that ask for one");
  add_file("--tls-key", options.publish.security.tls_key_file, "File of that certificate's key");
  try {
    app.parse(argc, argv);
    if (options.publish.uris.empty() && options.scene.empty())
      throw CLI::ValidationError("--to", "name where to publish, or a file for the scene (--scene)");
    if (cameras.empty() != options.out.empty())
      throw CLI::ValidationError("--images", "goes together with a folder for them (--out DIR)");
    if (!cameras.empty() && options.publish.uris.empty())
      throw CLI::ValidationError("--images", "name the renderer that makes them (--to URI)");
    const Result<uint32_t> bits = image_outputs(outputs);
    if (!bits) throw CLI::ValidationError("--outputs", bits.error().message);
    for (const std::string& camera : cameras) {
      Result<ImageWish> wish = image_wish(camera);
      if (!wish) throw CLI::ValidationError("--images", wish.error().message);
      for (const ImageWish& other : options.images) {
        if (other.camera == wish->camera)
          throw CLI::ValidationError("--images", "the camera \"" + wish->camera + "\" stands there twice");
      }
      wish->outputs = *bits;
      options.images.push_back(std::move(*wish));
    }
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error, std::cout, std::cerr) == 0 ? 0 : 2;
    return std::nullopt;
  }
  return options;
}

}  // namespace fire3dv::mujoco
