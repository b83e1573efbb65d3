#include "adapters/ros2/images/sensor_tags.h"

#include <tinyxml2.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <numbers>
#include <set>
#include <utility>

#include "adapters/ros2/dds/names.h"
#include "base/text.h"
#include "base/words.h"

namespace fire3dv::ros2 {
namespace {

using Element = tinyxml2::XMLElement;

constexpr size_t kMaxBytes = size_t{64} << 20;
constexpr size_t kMaxWarnings = 20;
constexpr double kGazeboFov = 1.047;

// Text of the first of these children that has any; empty: none.
std::string_view child_text(const Element* parent, std::initializer_list<const char*> names) {
  if (!parent) return {};
  for (const char* const name : names) {
    const Element* const child = parent->FirstChildElement(name);
    const char* const text = child ? child->GetText() : nullptr;
    if (text && !trimmed(text).empty()) return trimmed(text);
  }
  return {};
}

struct SensorType {
  std::string_view name;
  bool depth;
  LabelSource labels;
};
constexpr std::array<SensorType, 7> kTypes{{{"camera", false, LabelSource::none},
                                            {"depth", true, LabelSource::none},
                                            {"depth_camera", true, LabelSource::none},
                                            {"rgbd", true, LabelSource::none},
                                            {"rgbd_camera", true, LabelSource::none},
                                            {"segmentation", false, LabelSource::semantic},
                                            {"segmentation_camera", false, LabelSource::semantic}}};

class SensorReader {
 public:
  explicit SensorReader(SensorCameras& result, std::set<std::string, std::less<>> links)
      : result_(result), links_(std::move(links)) {}

  void read(const Element& sensor, const std::string& link) {
    const char* const name = sensor.Attribute("name");
    const char* const type = sensor.Attribute("type");
    const Element* const camera = sensor.FirstChildElement("camera");
    const auto* const known = std::find_if(kTypes.begin(), kTypes.end(),
                                           [&](const SensorType& t) { return type && t.name == type; });
    where_ = "sensor " + quote(name ? name : "") + " of link " + quote(link);
    if (known == kTypes.end()) {
      if (camera) warn("type " + quote(type ? type : "") + " is not a camera that is published");
      return;
    }
    if (!name || trimmed(name).empty()) return warn("it has no name");
    if (!links_.contains(link)) return warn("the robot has no such link");
    if (result_.cameras.size() >= kMaxCameras)
      return warn("only the first " + std::to_string(kMaxCameras) + " cameras are published");
    CameraSpec spec;
    spec.name = unique_name(printable_text(trimmed(name), 100), link);
    if (spec.name.empty()) return warn("another sensor has that name; rename one of them");
    spec.parent_frame = link;
    spec.depth = known->depth;
    spec.labels = known->labels;
    read_pose(sensor, spec);
    read_rate(sensor, spec);
    read_camera(camera, spec);
    read_topic(sensor, spec);
    read_frame(sensor, camera, spec);
    result_.cameras.push_back(std::move(spec));
  }

 private:
  void warn(const std::string& reason) {
    if (result_.warnings.size() < kMaxWarnings) result_.warnings.push_back(where_ + ": " + reason);
  }

  // Two cameras of a robot may have sensors of one name: the second is LINK_NAME.
  std::string unique_name(std::string name, const std::string& link) const {
    const auto is_taken = [&](const std::string& candidate) {
      return std::any_of(result_.cameras.begin(), result_.cameras.end(),
                         [&](const CameraSpec& camera) { return camera.name == candidate; });
    };
    if (is_taken(name)) name = printable_text(link, 100) + "_" + name;
    return is_taken(name) ? std::string() : name;
  }

  // Number of a child within limits; the default remains, with a warning, if it is bad.
  void read_number(const Element* parent, const char* name, double least, double most, double& value) {
    const std::string_view text = child_text(parent, {name});
    double parsed = 0;
    if (text.empty()) return;
    if (parse_numbers(text, &parsed, 1) && parsed >= least && parsed <= most)
      value = parsed;
    else
      warn("<" + std::string(name) + "> " + quote(text) + " is not valid; " + std::to_string(value) +
           " is used");
  }

