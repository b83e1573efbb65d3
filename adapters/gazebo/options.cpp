#include "adapters/gazebo/options.h"

#include <CLI/CLI.hpp>
#include <iostream>

#include "base/command_line.h"

namespace fire3dv::gazebo {

std::optional<Options> parse_options(int argc, char** argv, int* exit_code) {
  Options options;
  options.node = options_of_environment();
  CLI::App app{"Publishes a running Gazebo world, Fortress to Jetty, to FIRE-3DV renderers.",
               "fire3dv-gazebo"};
  set_help(app, "--to URI [OPTIONS]");
  app.footer(
      "Environment, with GZ_ or IGN_: PARTITION, IP, RELAY, TRANSPORT_USERNAME, TRANSPORT_PASSWORD.\n"
      "Exit status: 0 done, 1 error, 2 wrong usage. Details: man fire3dv-gazebo.");
  set_program_flags(app);
  OptionGroup group(app), cameras(app, "Cameras"), gazebo(app, "Gazebo");
  group.add_repeatable("--to", options.uris, "URI", "shm://NAME, or tcp, tls, udp://HOST:PORT; repeatable");
  group.add("--name", options.stream_name, "NAME", "name of the stream");
  group.add("--write-scene", options.session.write_scene, "OUT.glb",
            "write the world's scene first; alone: then end");
  group.add_flag("--add-scene", options.session.add_scene, "send the whole scene over the stream, too");
  group
      .add_repeatable("--resource-path", options.resource_folders, "DIR",
                      "folder of models, beside GZ_SIM_RESOURCE_PATH; repeatable")
      ->check(CLI::ExistingDirectory.description(""));
  cameras.add_repeatable("--camera", options.session.cameras.names, "NAME",
                         "publish images of this camera to Gazebo; repeatable");
  cameras.add_flag("--cameras", options.session.cameras.all, "publish images of all cameras");
  gazebo.add("--world", options.session.world, "NAME", "world to show (default: the only one)");
  gazebo.add("--partition", options.node.partition, "NAME",
             "partition (default: GZ_PARTITION, or HOST:USER)");
  gazebo.add("--ip", options.node.ip, "ADDRESS",
             "address of this host to use alone (default: GZ_IP, or all)");
  gazebo.add_repeatable("--peer", options.node.relays, "HOST",
                        "host that multicast does not reach; repeatable");
  add_client_security(app, options.security.key_file, options.security.tls_ca_file,
                      options.security.tls_certificate_file, options.security.tls_key_file);
  try {
    app.parse(argc, argv);
    if (options.uris.empty() && options.session.write_scene.empty())
      throw CLI::ValidationError("--to", "name where to publish, or a file for the scene (--write-scene)");
    if (options.uris.empty() && options.session.cameras.any())
      throw CLI::ValidationError("--camera", "name the renderer that makes the images (--to URI)");
    if (options.session.add_scene && !options.session.write_scene.empty())
      throw CLI::ValidationError("--add-scene", "either write the scene, or send it over the stream");
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error, std::cout, std::cerr) == 0 ? 0 : 2;
    return std::nullopt;
  }
  options.session.ends_after_scene = options.uris.empty();
  return options;
}

}  // namespace fire3dv::gazebo
