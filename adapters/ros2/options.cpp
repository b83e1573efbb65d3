#include "adapters/ros2/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>

#include "base/command_line.h"
#include "base/text.h"

namespace fire3dv::ros2 {
namespace {

constexpr int kUsageError = 2;

// Words of --ros-args up to "--": remapping rules. Parameters have no meaning here.
Result<void> take_ros_arguments(std::vector<std::string>& words, std::vector<std::string>& rules) {
  std::vector<std::string> others;
  for (size_t i = 0; i < words.size(); ++i) {
    if (words[i] != "--ros-args") {
      others.push_back(words[i]);
      continue;
    }
    for (++i; i < words.size() && words[i] != "--"; ++i) {
      const std::string& word = words[i];
      const bool is_rule = word == "-r" || word == "--remap";
      if (!is_rule && word != "-p" && word != "--param" && word != "--log-level" && word != "--params-file")
        return Error{"--ros-args: " + quote(word) + " is not supported; -r FROM:=TO is"};
      if (++i == words.size()) return Error{"--ros-args: " + word + " needs a value"};
      if (is_rule) rules.push_back(words[i]);
    }
  }
  words = std::move(others);
  return {};
}

void add_input_options(CLI::App& app, Options& options, std::string& ns, bool& no_description,
                       bool& no_joints, bool& is_parsed_before) {
  OptionGroup ros(app, "ROS 2"), frames(app, "Frames"), robot(app, "Robot");
  ros.add("--domain", options.domain_id, "N", "DDS domain, 0 to 232 (default: ROS_DOMAIN_ID, or 0)")
      ->check(in_range(0, 232));
  ros.add("--namespace", ns, "NAME", "namespace of relative topics, as __ns:=NAME");
  ros.add_flag("--ros-args", is_parsed_before, "remapping until --: -r FROM:=TO, -r __ns:=NAME");
  frames.add("--fixed-frame", options.frames.fixed_frame, "FRAME",
             "frame that stands still (default: map, odom, world or the root)");
  frames.add("--frame-prefix", options.frames.frame_prefix, "TEXT",
             "prefix of the robot's frames, such as robot1/");
  robot.add("--write-scene", options.scene_file, "OUT.glb",
            "write the robot to this file instead of sending it to the renderer");
  robot
      .add_repeatable("--package-path", options.package_folders, "DIR",
                      "folder that robot descriptions may name meshes of; repeatable")
      ->check(CLI::ExistingDirectory.description(""));
  robot.add_flag("--no-description", no_description, "send the poses of all frames, and no robot");
  robot.add_flag("--no-joint-scalars", no_joints, "send no joint states as scalars for plots");
}

void add_marker_options(CLI::App& app, MarkerTopics& topics) {
  OptionGroup group(app, "Markers");
  group.add_repeatable("--markers", topics.markers, "TOPIC", "show a MarkerArray topic; repeatable");
  group.add_repeatable("--points", topics.points, "TOPIC", "show a PointCloud2 topic; repeatable");
  group.add_repeatable("--path", topics.paths, "TOPIC", "show a Path topic; repeatable");
  group.add_repeatable("--map", topics.maps, "TOPIC", "show an OccupancyGrid topic; repeatable");
}

void add_security_options(CLI::App& app, Security& security) {
  add_client_security(app, security.key_file, security.tls_ca_file, security.tls_certificate_file,
                      security.tls_key_file);
}

// Rules of --ros-args come after --namespace, and their order counts.
Result<Names> make_names(const std::string& ns, const std::vector<std::string>& rules) {
  Result<Names> names = Names::create(ns, "");
  if (!names) return names;
  for (const std::string& rule : rules)
    if (Result<void> added = names->remap(rule); !added) return added.error();
  return names;
}

}  // namespace

std::variant<Options, int> parse_options(int argc, char** argv) {
  Options options;
  std::string ns;
  bool no_description = false, no_joints = false;
  CLI::App app{"Publishes the transforms and the robot of a ROS 2 system to FIRE-3DV renderers.",
               "fire3dv-ros2"};
  set_help(app, "--to URI [OPTIONS] [--ros-args -r FROM:=TO ...]");
  app.footer(
      "Two commands show a robot:\n"
      "  fire3dv-ros2 --to shm://robot --write-scene robot.glb\n"
      "  fire3dv robot.glb --listen shm://robot\n"
      "Details: man fire3dv-ros2, or docs/man/fire3dv-ros2.1.md.");
  set_program_flags(app);
  OptionGroup(app)
      .add_repeatable("--to", options.uris, "URI", "shm://NAME, or tcp, tls, udp://HOST:PORT; repeatable")
      ->required();
  bool ros_arguments = false;  // for the help; take_ros_arguments() reads them
  add_input_options(app, options, ns, no_description, no_joints, ros_arguments);
  CameraArguments cameras;
  add_camera_options(app, cameras);
  add_marker_options(app, options.markers);
  add_security_options(app, options.security);
  const auto usage_error = [](const std::string& text) {
    std::cerr << "fire3dv-ros2: error: " << terminal_text(text) << " (see fire3dv-ros2 --help)\n";
    return kUsageError;
  };
  std::vector<std::string> words(argv + 1, argv + argc), rules;
  if (Result<void> taken = take_ros_arguments(words, rules); !taken)
    return usage_error(taken.error().message);
  try {
    std::reverse(words.begin(), words.end());
    app.parse(std::move(words));
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    return usage_error(usage_text(app, error));
  }
  Result<Names> names = make_names(ns, rules);
  if (!names) return usage_error(names.error().message);
  options.names = std::move(*names);
  Result<ImageOptions> images = image_options(cameras);
  if (!images) return usage_error(images.error().message);
  options.images = std::move(*images);
  if (no_description && options.images.needs_description())
    return usage_error("--sensor and --sensors need the robot description: leave --no-description out");
  options.reads_description = !no_description;
  options.shows_joints = !no_joints;
  if (no_description && !options.scene_file.empty())
    return usage_error("--write-scene needs the robot description: leave --no-description out");
  if (options.frames.fixed_frame.starts_with('/')) options.frames.fixed_frame.erase(0, 1);
  if (options.frames.frame_prefix.starts_with('/')) options.frames.frame_prefix.erase(0, 1);
  return options;
}

}  // namespace fire3dv::ros2
