#include "adapters/ros2/images/camera_options.h"

#include <algorithm>
#include <utility>

#include "adapters/ros2/images/sensor_tags.h"
#include "base/command_line.h"
#include "base/text.h"

namespace fire3dv::ros2 {
namespace {

// Applies what was given for all cameras.
Result<CameraSpec> with_defaults(const CameraArguments& arguments, CameraSpec camera) {
  if (!arguments.size.empty()) {
    const auto size = parse_image_size(arguments.size);
    if (!size) return Error{"--image-size: " + size.error().message};
    set_image_size(camera, size->first, size->second);
  }
  if (arguments.rate_hz >= 0) camera.rate_hz = arguments.rate_hz;
  if (!arguments.labels.empty())
    camera.labels = arguments.labels == "semantic" ? LabelSource::semantic : LabelSource::instance;
  camera.depth = camera.depth || arguments.depth;
  camera.compressed = camera.compressed || arguments.compressed;
  camera.jpeg_quality = arguments.jpeg_quality;
  return camera;
}

std::string names_of(const std::vector<CameraSpec>& cameras) {
  std::string names;
  for (const CameraSpec& camera : cameras) names += (names.empty() ? "" : ", ") + camera.name;
  return names.empty() ? "it has none" : "it has " + names;
}

}  // namespace

void add_camera_options(CLI::App& app, CameraArguments& arguments) {
  OptionGroup group(app, "Images");
  group.add_repeatable("--camera", arguments.cameras, "NAME[:=TOPIC][,KEY=VALUE]...",
                       "publish images of a camera at a tf frame; repeatable");
  group.add_flag("--sensors", arguments.all_sensors,
                 "publish all cameras of the robot description (<sensor>)");
  group.add_repeatable("--sensor", arguments.sensors, "NAME[:=TOPIC][,KEY=VALUE]...",
                       "publish this camera of the robot description; repeatable");
  group.add("--image-size", arguments.size, "WxH", "size of all images (default: 640x480, or the sensor's)");
  group
      .add("--image-rate", arguments.rate_hz, "HZ",
           "images per second; 0: every pose frame (default: 0, or the sensor's)")
      ->default_str("")
      ->check(check_number);
  group.add_flag("--depth", arguments.depth, "publish depth, too: 32FC1, metres");
  group.add_choice("--labels", arguments.labels, "instance|semantic", "publish labels, too: 32SC1");
  group.add_flag("--compressed", arguments.compressed, "publish JPEG, too");
  group.add("--jpeg-quality", arguments.jpeg_quality, "N", "1 to 100")->check(number_between(1, 100));
}

Result<ImageOptions> image_options(const CameraArguments& arguments) {
  ImageOptions options;
  options.all_sensors = arguments.all_sensors;
  options.arguments = arguments;
  const Result<CameraSpec> defaults = with_defaults(arguments, CameraSpec{});
  if (!defaults) return defaults.error();
  for (const std::string& text : arguments.cameras) {
    const Result<CameraOption> option = parse_camera_option(text);
    if (!option) return Error{"--camera: " + option.error().message};
    Result<CameraSpec> camera = apply(*option, *defaults);
    if (!camera) return Error{"--camera: " + camera.error().message};
    options.cameras.push_back(std::move(*camera));
  }
  for (const std::string& text : arguments.sensors) {
    Result<CameraOption> option = parse_camera_option(text);
    if (!option) return Error{"--sensor: " + option.error().message};
    options.sensors.push_back(std::move(*option));
  }
  const bool has_defaults = !arguments.size.empty() || arguments.rate_hz >= 0 || !arguments.labels.empty() ||
                            arguments.depth || arguments.compressed;
  if (options.is_empty() && has_defaults)
    return Error{"options of images need a camera: --camera NAME, --sensor NAME or --sensors"};
  if (options.cameras.size() + options.sensors.size() > kMaxCameras)
    return Error{"--camera, --sensor: at most " + std::to_string(kMaxCameras) + " cameras"};
  return options;
}

RobotCameras robot_cameras(const ImageOptions& options, std::string_view urdf,
                           const std::string& frame_prefix) {
  RobotCameras result;
  if (!options.needs_description()) return result;
  Result<SensorCameras> sensors = read_sensor_cameras(urdf);
  if (!sensors) {
    result.warnings.push_back(sensors.error().message);
    return result;
  }
  result.warnings = std::move(sensors->warnings);
  std::vector<bool> used(options.sensors.size());
  for (CameraSpec& sensor : sensors->cameras) {
    const auto chosen = std::find_if(options.sensors.begin(), options.sensors.end(),
                                     [&](const CameraOption& option) { return option.name == sensor.name; });
    if (chosen == options.sensors.end() && !options.all_sensors) continue;
    // A prefix makes a frame of each link, and the same of frames that nobody publishes.
    sensor.parent_frame = frame_prefix + sensor.parent_frame;
    sensor.optical_frame = frame_prefix + sensor.optical_frame;
    Result<CameraSpec> camera = with_defaults(options.arguments, sensor);
    if (camera && chosen != options.sensors.end()) {
      used[static_cast<size_t>(chosen - options.sensors.begin())] = true;
      camera = apply(*chosen, *camera);
    }
    if (camera)
      result.cameras.push_back(std::move(*camera));
    else
      result.warnings.push_back(camera.error().message);
  }
  for (size_t i = 0; i < used.size(); ++i)
    if (!used[i])
      result.warnings.push_back("the robot description has no camera " + quote(options.sensors[i].name) +
                                "; " + names_of(sensors->cameras));
  return result;
}

}  // namespace fire3dv::ros2
