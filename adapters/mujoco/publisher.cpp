#include "adapters/mujoco/publisher.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <tuple>
#include <utility>

#include "adapters/generic/call_client.h"
#include "base/numbers.h"
#include "convert/glb/write_glb.h"
#include "convert/model.h"

namespace fire3dv::mujoco {

namespace {

std::array<float, 4> color_of(const mjModel& m, size_t geom) {
  return convert::compiled_color(m, m.geom_matid[geom], m.geom_rgba + 4 * geom);
}

bool is_shown(const mjModel& m, size_t geom, const std::array<float, 4>& rgba) {
  return convert::is_shown_group(m.geom_group[geom]) && rgba[3] > 0;
}

}  // namespace

GeomAppearance::GeomAppearance(const mjModel& m) : appearances_(static_cast<size_t>(m.ngeom)) {
  for (size_t i = 0; i < appearances_.size(); ++i) {
    Appearance& appearance = appearances_[i];
    appearance.rgba = color_of(m, i);
    appearance.is_shown = appearance.is_in_scene = is_shown(m, i, appearance.rgba);
  }
}

const std::vector<GeomEdit>& GeomAppearance::changes(const mjModel& m) {
  changes_.clear();
  for (size_t i = 0; i < appearances_.size(); ++i) {
    Appearance& appearance = appearances_[i];
    if (!appearance.is_in_scene) continue;
    const std::array<float, 4> rgba = color_of(m, i);
    const bool shown = is_shown(m, i, rgba);
    if (rgba == appearance.rgba && shown == appearance.is_shown) continue;
    GeomEdit edit{i, {}, {}};
    if (shown != appearance.is_shown) edit.visible = shown;
    if (rgba != appearance.rgba && shown) {
      const glm::vec4 linear = convert::linear_from_srgb(glm::vec4(rgba[0], rgba[1], rgba[2], rgba[3]));
      edit.rgba = {linear.r, linear.g, linear.b, linear.a};
      appearance.rgba = rgba;
    }
    appearance.is_shown = shown;
    changes_.push_back(edit);
  }
  return changes_;
}

namespace {

// rows: 3x3 matrix, row-major, as in mjData.
float* put(float* pose, const mjtNum* position, const mjtNum* rows) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) *pose++ = static_cast<float>(rows[3 * row + column]);
    *pose++ = static_cast<float>(position[row]);
  }
  return pose;
}

float* put(float* pose, const glm::dvec3& position, const glm::dmat3& linear) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) *pose++ = static_cast<float>(linear[column][row]);
    *pose++ = static_cast<float>(position[row]);
  }
  return pose;
}

glm::dvec3 vec3(const mjtNum* v) {
  return {v[0], v[1], v[2]};
}

}  // namespace

StreamedNodes::StreamedNodes(const mjModel& m, const convert::MjcfNames& names) {
  names_.assign(names.bodies.begin() + 1, names.bodies.end());  // skips the world body, which never moves
  names_.insert(names_.end(), names.cameras.begin(), names.cameras.end());
  for (int light = 0; light < m.nlight; ++light) {
    if (!convert::is_scene_light(m, light)) continue;
    lights_.push_back(light);
    names_.push_back(names.lights[static_cast<size_t>(light)]);
  }
  for (int tendon = 0; tendon < m.ntendon; ++tendon) {
    const auto& pieces = names.tendon_pieces[static_cast<size_t>(tendon)];
    const auto& ends = names.tendon_ends[static_cast<size_t>(tendon)];
    if (pieces.empty()) continue;
    tendons_.push_back(tendon);
    names_.insert(names_.end(), pieces.begin(), pieces.end());
    names_.insert(names_.end(), ends.begin(), ends.end());
  }
}

void StreamedNodes::write(const mjModel& m, const mjData& d, std::vector<float>& poses) {
  poses.resize(12 * names_.size());
  float* pose = poses.data();
  for (int body = 1; body < m.nbody; ++body) pose = put(pose, d.xpos + 3 * body, d.xmat + 9 * body);
  for (int camera = 0; camera < m.ncam; ++camera)
    pose = put(pose, d.cam_xpos + 3 * camera, d.cam_xmat + 9 * camera);  // looks along -Z, as in glTF
  for (const int light : lights_) {
    pose = put(pose, vec3(d.light_xpos + 3 * light),
               glm::mat3_cast(convert::shining(vec3(d.light_xdir + 3 * light))));
  }
  for (const int tendon : tendons_) {
    convert::tendon_pieces(m, d, tendon, pieces_);
    convert::tendon_frames(pieces_, convert::max_tendon_points(m, tendon), frames_);
    for (const convert::TendonFrame& frame : frames_) {
      pose = put(pose, frame.position,
                 glm::dmat3(frame.scale.x * frame.turn[0], frame.scale.y * frame.turn[1],
                            frame.scale.z * frame.turn[2]));
    }
  }
  FIRE3DV_ASSERT(pose == poses.data() + poses.size());
}