  void read_pose(const Element& sensor, CameraSpec& spec) {
    for (const Element* const element :
         {sensor.FirstChildElement("pose"), sensor.FirstChildElement("origin")}) {
      if (!element) continue;
      std::array<double, 6> numbers{};
      if (element->Attribute("xyz") || element->Attribute("rpy")) {
        const char* const xyz = element->Attribute("xyz");
        const char* const rpy = element->Attribute("rpy");
        if ((xyz && !parse_numbers(xyz, numbers.data(), 3)) || (rpy && !parse_numbers(rpy, &numbers[3], 3)))
          return warn("its <" + std::string(element->Name()) +
                      "> is not valid; it sits in the link's origin");
      } else if (element->GetText()) {
        if (element->Attribute("relative_to") || element->Attribute("rotation_format"))
          warn(
              "attributes of <pose> are not supported; it is read relative to the link, x y z roll pitch "
              "yaw");
        if (!parse_numbers(element->GetText(), numbers.data(), 6))
          return warn("<pose> " + quote(element->GetText()) +
                      " is not six numbers; it sits in the link's origin");
        if (element->BoolAttribute("degrees"))
          for (size_t i = 3; i < 6; ++i) numbers[i] *= std::numbers::pi / 180;
      }
      spec.xyz = {numbers[0], numbers[1], numbers[2]};
      spec.rpy = {numbers[3], numbers[4], numbers[5]};
      return;
    }
  }

  void read_rate(const Element& sensor, CameraSpec& spec) {
    read_number(&sensor, "update_rate", 0, 1e6, spec.rate_hz);
  }

  void read_camera(const Element* camera, CameraSpec& spec) {
    spec.fov = kGazeboFov;
    spec.width = 320;
    spec.height = 240;
    spec.near_m = 0.1;
    spec.far_m = 100;
    if (!camera) return;
    read_number(camera, "horizontal_fov", 1e-3, std::numbers::pi - 1e-3, spec.fov);
    const Element* const image = camera->FirstChildElement("image");
    double width = spec.width, height = spec.height;
    read_number(image, "width", 1, kMaxImageSide, width);
    read_number(image, "height", 1, kMaxImageSide, height);
    spec.width = static_cast<uint32_t>(width);
    spec.height = static_cast<uint32_t>(height);
    double near_m = spec.near_m, far_m = spec.far_m;
    const Element* const clip = camera->FirstChildElement("clip");
    read_number(clip, "near", 1e-4, 1e9, near_m);
    read_number(clip, "far", 0, 1e9, far_m);
    if (far_m > near_m) {
      spec.near_m = near_m;
      spec.far_m = far_m;
    } else {
      warn("<clip>: far is not more than near; 0.1 and 100 are used");
    }
    read_lens(*camera, spec);
  }

  void read_lens(const Element& camera, CameraSpec& spec) {
    const Element* const lens = camera.FirstChildElement("lens");
    const Element* const intrinsics = lens ? lens->FirstChildElement("intrinsics") : nullptr;
    read_number(intrinsics, "fx", 1e-3, 1e6, spec.fx);
    read_number(intrinsics, "fy", 1e-3, 1e6, spec.fy);
    read_number(intrinsics, "cx", 0, 1e6, spec.cx);
    read_number(intrinsics, "cy", 0, 1e6, spec.cy);
    if (spec.fx == 0 && spec.fy != 0) {
      spec.fy = 0;
      warn("<intrinsics> has fy without fx; <horizontal_fov> is used");
    }
    const Element* const distortion = camera.FirstChildElement("distortion");
    std::array<double, 5> d{};  // k1 k2 p1 p2 k3
    constexpr std::array<const char*, 5> kNames{"k1", "k2", "p1", "p2", "k3"};
    for (size_t i = 0; i < d.size(); ++i) read_number(distortion, kNames[i], -1e6, 1e6, d[i]);
    if (std::all_of(d.begin(), d.end(), [](double value) { return value == 0; })) return;
    spec.lens = Lens::plumb_bob;
    spec.lens_coefficients = d;
  }

