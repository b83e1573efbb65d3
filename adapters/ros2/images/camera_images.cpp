#include "adapters/ros2/images/camera_images.h"

#include <fire3dv/client.h>
#include <fire3dv/image.h>
#include <fire3dv/scene.h>

#include <algorithm>
#include <array>
#include <utility>

#include "adapters/ros2/images/image_worker.h"
#include "base/log.h"
#include "base/plural.h"
#include "base/text.h"

namespace fire3dv::ros2 {
namespace {

constexpr std::chrono::milliseconds kCheckInterval{20};  // of readers that come and go
constexpr std::chrono::seconds kRetryInterval{2};        // after a refusal: nodes may come later
constexpr std::chrono::seconds kPatience{5};             // for a frame that tf does not have

}  // namespace

struct CameraImages::Camera {
  Camera(const CameraSpec& camera, CameraTopics opened)
      : spec(camera),
        topics(std::move(opened)),
        worker([this](const fire3dv_image& image) { return topics.publish(image); }) {}

  CameraSpec spec;
  CameraTopics topics;
  ImageWorker worker;    // uses topics
  uint64_t request = 0;  // 0: none
  uint32_t outputs = 0;  // of the request
  CameraMount mount;
  std::string added_node;  // as an edit, after a refusal
  uint64_t lost = 0;
  Clock::time_point retry_at{}, waits_since{};
  std::string problem;  // last reported
};

CameraImages::CameraImages(const Participant& participant, Names names, OpticalFrames frames, Log log)
    : participant_(participant), names_(std::move(names)), frames_(std::move(frames)), log_(std::move(log)) {}

CameraImages::~CameraImages() = default;

Result<std::unique_ptr<CameraImages>> CameraImages::open(const Participant& participant, const Names& names,
                                                         Log log) {
  Result<OpticalFrames> frames = OpticalFrames::open(participant, names);
  if (!frames) return frames.error();
  return std::unique_ptr<CameraImages>(
      new CameraImages(participant, names, std::move(*frames), std::move(log)));
}

bool CameraImages::has(const std::string& name) const {
  return std::any_of(specs_.begin(), specs_.end(), [&](const CameraSpec& spec) { return spec.name == name; });
}

Result<void> CameraImages::add(const CameraSpec& camera) {
  const std::string who = "camera " + quote(camera.name);
  if (specs_.size() >= kMaxCameras)
    return Error{who + ": there are " + std::to_string(kMaxCameras) + " already"};
  for (const CameraSpec& other : specs_) {
    if (other.name == camera.name) return Error{who + " is given twice"};
    if (names_.resolve(other.topic) == names_.resolve(camera.topic))
      return Error{who + " has the topic of camera " + quote(other.name) +
                   "; name another one by NAME:=TOPIC"};
    if (camera.publishes_frame && other.publishes_frame && other.optical_frame == camera.optical_frame)
      return Error{who + " has the frame of camera " + quote(other.name) +
                   "; name another one by optical=FRAME"};
  }
  Result<CameraTopics> topics = CameraTopics::open(participant_, names_, camera);
  if (!topics) return topics.error();
  cameras_.push_back(std::make_unique<Camera>(camera, std::move(*topics)));
  specs_.push_back(camera);
  next_check_ = {};
  return frames_.publish(specs_);
}

void CameraImages::report(Camera& camera, const std::string& problem) {
  if (problem != std::exchange(camera.problem, problem) && !problem.empty())
    log_(warning("camera " + quote(camera.spec.name) + ": " + problem));
}

void CameraImages::request(Camera& camera, fire3dv_stream* stream, const CameraMount& mount,
                           uint32_t outputs) {
  const CameraSpec& spec = camera.spec;
  const Intrinsics projection = intrinsics(spec);
  const Matrix34 pose = multiply(mount.node_from_frame, parent_from_camera(parent_from_optical(spec)));
  std::array<float, 12> node_from_camera{};
  std::transform(pose.begin(), pose.end(), node_from_camera.begin(),
                 [](double v) { return static_cast<float>(v); });
  fire3dv_image_request request{};
  request.struct_size = sizeof request;
  request.node = mount.node.empty() ? nullptr : mount.node.c_str();
  request.parent_from_camera = node_from_camera.data();
  request.width = spec.width;
  request.height = spec.height;
  request.fx = static_cast<float>(projection.fx);
  request.fy = static_cast<float>(projection.fy);
  request.cx = static_cast<float>(projection.cx);
  request.cy = static_cast<float>(projection.cy);
  request.near_m = static_cast<float>(spec.near_m);
  request.far_m = static_cast<float>(spec.far_m);
  request.lens = spec.lens == Lens::plumb_bob     ? FIRE3DV_LENS_PLUMB_BOB
                 : spec.lens == Lens::equidistant ? FIRE3DV_LENS_FISHEYE
                                                  : FIRE3DV_LENS_NONE;
  for (size_t i = 0; i < spec.lens_coefficients.size(); ++i)
    request.lens_coefficients[i] = static_cast<float>(spec.lens_coefficients[i]);
  request.outputs = outputs;
  request.when = spec.rate_hz > 0 ? FIRE3DV_IMAGE_RATE : FIRE3DV_IMAGE_EVERY_NTH;
  request.rate_hz = spec.rate_hz;
  const int code = fire3dv_request_image(stream, &request, &camera.request);
  if (code != FIRE3DV_OK) {
    camera.request = 0;
    if (code != FIRE3DV_ERROR_STATE) report(camera, fire3dv_last_error());  // STATE: not described yet
    return;
  }
  camera.outputs = outputs;
  camera.mount = mount;
}

void CameraImages::update_request(Camera& camera, fire3dv_stream* stream, const FindMount& find_mount,
                                  Clock::time_point now) {
  const uint32_t outputs = camera.topics.wanted_outputs();
  std::optional<CameraMount> mount;
  if (outputs != 0) {
    mount = find_mount(camera.spec.parent_frame);
    if (mount) {
      camera.waits_since = {};
    } else if (camera.waits_since == Clock::time_point{}) {
      camera.waits_since = now;
    } else if (now - camera.waits_since >= kPatience) {
      report(camera, "tf has no frame " + quote(camera.spec.parent_frame) +
                         " below the fixed frame; name one by parent=FRAME or optical=FRAME");
    }
  }
  if (camera.request != 0 && (!mount || outputs != camera.outputs || *mount != camera.mount)) {
    fire3dv_cancel_image(stream, camera.request);
    camera.request = 0;
  }
  // A robot that comes later brings the node itself.
  if (mount && !mount->node_may_be_missing && !camera.added_node.empty())
    fire3dv_clear(stream, std::exchange(camera.added_node, {}).c_str(), FIRE3DV_PROPERTY_NODE);
  if (camera.request == 0 && mount && now >= camera.retry_at) request(camera, stream, *mount, outputs);
}

// A frame that poses move and the scene lacks (a .glb without the robot's camera link) becomes an empty node,
// once.
bool CameraImages::add_node(Camera& camera, fire3dv_stream* stream) {
  if (camera.added_node == camera.mount.node) return false;
  camera.added_node = camera.mount.node;
  fire3dv_node empty{};
  empty.struct_size = sizeof empty;
  return fire3dv_add_node(stream, camera.mount.node.c_str(), &empty) == FIRE3DV_OK;
}

void CameraImages::take_image(Camera& camera, fire3dv_stream* stream, Clock::time_point now) {
  fire3dv_image* taken = nullptr;
  const int code = fire3dv_wait_image(stream, camera.request, 0, &taken);
  Image image(taken);
  if (code == FIRE3DV_ERROR_TIMEOUT) return;
  if (code != FIRE3DV_OK) {
    camera.request = 0;
    std::string problem = fire3dv_last_error();
    if (problem.starts_with("request ")) problem.erase(0, problem.find(": ") + 2);  // its number changes
    if (camera.mount.node_may_be_missing && add_node(camera, stream)) return;
    report(camera, problem);
    camera.retry_at = now + kRetryInterval;
    return;
  }
  camera.lost += image->lost;
  camera.problem.clear();
  // Before the first pose frame there is no time to stamp an image with.
  if (image->sequence != 0) camera.worker.submit(std::move(image));
}

void CameraImages::poll(fire3dv_stream* stream, const FindMount& find_mount, Clock::time_point now) {
  const bool checks = now >= next_check_;
  if (checks) next_check_ = now + kCheckInterval;
  for (const std::unique_ptr<Camera>& camera : cameras_) {
    if (checks) {
      update_request(*camera, stream, find_mount, now);
      if (const std::string failure = camera->worker.take_failure(); !failure.empty())
        report(*camera, failure);
    }
    if (camera->request != 0 && camera->worker.is_idle()) take_image(*camera, stream, now);
  }
}

std::chrono::milliseconds CameraImages::poll_interval() const {
  const bool has_request =
      std::any_of(cameras_.begin(), cameras_.end(),
                  [](const std::unique_ptr<Camera>& camera) { return camera->request != 0; });
  return has_request        ? std::chrono::milliseconds(1)
         : cameras_.empty() ? std::chrono::hours(1)
                            : kCheckInterval;
}

void CameraImages::log_counts() {
  for (const std::unique_ptr<Camera>& camera : cameras_) {
    const uint64_t published = camera->worker.published(), failed = camera->worker.failed();
    if (published + failed + camera->lost == 0) continue;
    log_("camera " + quote(camera->spec.name) + ": " + counted(published, "image") + " published, " +
         std::to_string(camera->lost) + " overtaken by newer ones, " + std::to_string(failed) +
         " not written");
  }
}

}  // namespace fire3dv::ros2