namespace {

using Clock = std::chrono::steady_clock;

// Rotates MuJoCo's Z up to glTF's Y up.
const std::vector<double> kWorldFromStream = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0};

}  // namespace

Publisher::Publisher(const mjModel& m, convert::MjcfNames names, const PublishOptions& options)
    : names_(std::move(names)),
      nodes_(m, names_),
      appearances_(m),
      markers_(options.show),
      clock_(options.rate_hz),
      bodies_(m.nbody),
      cameras_(m.ncam),
      lights_(m.nlight),
      tendons_(m.ntendon),
      geoms_(m.ngeom) {
  if (options.joint_scalars) joints_.emplace(m);
}

Result<Publisher> Publisher::open(const mjModel& model, const PublishOptions& options) {
  Publisher publisher(model, convert::names_of(model), options);
  Description description;
  description.node_names = publisher.nodes_.names();
  description.world_from_stream = kWorldFromStream;
  const double step_rate_hz = model.opt.timestep > 0 ? 1 / model.opt.timestep : 0;
  description.nominal_rate_hz = options.rate_hz > 0 ? std::min(options.rate_hz, step_rate_hz) : step_rate_hz;
  description.scene_uri = options.scene_uri;
  for (const std::string& uri : options.uris) {
    const Result<void> opened = call_client("cannot publish to", uri, [&] {
      Stream stream(uri, options.adapter_name, options.security);
      stream.describe(description);
      publisher.targets_.push_back({uri, std::move(stream)});
    });
    if (!opened) return opened.error();
    if (!publisher.joints_) continue;
    if (Result<void> declared = publisher.joints_->declare(publisher.targets_.back().stream.get()); !declared)
      return Error{"cannot send the joints to " + uri + ": " + declared.error().message};
  }
  return publisher;
}

int64_t Publisher::sim_time_ns(const mjData& data) {
  constexpr double kMaxSeconds = 9e9;  // limit of int64 nanoseconds: 285 years
  return std::llround(std::clamp(data.time, -kMaxSeconds, kMaxSeconds) * 1e9);
}

Result<bool> Publisher::publish(const mjModel& model, const mjData& data) {
  if (std::tie(model.nbody, model.ncam, model.nlight, model.ntendon, model.ngeom) !=
      std::tie(bodies_, cameras_, lights_, tendons_, geoms_))
    return Error{"this is not the model that the stream was opened for: open another one for it"};
  if (!due(data)) return false;
  nodes_.write(model, data, poses_);
  if (Result<void> sent = send_appearance(model); !sent) return sent.error();
  if (Result<void> sent = send_markers(model, data); !sent) return sent.error();
  if (Result<void> sent = send_joints(data); !sent) return sent.error();
  const int64_t now_ns = sim_time_ns(data);
  const uint32_t flags = clock_.published(now_ns) ? FIRE3DV_FRAME_DISCONTINUITY : 0;
  ++sequence_;
  for (Target& target : targets_) {
    const Result<void> sent = call_client("cannot publish to", target.uri, [&] {
      target.stream.publish(std::chrono::nanoseconds(now_ns), poses_.data(), poses_.size() / 12, flags);
    });
    if (!sent) return sent.error();
  }
  return true;
}

Result<void> Publisher::send_appearance(const mjModel& model) {
  for (const GeomEdit& edit : appearances_.changes(model)) {
    const std::string& name = names_.geoms[edit.geom];
    for (Target& target : targets_) {
      const Result<void> sent = call_client("cannot send the appearance of a geom to", target.uri, [&] {
        if (edit.visible) target.stream.set_visible(name, *edit.visible);
        if (edit.rgba) target.stream.set_base_color(name, *edit.rgba);
      });
      if (!sent) return sent;
    }
  }
  return {};
}

Result<void> Publisher::send_markers(const mjModel& model, const mjData& data) {
  for (const SimulationMarker& marker : markers_.update(model, data)) {
    if (!marker.is_changed) continue;
    const fire3dv_marker view = marker_of(marker);
    for (Target& target : targets_) {
      if (fire3dv_set_marker(target.stream.get(), marker.name, &view) != FIRE3DV_OK)
        return Error{"cannot send the marker " + std::string(marker.name) + " to " + target.uri + ": " +
                     fire3dv_last_error()};
    }
  }
  return {};
}

Result<void> Publisher::send_joints(const mjData& data) {
  for (Target& target : targets_) {
    if (!joints_) break;
    if (Result<void> sent = joints_->set(target.stream.get(), data, sim_time_ns(data)); !sent)
      return Error{"cannot send the joints to " + target.uri + ": " + sent.error().message};
  }
  return {};
}