  // <topic> is Gazebo's name of the image itself; classic plug-ins have a namespace and a camera name.
  void read_topic(const Element& sensor, CameraSpec& spec) {
    std::string topic(child_text(&sensor, {"topic"}));
    for (const std::string_view image : {"/image_raw", "/image"}) {
      if (topic.size() <= image.size() || !topic.ends_with(image)) continue;
      topic.resize(topic.size() - image.size());
      break;
    }
    for (const Element* plugin = sensor.FirstChildElement("plugin"); plugin && topic.empty();
         plugin = plugin->NextSiblingElement("plugin")) {
      const std::string_view name = child_text(plugin, {"camera_name", "cameraName"});
      std::string_view space = child_text(plugin->FirstChildElement("ros"), {"namespace"});
      if (space.empty()) space = child_text(plugin, {"robotNamespace"});
      if (name.empty() && space.empty()) continue;
      topic = std::string(space) + (space.empty() || space.ends_with('/') ? "" : "/") +
              (name.empty() ? topic_from_name(spec.name) : std::string(name));
    }
    if (!topic.empty() && (!is_valid_name(topic) || topic.size() > kMaxTopicBytes)) {
      warn("topic " + quote(topic) + " is not a topic name; " + topic_from_name(spec.name) + " is used");
      topic.clear();
    }
    spec.topic = topic.empty() ? topic_from_name(spec.name) : topic;
    const bool is_taken = std::any_of(result_.cameras.begin(), result_.cameras.end(),
                                      [&](const CameraSpec& other) { return other.topic == spec.topic; });
    if (is_taken && spec.topic != topic_from_name(spec.name)) {
      warn("topic " + quote(spec.topic) + " is another camera's, too; " + topic_from_name(spec.name) +
           " is used");
      spec.topic = topic_from_name(spec.name);
    }
  }

  void read_frame(const Element& sensor, const Element* camera, CameraSpec& spec) {
    std::string frame(child_text(camera, {"optical_frame_id"}));
    for (const Element* plugin = sensor.FirstChildElement("plugin"); plugin && frame.empty();
         plugin = plugin->NextSiblingElement("plugin"))
      frame = child_text(plugin, {"frame_name", "frameName"});
    if (frame.empty()) frame = child_text(&sensor, {"gz_frame_id", "ignition_frame_id"});
    if (frame.starts_with('/')) frame.erase(0, 1);
    // The link of the sensor is a body frame: images that name it would be shown turned.
    if (frame.empty() || frame == spec.parent_frame || frame.size() > 255 ||
        printable_text(frame, 255) != frame)
      frame = spec.name + "_optical_frame";
    spec.optical_frame = frame;
    spec.publishes_frame = !links_.contains(frame);  // links of the robot are its own publisher's
  }

  SensorCameras& result_;
  std::set<std::string, std::less<>> links_;
  std::string where_;
};

}  // namespace

Result<SensorCameras> read_sensor_cameras(std::string_view urdf) {
  if (urdf.size() > kMaxBytes) return Error{"the robot description has more than 64 MiB"};
  tinyxml2::XMLDocument document;
  document.Parse(urdf.data(), urdf.size());
  if (document.Error())
    return Error{"the robot description is not XML: line " + std::to_string(document.ErrorLineNum())};
  const Element* const robot = document.FirstChildElement("robot");
  if (!robot) return Error{"the robot description has no <robot>"};
  std::set<std::string, std::less<>> links;
  for (const Element* link = robot->FirstChildElement("link"); link; link = link->NextSiblingElement("link"))
    if (const char* const name = link->Attribute("name")) links.emplace(name);
  SensorCameras result;
  SensorReader reader(result, std::move(links));
  for (const Element* gazebo = robot->FirstChildElement("gazebo"); gazebo;
       gazebo = gazebo->NextSiblingElement("gazebo")) {
    const char* const link = gazebo->Attribute("reference");
    if (!link) continue;
    for (const Element* sensor = gazebo->FirstChildElement("sensor"); sensor;
         sensor = sensor->NextSiblingElement("sensor"))
      reader.read(*sensor, link);
  }
  return result;
}

}  // namespace fire3dv::ros2
