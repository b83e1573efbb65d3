#include "adapters/mujoco/options.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <map>
#include <memory>

#include "base/command_line.h"
#include "base/numbers.h"
#include "base/text.h"
#include "protocol/wire/image_outputs.h"

namespace fire3dv::mujoco {

Result<uint32_t> image_outputs(std::string_view text) {
  uint32_t bits = 0;
  while (true) {
    const size_t comma = text.find(',');
    const std::string_view name = text.substr(0, comma);
    const wire::ImageOutputInfo* const info = wire::find_image_output(name);
    if (!info || (info->output & wire::kRequestableOutputs) == 0)
      return Error{quote(name) +
                   " is none of color, linear, depth, instance, semantic, normal, motion, boxes2d, boxes3d, "
                   "albedo, roughness, metallic, position, occlusion"};
    if (bits & info->output) return Error{quote(name) + " is given twice"};
    bits |= info->output;
    if (comma == text.npos) return bits;
    text.remove_prefix(comma + 1);
  }
}

Result<ImageSpec> image_spec(const std::string& text) {
  constexpr uint32_t kMaxSide = 8192;  // limit of SPEC.md section 13
  ImageSpec spec;
  spec.camera = text;
  const size_t colon = text.rfind(':');
  if (const auto size = parse_pair<uint32_t>(std::string_view(text).substr(colon + 1), 'x');
      colon != text.npos && size) {
    const auto [width, height] = *size;
    if (width == 0 || height == 0 || width > kMaxSide || height > kMaxSide)
      return Error{quote(text) + ": sides are 1 to " + std::to_string(kMaxSide) + " pixels"};
    spec.camera = text.substr(0, colon);
    spec.width = width;
    spec.height = height;
  }
  if (spec.camera.empty()) return Error{quote(text) + " names no camera"};
  return spec;
}

std::optional<Options> parse_options(int argc, char** argv, int* exit_code) {
  Options options;
  options.publish.rate_hz = 60;
  CLI::App app{"Steps a MuJoCo model and publishes its poses to FIRE-3DV renderers.", "fire3dv-mujoco"};
  set_help(app, "MODEL.xml --to URI [OPTIONS]");
  app.footer(
      "Standard input: pause, go, step, reset, quit. Exit status: 0 done, 1 error, 2 wrong usage.\n"
      "Details: man fire3dv-mujoco.");
  set_program_flags(app);
  app.add_option("model", options.model, "MJCF file")->required();
  OptionGroup group(app);
  group.add_repeatable("--to", options.publish.uris, "URI",
                       "shm://NAME, or tcp, tls, udp://HOST:PORT; repeatable");
  group.add("--scene", options.scene, "OUT.glb", "write the scene first, one node for each geom");
  group
      .add_repeatable("--package-path", options.package_folders, "DIR",
                      "further folder of the model's files; repeatable")
      ->check(CLI::ExistingDirectory.description(""));
  group.add("--rate", options.publish.rate_hz, "HZ", "frames per simulated second; 0: every step")
      ->check(check_number);
  group.add("--speed", options.speed, "X", "simulated seconds per second; 0: unpaced")->check(check_number);
  group.add("--duration", options.duration_s, "SECONDS", "simulated seconds; 0: until interrupted")
      ->check(check_number);
  group.add("--key", options.keyframe, "NAME|N", "initial keyframe (default: the first, if any)");
  const std::map<std::string, Drive> drives{
      {"hold", Drive::hold}, {"sin", Drive::sine}, {"zero", Drive::zero}};
  group
      .add("--ctrl", options.drive, "hold|sin|zero", "actuators: hold controls, a sine around them, or zero")
      ->transform(CLI::CheckedTransformer(drives).description(""))
      ->default_str("hold");
  std::string show;
  const CLI::Option* const show_option =
      group.add("--show", show, "LIST", "markers: contacts,forces,joints,com,tendons");
  group.add_flag("--joint-scalars", options.publish.joint_scalars,
                 "send joint positions, velocities and efforts as scalars for plots");
  group.add_flag("--controls", options.controls,
                 "let people run and pause it, drag bodies, and move actuators");
  group.add_flag("--paused", options.paused, "start paused, with one frame published");
  group.add_flag("--lockstep", options.lockstep, "wait until a renderer has drawn each frame");
  group.add("--ack-timeout", options.ack_timeout_s, "SECONDS", "limit of one wait of --lockstep")
      ->check(number_between(0.1, 86400));
  std::vector<std::string> cameras;
  std::string outputs = "color";
  group.add_repeatable("--images", cameras, "CAMERA[:WxH]",
                       "request images of this camera (640x480); repeatable");
  group.add("--outputs", outputs, "LIST", "their outputs, as fire3dv --outputs");
  group.add("--out", options.out, "DIR", "folder of the images: PNG, .npy and a list");
  add_client_security(app, options.publish.security.key_file, options.publish.security.tls_ca_file,
                      options.publish.security.tls_certificate_file, options.publish.security.tls_key_file);
  try {
    app.parse(argc, argv);
    if (options.publish.uris.empty() && options.scene.empty())
      throw CLI::ValidationError("--to", "name where to publish, or a file for the scene (--scene)");
    if (cameras.empty() != options.out.empty())
      throw CLI::ValidationError("--images", "goes together with a folder for them (--out DIR)");
    if (!cameras.empty() && options.publish.uris.empty())
      throw CLI::ValidationError("--images", "name the renderer that makes them (--to URI)");
    if (*show_option) {
      const Result<uint32_t> quantities = shown_quantities(show);
      if (!quantities) throw CLI::ValidationError("--show", quantities.error().message);
      if (options.publish.uris.empty())
        throw CLI::ValidationError("--show", "name the renderer that draws the markers (--to URI)");
      options.publish.show = *quantities;
    }
    if (options.publish.joint_scalars && options.publish.uris.empty())
      throw CLI::ValidationError("--joint-scalars", "name the renderer that plots them (--to URI)");
    if (options.controls && options.publish.uris.empty())
      throw CLI::ValidationError("--controls", "name the renderer that shows them (--to URI)");
    const Result<uint32_t> bits = image_outputs(outputs);
    if (!bits) throw CLI::ValidationError("--outputs", bits.error().message);
    for (const std::string& camera : cameras) {
      Result<ImageSpec> spec = image_spec(camera);
      if (!spec) throw CLI::ValidationError("--images", spec.error().message);
      for (const ImageSpec& other : options.images) {
        if (other.camera == spec->camera)
          throw CLI::ValidationError("--images", "the camera \"" + spec->camera + "\" is given twice");
      }
      spec->outputs = *bits;
      options.images.push_back(std::move(*spec));
    }
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error, std::cout, std::cerr) == 0 ? 0 : 2;
    return std::nullopt;
  }
  return options;
}

}  // namespace fire3dv::mujoco
