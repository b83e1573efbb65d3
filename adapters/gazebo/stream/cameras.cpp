#include "adapters/gazebo/stream/cameras.h"

#include <algorithm>
#include <utility>

#include "adapters/gazebo/stream/camera_messages.h"
#include "base/clock.h"
#include "base/text.h"
#include "convert/sdf/sdf_scene.h"
#include "gazebo.pb.h"

namespace fire3dv::gazebo {
namespace {

constexpr size_t kMaxKnownBytes = 1000;  // of a list of names in a message

// Equal for cameras whose images are equal.
std::string digest_of(pb::Sensor sensor) {
  sensor.clear_id();
  sensor.clear_pose();
  return sensor.SerializeAsString();
}

}  // namespace

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
      if (known.size() < kMaxKnownBytes) known += (known.empty() ? "" : ", ") + quote(entity.name);
      const auto wanted = std::find_if(
          choice_.names.begin(), choice_.names.end(),
          [&](const std::string& name) { return name == entity.name || name == entity.sensor->name(); });
      if (wanted != choice_.names.end()) std::erase(missing, *wanted);
      if (!choice_.all && wanted == choice_.names.end()) continue;
      Camera camera{.node = entity.node, .digest = digest_of(*entity.sensor)};
      const auto before = cameras_.find(entity.name);
      if (before != cameras_.end() && before->second.digest == camera.digest) {
        before->second.node = entity.node;
        next.insert(cameras_.extract(before));
        continue;
      }
      Result<CameraSpec> spec = camera_spec(item, i, world);
      if (!spec) {
        warnings_.push_back("camera " + quote(entity.name) + " has no images: " + spec.error().message);
        continue;
      }
      camera.spec = std::move(*spec);
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

void Cameras::advertise(Node& node, const std::string& topic, const char* type) {
  if (cannot_publish_ || node.is_advertised(topic)) return;
  const Result<void> advertised = node.advertise(topic, prefix_ + type);
  if (advertised) return;
  cannot_publish_ = true;
  warnings_.push_back(advertised.error().message);
}

std::vector<std::string> Cameras::request(Node& node, Publisher& publisher, int64_t sim_time_ns) {
  for (auto& [name, camera] : cameras_) {
    for (const CameraSpec::Topic& topic : camera.spec.images) advertise(node, topic.name, "Image");
    advertise(node, camera.spec.info_topic, "CameraInfo");
    const bool is_advertised = node.is_advertised(camera.spec.info_topic);  // the last one
    if (!is_advertised || camera.node.empty() || camera.pending != 0 || monotonic_ns() < camera.retry_ns)
      continue;
    const bool has_subscribers =
        node.has_subscribers(camera.spec.info_topic) ||
        std::any_of(camera.spec.images.begin(), camera.spec.images.end(),
                    [&](const CameraSpec::Topic& topic) { return node.has_subscribers(topic.name); });
    if (!has_subscribers) continue;
    if (sim_time_ns < camera.last_ns) camera.due_ns = INT64_MIN;  // a reset
    constexpr int64_t kSlack_ns = 1'000'000;                      // poses come at times of their own
    if (camera.due_ns != INT64_MIN && sim_time_ns < camera.due_ns - kSlack_ns) continue;
    if (sim_time_ns == camera.last_ns) continue;  // paused
    camera.spec.request.node = camera.node.c_str();
    camera.spec.request.parent_from_camera = convert::kSensorFromCamera;
    camera.spec.request.when = FIRE3DV_IMAGE_ONCE;
    const Result<uint64_t> id = publisher.request_image(camera.spec.request);
    if (!id) {
      refuse(name, camera, id.error().message);
      continue;
    }
    camera.pending = *id;
    camera.last_ns = sim_time_ns;
    // Missed images are not made up for.
    const bool is_late = camera.due_ns == INT64_MIN || sim_time_ns >= camera.due_ns + camera.spec.period_ns;
    camera.due_ns = (is_late ? sim_time_ns : camera.due_ns) + camera.spec.period_ns;
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
      camera.due_ns = camera.last_ns + camera.spec.period_ns;
    }
    for (const CameraSpec::Topic& topic : camera.spec.images)
      node.publish(topic.name, image_message(**image, topic.output, camera.spec.frame_id));
    node.publish(camera.spec.info_topic, camera_info_message(**image, camera.spec.frame_id));
  }
  return std::exchange(warnings_, {});
}

}  // namespace fire3dv::gazebo
