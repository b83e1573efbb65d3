#include "adapters/gazebo/stream/camera_spec.h"

#include <cmath>
#include <iterator>

#include "base/text.h"

namespace fire3dv::gazebo {
namespace {

constexpr uint32_t kMaxSide = 8192;
constexpr size_t kMaxTopicBytes = 1024;

// Without the name of the image. Names of the models, link and sensor, as in Gazebo's topics.
std::string default_topic(const TopLevel& item, size_t sensor, const std::string& world) {
  std::string below;
  for (size_t i = sensor; i != kNoParent; i = item.entities[i].parent)
    below = std::string("/") + name_of(item.entities[i].kind) + "/" + own_name(item.entities[i]) + below;
  return "/world/" + world + below;
}

// Gazebo's rule for names that are no topics: blanks become '_'; '@', '~', "//" and ":=" go.
std::string valid_topic(const std::string& given) {
  const std::string name = printable_text(given, std::string::npos);
  std::string topic = "/";
  for (size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    if (c == '@' || c == '~' || (c == '/' && topic.back() == '/')) continue;
    if (c == ':' && i + 1 < name.size() && name[i + 1] == '=') {
      ++i;
      continue;
    }
    topic += c == ' ' ? '_' : c;
  }
  return topic;
}

// given: topic of the sensor; empty: none.
Result<void> set_topics(const std::string& type, const std::string& given, const std::string& default_base,
                        CameraSpec& spec) {
  constexpr uint32_t kColor = FIRE3DV_IMAGE_COLOR_SRGB8, kDepth = FIRE3DV_IMAGE_DEPTH_F32;
  const auto topic = [&](const std::string& suffix) {
    return valid_topic(given.empty() ? default_base + suffix : given);
  };
  if (type == "camera") {
    spec.images = {{topic("/image"), kColor}};
  } else if (type == "depth_camera") {
    spec.images = {{topic("/depth_image"), kDepth}};
  } else if (type == "rgbd_camera") {  // its topic is the base of others
    std::string base = topic("");
    if (base.ends_with('/')) base.pop_back();
    spec.images = {{base + "/image", kColor}, {base + "/depth_image", kDepth}};
  } else {
    return Error{"sensors of type " + quote(type) +
                 " are not rendered, only camera, depth_camera and rgbd_camera"};
  }
  for (const CameraSpec::Topic& image : spec.images) {
    if (image.name.size() > kMaxTopicBytes || image.name == "/")
      return Error{"its topic is empty or longer than " + std::to_string(kMaxTopicBytes) + " bytes"};
    spec.request.outputs |= image.output;
  }
  const std::string& first = spec.images.front().name;
  spec.info_topic = first.substr(0, first.rfind('/')) + "/camera_info";
  return {};
}

void set_projection(const pb::CameraSensor& sensor, fire3dv_image_request& request) {
  const double width = sensor.image_size().x(), height = sensor.image_size().y();
  request.width = static_cast<uint32_t>(width);
  request.height = static_cast<uint32_t>(height);
  request.fx = request.fy = static_cast<float>(width / 2 / std::tan(sensor.horizontal_fov() / 2));
  request.cx = static_cast<float>((width - 1) / 2);
  request.cy = static_cast<float>((height - 1) / 2);
  const double near_m = sensor.near_clip(), far_m = sensor.far_clip();
  if (near_m > 1e-6 && near_m < 1e6) request.near_m = static_cast<float>(near_m);
  if (far_m > near_m && far_m < 1e9) request.far_m = static_cast<float>(far_m);
  const pb::Distortion& lens = sensor.distortion();
  const double coefficients[] = {lens.k1(), lens.k2(), lens.p1(), lens.p2(), lens.k3()};
  for (size_t k = 0; k < std::size(coefficients); ++k) {
    if (!std::isfinite(coefficients[k]) || coefficients[k] == 0) continue;
    request.lens = FIRE3DV_LENS_PLUMB_BOB;
    request.lens_coefficients[k] = static_cast<float>(coefficients[k]);
  }
}

}  // namespace

Result<CameraSpec> camera_spec(const TopLevel& item, size_t sensor, const std::string& world) {
  const Entity& entity = item.entities[sensor];
  const pb::CameraSensor& from = entity.sensor->camera();
  const auto is_side = [](double pixels) { return pixels >= 1 && pixels <= kMaxSide; };
  if (!is_side(from.image_size().x()) || !is_side(from.image_size().y()))
    return Error{"its image is not 1 to " + std::to_string(kMaxSide) + " pixels wide and high"};
  if (!(from.horizontal_fov() > 0 && from.horizontal_fov() < 3.1))
    return Error{"its horizontal field of view is not above 0 and below 3.1 rad"};
  CameraSpec spec;
  if (Result<void> named =
          set_topics(entity.sensor->type(), entity.sensor->topic(), default_topic(item, sensor, world), spec);
      !named)
    return named.error();
  spec.frame_id = entity.name;
  set_projection(from, spec.request);
  const double rate_hz = entity.sensor->update_rate();
  if (rate_hz > 1e-3 && rate_hz < 1e6) spec.period_ns = std::llround(1e9 / rate_hz);
  return spec;
}

}  // namespace fire3dv::gazebo