Result<void> Publisher::wait_shown(double timeout_s, const std::atomic<bool>& stop,
                                   const std::function<void(const std::string& sentence)>& say) {
  constexpr std::chrono::seconds kReportedWait{3};
  if (sequence_ == 0) return {};
  const auto begun = Clock::now();
  const auto deadline = begun + std::chrono::duration<double>(timeout_s);
  for (Target& target : targets_) {
    bool shown = false;
    while (!shown && !stop) {
      const Result<void> waited = call_client("cannot wait for", target.uri, [&] {
        shown = target.stream.wait_ack(sequence_, std::chrono::milliseconds(100));  // short, so that `stop`
                                                                                    // is checked
      });
      if (!waited) return waited;
      if (!shown && !target.has_reported_wait && Clock::now() - begun >= kReportedWait) {
        target.has_reported_wait = true;
        say("waiting for a renderer at " + target.uri + " to show frame " + std::to_string(sequence_));
      }
      if (!shown && Clock::now() >= deadline)
        return Error{"no renderer on " + target.uri + " has shown frame " + std::to_string(sequence_) +
                     " in time: start one that listens there, or wait longer"};
    }
  }
  return {};
}

std::vector<fire3dv_stream*> Publisher::streams() {
  std::vector<fire3dv_stream*> streams;
  for (Target& target : targets_) streams.push_back(target.stream.get());
  return streams;
}

Result<std::vector<Publisher::Link>> Publisher::poll() {
  std::vector<Link> links;
  for (Target& target : targets_) {
    const Result<void> polled = call_client("cannot poll", target.uri, [&] {
      links.push_back({target.uri, target.stream.poll()});
    });
    if (!polled) return polled.error();
  }
  return links;
}

Result<std::vector<std::byte>> scene_of(const mjModel& model, const mjData& data, const std::string& name,
                                        std::vector<std::string>& warnings) {
  convert::Model made;
  made.name = name;
  convert::ReadOptions options;
  options.geoms_apart = true;
  convert::add_mjcf(model, data, options, made);
  convert::add_light_if_none(made);
  Result<std::vector<std::byte>> glb = convert::write_glb(made, &made.warnings);
  warnings.insert(warnings.end(), made.warnings.begin(), made.warnings.end());
  return glb;
}

namespace {

Result<std::string> camera_node(const mjModel& m, const convert::MjcfNames& names,
                                const std::string& camera) {
  if (const int found = mj_name2id(&m, mjOBJ_CAMERA, camera.c_str()); found >= 0)
    return names.cameras[static_cast<size_t>(found)];
  if (camera == names.free_camera) return names.free_camera;
  if (const auto number = parse_number<size_t>(camera); number && *number < names.cameras.size())
    return names.cameras[*number];
  std::string known = "\"" + names.free_camera + "\"";
  for (const std::string& name : names.cameras) known += ", \"" + name + "\"";
  return Error{"the model has no camera \"" + camera + "\"; it has " + known};
}

}  // namespace

Result<uint64_t> Publisher::request_images(const mjModel& model, const ImageSpec& spec) {
  if (targets_.empty()) return Error{"no renderer to request images from: give its URI with --to"};
  const Result<std::string> node = camera_node(model, names_, spec.camera);
  if (!node) return node.error();
  fire3dv_image_request request{};
  request.node = node->c_str();
  request.width = spec.width;
  request.height = spec.height;
  request.outputs = spec.outputs;
  request.when = FIRE3DV_IMAGE_EVERY_NTH;
  uint64_t id = 0;
  const Result<void> requested = call_client("cannot request images", targets_[0].uri,
                                             [&] { id = targets_[0].stream.request_image(request); });
  if (!requested) return requested.error();
  return id;
}

Result<Image> Publisher::wait_image(uint64_t id, double timeout_s, const std::atomic<bool>& stop) {
  const auto deadline = Clock::now() + std::chrono::duration<double>(timeout_s);
  uint64_t lost = 0;  // images lost or skipped here
  while (!stop) {
    Image image;
    const Result<void> waited = call_client("no images from", targets_[0].uri, [&] {
      image = targets_[0].stream.wait_image(id, std::chrono::milliseconds(100));  // short, so that `stop` is
                                                                                  // checked
    });
    if (!waited) return waited.error();
    if (image && image->sequence == sequence_) {
      image->lost += lost;
      return image;
    }
    if (image) lost += image->lost + (image->sequence > 0 ? 1 : 0);  // sequence 0: shows no frame
    if (Clock::now() >= deadline)
      return Error{"no renderer on " + targets_[0].uri + " has sent an image of frame " +
                   std::to_string(sequence_) + " in time: start one that listens there, or wait longer"};
  }
  return Image();
}

Result<Image> Publisher::take_image(uint64_t id) {
  Image image;
  const Result<void> taken = call_client("no images from", targets_[0].uri, [&] {
    image = targets_[0].stream.wait_image(id, std::chrono::milliseconds(0));
  });
  if (!taken) return taken.error();
  return image;
}

}  // namespace fire3dv::mujoco
