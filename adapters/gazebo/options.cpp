#include "adapters/gazebo/options.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "base/command_line.h"

namespace fire3dv::gazebo {

std::optional<Options> parse_options(int argc, char** argv, int* exit_code) {
  Options options;
  options.node = options_of_environment();
  CLI::App app{"Publishes a running Gazebo world, Fortress to Jetty, to FIRE-3DV renderers.",
               "fire3dv-gazebo"};
  app.formatter(std::make_shared<HelpFormatter>("--to URI [OPTIONS]"));
  app.footer(
      "Environment, with GZ_ or IGN_: PARTITION, IP, RELAY, TRANSPORT_USERNAME, TRANSPORT_PASSWORD.\n"
      "Exit status: 0 done, 1 error, 2 wrong usage. Details: man fire3dv-gazebo.");
  set_program_flags(app);
  app.add_option("--to", options.uris, "shm://NAME, or tcp, tls, udp://HOST:PORT; repeatable")
      ->type_name("URI")
      ->allow_extra_args(false);
  app.add_option("--name", options.stream_name, "name of the stream")
      ->type_name("NAME")
      ->capture_default_str();
  app.add_option("--write-scene", options.session.write_scene,
                 "write the world's scene first; alone: then end")
      ->type_name("OUT.glb");
  app.add_flag("--add-scene", options.session.add_scene, "send the whole scene over the stream, too");
  app.add_option("--resource-path", options.resource_folders,
                 "folder of models, beside GZ_SIM_RESOURCE_PATH; repeatable")
      ->type_name("DIR")
      ->allow_extra_args(false)
      ->check(CLI::ExistingDirectory.description(""));
  app.add_option("--camera", options.session.cameras.names,
                 "publish images of this camera to Gazebo; repeatable")
      ->type_name("NAME")
      ->allow_extra_args(false)
      ->group("Cameras");
  app.add_flag("--cameras", options.session.cameras.all, "publish images of all cameras")->group("Cameras");
  app.add_option("--world", options.session.world, "world to show (default: the only one)")
      ->type_name("NAME")
      ->group("Gazebo");
  app.add_option("--partition", options.node.partition, "partition (default: GZ_PARTITION, or HOST:USER)")
      ->type_name("NAME")
      ->group("Gazebo");
  app.add_option("--ip", options.node.ip, "address of this host to use alone (default: GZ_IP, or all)")
      ->type_name("ADDRESS")
      ->group("Gazebo");
  app.add_option("--peer", options.node.relays, "host that multicast does not reach; repeatable")
      ->type_name("HOST")
      ->allow_extra_args(false)
      ->group("Gazebo");
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
