#include "adapters/gazebo/stream/cameras.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <utility>

#include "gazebo.pb.h"
#include "protocol/base/clock.h"
#include "protocol/base/text.h"
#include "tools/convert/sdf/sdf_scene.h"

namespace fire3dv::gazebo {
namespace {

constexpr uint32_t kMaxSide = 8192;
constexpr int kRgbInt8 = 3;  // PixelFormatType

template <typename T>
std::vector<std::byte> bytes_of(const T& message) {
  std::vector<std::byte> bytes(message.ByteSizeLong());
  (void)message.SerializeToArray(bytes.data(), static_cast<int>(bytes.size()));
  return bytes;
}

void write_header(int64_t sim_time_ns, const std::string& frame_id, pb::Header& header) {
  int64_t s = sim_time_ns / 1'000'000'000, ns = sim_time_ns % 1'000'000'000;
  if (ns < 0) {
    ns += 1'000'000'000;
    --s;
  }
  header.mutable_stamp()->set_sec(s);
  header.mutable_stamp()->set_nsec(static_cast<int32_t>(ns));
  pb::Header::Map& entry = *header.add_data();
  entry.set_key("frame_id");
  entry.add_value(frame_id);
}

// Names of the models, link and sensor, as in Gazebo's topics.
std::string default_topic(const TopLevel& item, size_t sensor, const std::string& world) {
  std::string below;
  for (size_t i = sensor; i != kNoParent; i = item.entities[i].parent) {
    const std::string& node = item.entities[i].name;
    const std::string own = node.substr(node.rfind('/') == node.npos ? 0 : node.rfind('/') + 1);
    below = std::string("/") + name_of(item.entities[i].kind) + "/" + own + below;
  }
  return "/world/" + world + below + "/image";
}

bool is_topic(const std::string& topic) {
  return topic.size() <= 1024 && topic.find_first_of("@~ ") == topic.npos && topic.find("//") == topic.npos;
}

}  // namespace

std::vector<std::byte> image_message(const fire3dv_image& image, const std::string& frame_id) {
  pb::Image message;
  write_header(image.sim_time_ns, frame_id, *message.mutable_header());
  message.set_width(image.width);
  message.set_height(image.height);
  message.set_step(3 * image.width);
  message.set_pixel_format_type(kRgbInt8);
  if (const fire3dv_image_plane* plane = plane_of(image, FIRE3DV_IMAGE_COLOR_SRGB8)) {
    std::string& data = *message.mutable_data();
    data.resize(size_t{3} * image.width * image.height);
    char* to = data.data();
    for (uint32_t y = 0; y < image.height; ++y) {
      const char* from = static_cast<const char*>(plane->data) + size_t{plane->row_stride} * y;
      for (uint32_t x = 0; x < image.width; ++x, from += 4, to += 3) std::memcpy(to, from, 3);
    }
  }
  return bytes_of(message);
}

std::vector<std::byte> camera_info_message(const fire3dv_image& image, const std::string& frame_id) {
  pb::CameraInfo info;
  write_header(image.sim_time_ns, frame_id, *info.mutable_header());
  info.set_width(image.width);
  info.set_height(image.height);
  for (const float k : image.lens_coefficients) info.mutable_distortion()->add_k(static_cast<double>(k));
  const double fx = image.fx, fy = image.fy, cx = image.cx, cy = image.cy;
  for (const double k : {fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0}) info.mutable_intrinsics()->add_k(k);
  for (const double p : {fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0})
    info.mutable_projection()->add_p(p);
  for (const double r : {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}) info.add_rectification_matrix(r);
  return bytes_of(info);
}

void Cameras::update(const std::vector<TopLevel>& items, const std::string& world, const std::string& type) {
  if (!choice_.any()) return;
  if (const size_t dot = type.rfind('.'); dot != type.npos) prefix_ = type.substr(0, dot + 1);
  std::map<std::string, Camera> next;
  std::string known;
  std::vector<std::string> missing = choice_.names;
  for (const TopLevel& item : items) {
    for (size_t i = 0; i < item.entities.size(); ++i) {
      const Entity& entity = item.entities[i];
      if (!entity.sensor) continue;
      known += (known.empty() ? "" : ", ") + quote(entity.name);
      const auto wanted = std::find_if(
          choice_.names.begin(), choice_.names.end(),
          [&](const std::string& name) { return name == entity.name || name == entity.sensor->name(); });
      if (wanted != choice_.names.end()) std::erase(missing, *wanted);
      if (!choice_.all && wanted == choice_.names.end()) continue;
      if (const auto before = cameras_.find(entity.name); before != cameras_.end()) {
        before->second.node = entity.node;
        next.insert(cameras_.extract(before));
        continue;
      }
      const pb::CameraSensor& sensor = entity.sensor->camera();
      const double width = sensor.image_size().x(), height = sensor.image_size().y(),
                   fov = sensor.horizontal_fov();
      Camera camera;
      camera.topic = entity.sensor->topic();
      if (camera.topic.empty()) camera.topic = default_topic(item, i, world);
      if (!camera.topic.starts_with('/')) camera.topic = "/" + camera.topic;
      if (!(width >= 1 && width <= kMaxSide && height >= 1 && height <= kMaxSide && fov > 0 && fov < 3.1) ||
          !is_topic(camera.topic)) {
        warnings_.push_back("camera " + quote(entity.name) +
                            " has no images: its size, field of view or topic is not valid");
        continue;
      }
      camera.info_topic = camera.topic.substr(0, camera.topic.rfind('/')) + "/camera_info";
      camera.frame_id = entity.name;
      camera.node = entity.node;
      fire3dv_image_request& request = camera.request;
      request.width = static_cast<uint32_t>(width);
      request.height = static_cast<uint32_t>(height);
      request.fx = request.fy = static_cast<float>(width / 2 / std::tan(fov / 2));
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
      const double rate_hz = entity.sensor->update_rate();
      if (rate_hz > 1e-3 && rate_hz < 1e6) camera.period_ns = std::llround(1e9 / rate_hz);
      next.emplace(entity.name, std::move(camera));
    }
  }
  for (const std::string& name : missing)
    warnings_.push_back("the world has no camera " + quote(name) +
                        (known.empty() ? "" : "; it has " + known));
  cameras_ = std::move(next);
}

void Cameras::restart() {
  for (auto& [name, camera] : cameras_) camera.pending = 0;
}

// The renderer may not have the camera's node yet: it is still loading the asset.
void Cameras::refuse(const std::string& name, Camera& camera, const std::string& reason) {
  constexpr unsigned kReported = 4, kLongestWait = 5;
  camera.pending = 0;
  camera.retry_ns = monotonic_ns() + (kSecondNs / 4 << std::min(camera.refusals, kLongestWait));
  if (++camera.refusals == kReported)
    warnings_.push_back("camera " + quote(name) + ": " + reason + "; asking again");
}

std::vector<std::string> Cameras::request(Node& node, Publisher& publisher, int64_t sim_time_ns) {
  for (auto& [name, camera] : cameras_) {
    if (!node.is_advertised(camera.topic)) {
      for (const auto& [topic, type] :
           {std::pair(camera.topic, "Image"), {camera.info_topic, "CameraInfo"}}) {
        const Result<void> advertised = node.advertise(topic, prefix_ + type);
        if (!advertised && !std::exchange(cannot_publish_, true))
          warnings_.push_back(advertised.error().message);
      }
    }
    if (cannot_publish_ || camera.node.empty() || camera.pending != 0 || monotonic_ns() < camera.retry_ns)
      continue;
    if (!node.has_subscribers(camera.topic) && !node.has_subscribers(camera.info_topic)) continue;
    if (sim_time_ns < camera.last_ns) camera.due_ns = INT64_MIN;  // a reset
    constexpr int64_t kSlack_ns = 1'000'000;                      // poses come at times of their own
    if (camera.due_ns != INT64_MIN && sim_time_ns < camera.due_ns - kSlack_ns) continue;
    if (sim_time_ns == camera.last_ns) continue;  // paused
    camera.request.node = camera.node.c_str();
    camera.request.parent_from_camera = convert::kSensorFromCamera;
    camera.request.when = FIRE3DV_IMAGE_ONCE;
    const Result<uint64_t> id = publisher.request_image(camera.request);
    if (!id) {
      refuse(name, camera, id.error().message);
      continue;
    }
    camera.pending = *id;
    camera.last_ns = sim_time_ns;
    // Missed images are not made up for.
    const bool is_late = camera.due_ns == INT64_MIN || sim_time_ns >= camera.due_ns + camera.period_ns;
    camera.due_ns = (is_late ? sim_time_ns : camera.due_ns) + camera.period_ns;
  }
  return std::exchange(warnings_, {});
}

std::vector<std::string> Cameras::deliver(Node& node, Publisher& publisher) {
  for (auto& [name, camera] : cameras_) {
    if (camera.pending == 0) continue;
    const Result<Image> image = publisher.take_image(camera.pending);
    if (!image) {
      refuse(name, camera, image.error().message);
      continue;
    }
    if (!*image) continue;
    camera.pending = 0;
    camera.refusals = 0;
    if ((*image)->sequence == 0) continue;  // shows no frame
    // It may show a later frame than the requested one.
    if ((*image)->sim_time_ns > camera.last_ns) {
      camera.last_ns = (*image)->sim_time_ns;
      camera.due_ns = camera.last_ns + camera.period_ns;
    }
    node.publish(camera.topic, image_message(**image, camera.frame_id));
    node.publish(camera.info_topic, camera_info_message(**image, camera.frame_id));
  }
  return std::exchange(warnings_, {});
}

}  // namespace fire3dv::gazebo
