#include "adapters/ambf/session.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "adapters/ambf/log.h"

namespace fire3dv::ambf {
namespace {

constexpr int64_t kPollIntervalNs = 10'000'000;    // frequent enough for clock offset measurement
constexpr int64_t kLogIntervalNs = 1'000'000'000;  // rate of log lines, which allocate

}  // namespace

Result<std::unique_ptr<Session>> Session::start(const std::vector<std::string>& arguments,
                                                const std::filesystem::path& ambf_root, bool headless) {
  auto launch = read_launch(arguments, ambf_root);
  // AMBF has read this file. If the plugin cannot, only its options and cameras are missing.
  if (!launch.ok()) {
    log_line(launch.error().message + "; its options and cameras are left out");
    launch = Launch{};
  }
  if (!launch->options_fault.empty()) return Error{launch->options_fault};
  auto options = read_options(
      arguments, [](const char* name) { return std::getenv(name); }, launch->options);
  if (!options.ok()) return options.error();
  Links links;
  const auto opened = links.open(*options);
  if (!opened.ok()) {
    if (links.empty()) return opened.error();
    log_line(opened.error().message);
  }
  CameraDefinitions cameras;
  if (headless) cameras = read_cameras(*launch);
  for (const std::string& warning : cameras.warnings) log_line(warning);
  return std::make_unique<Session>(std::move(*options), std::move(cameras), std::move(links));
}

Session::Session(Options options, CameraDefinitions cameras, Links links)
    : options_(std::move(options)),
      cameras_(std::move(cameras.cameras)),
      listed_(std::move(cameras.listed)),
      links_(std::move(links)),
      rate_(options_.rate_hz),
      vertex_rate_(options_.vertex_rate_hz),
      signals_(std::make_unique<EndSignals>([this] { close(); })) {}

Session::~Session() {
  close();
}

bool Session::begin_turn(int64_t now_ns) {
  if (!turn_.try_lock()) return false;
  if (!closed_ && rate_.due(now_ns)) return true;
  turn_.unlock();
  return false;
}

// Returns objects in creation order: listed ones as in the files, objects of plugins or the window last.
std::vector<size_t> Session::order_added() const {
  std::map<std::pair<Kind, std::string>, size_t> places;
  for (const Listed& listed : listed_) places.emplace(std::pair(listed.kind, listed.key), places.size());
  std::vector<std::pair<size_t, size_t>> placed;
  for (size_t object = 0; object < objects_.size(); ++object) {
    const auto found = places.find({objects_[object].kind, objects_[object].key});
    placed.emplace_back(found == places.end() ? places.size() : found->second, object);
  }
  std::sort(placed.begin(), placed.end());
  std::vector<size_t> added;
  for (const auto& [place, object] : placed) added.push_back(object);
  return added;
}

void Session::describe(std::vector<Object> objects) {
  objects_ = std::move(objects);
  first_camera_ = objects_.size();
  for (const CameraDefinition& camera : cameras_) objects_.push_back({Kind::camera, camera.key, camera.name});
  camera_parents_.clear();
  const std::vector<size_t> added = cameras_.empty() ? std::vector<size_t>() : order_added();
  for (size_t i = 0; i < cameras_.size(); ++i) {
    const auto parent = find_parent(objects_, added, first_camera_ + i, cameras_[i].parent);
    camera_parents_.push_back(parent);
    if (!parent && !cameras_[i].parent.empty())
      log_line("camera '" + cameras_[i].key + "' has the parent '" + cameras_[i].parent +
               "', which is no one object of AMBF; it stands in the world");
  }
  nodes_ = NodeTable(objects_, options_.names);
  for (const std::string& warning : nodes_.warnings()) log_line(warning);
  world_from_object_.assign(objects_.size(), Transform());
  poses_.assign(nodes_.size() * 12, 0.0f);
  for (size_t node = 0; node < nodes_.size(); ++node) to_pose(Transform(), &poses_[node * 12]);
  links_.describe(nodes_.names(), options_.rate_hz);
  hide_removed();
  for (size_t i = 0; i < cameras_.size(); ++i) {
    if (cameras_[i].intrinsics) set_intrinsics(first_camera_ + i, *cameras_[i].intrinsics);
  }
  jumped_ = true;
}

// Hides nodes of removed objects, since the scene file still has them. A returning object is visible until
// set_shown changes it.
void Session::hide_removed() {
  std::set<const Sent*> here;
  sent_of_.assign(objects_.size(), nullptr);
  for (size_t object = 0; object < objects_.size(); ++object) {
    const auto node = nodes_.node_of(object);
    if (!node) continue;
    Sent& sent = sent_[nodes_.names()[*node]];
    here.insert(&sent);
    sent.pose_refused = false;
    sent_of_[object] = &sent;
  }
  for (auto& [name, sent] : sent_) {
    const bool gone = !here.contains(&sent);
    if (gone ? sent.shown : sent.gone && !sent.shown) show(name, sent, !gone);
    sent.gone = gone;
  }
}

void Session::show(const std::string& name, Sent& sent, bool shown) {
  sent.shown = shown;
  links_.edit(
      [&](fire3dv_stream* stream) { return fire3dv_set_visible(stream, name.c_str(), shown ? 1 : 0); });
}

void Session::set_shown(size_t object, bool shown) {
  Sent* const sent = sent_of_[object];
  if (sent && sent->shown != shown) show(nodes_.names()[*nodes_.node_of(object)], *sent, shown);
}

void Session::set_intrinsics(size_t object, const Intrinsics& intrinsics) {
  Sent* const sent = sent_of_[object];
  if (!sent || sent->intrinsics == intrinsics) return;
  sent->intrinsics = intrinsics;
  fire3dv_camera camera{};
  camera.struct_size = sizeof camera;
  camera.vertical_fov_rad = static_cast<float>(intrinsics.vertical_fov_rad);
  camera.near_m = static_cast<float>(intrinsics.near_m);
  camera.far_m = static_cast<float>(intrinsics.far_m);
  for (const char* const suffix : kViewSuffixes) {
    if (suffix != kViewSuffixes[0] && !intrinsics.two_eyes) break;
    const std::string name = nodes_.names()[*nodes_.node_of(object)] + suffix;
    links_.edit([&](fire3dv_stream* stream) { return fire3dv_set_camera(stream, name.c_str(), &camera); });
  }
}

// The scene file's version of a soft body stays removed while AMBF has none, like hidden objects.
void Session::set_soft_bodies(const std::vector<SoftMesh>& meshes) {
  const auto clear = [this](const std::string& name, int property) {
    links_.edit([&](fire3dv_stream* stream) { return fire3dv_clear(stream, name.c_str(), property); });
  };
  for (const std::string& name : soft_bodies_) {
    if (name.empty()) continue;
    clear(soft_vertices_path(name), FIRE3DV_PROPERTY_VERTICES);
    clear(soft_node_name(name), FIRE3DV_PROPERTY_NODE);
  }
  soft_bodies_.assign(meshes.size(), std::string());
  for (size_t i = 0; i < meshes.size(); ++i) {
    const std::string& name = meshes[i].name;
    const std::vector<std::byte> glb = soft_mesh_glb(meshes[i]);
    if (glb.empty()) {
      log_line("soft body '" + name + "' has no triangles, or no pose; it is skipped");
      if (removed_.erase(name) > 0) clear(name, FIRE3DV_PROPERTY_NODE);
      continue;
    }
    fire3dv_node node{};
    node.struct_size = sizeof node;
    node.asset_glb = glb.data();
    node.asset_glb_bytes = glb.size();
    // Replaces the file's mesh, whose vertices have another order.
    if (removed_.insert(name).second)
      links_.edit([&](fire3dv_stream* stream) { return fire3dv_remove_node(stream, name.c_str()); });
    links_.edit([&](fire3dv_stream* stream) {
      return fire3dv_add_node(stream, soft_node_name(name).c_str(), &node);
    });
    soft_bodies_[i] = name;
  }
}

void Session::set_vertices(size_t soft_body, const std::vector<float>& positions) {
  fire3dv_vertices vertices{};
  vertices.struct_size = sizeof vertices;
  vertices.positions = positions.data();
  vertices.vertex_count = positions.size() / 3;
  const std::string name = soft_vertices_path(soft_bodies_[soft_body]);
  links_.edit([&](fire3dv_stream* stream) { return fire3dv_set_vertices(stream, name.c_str(), &vertices); });
}

// Computes poses of cameras, which may be attached to other cameras. The step limit breaks cycles.
void Session::place_cameras() {
  for (size_t i = 0; i < cameras_.size(); ++i) {
    Transform world_from_camera = cameras_[i].parent_from_camera;
    auto parent = camera_parents_[i];
    for (size_t steps = 0; parent && steps <= cameras_.size(); ++steps) {
      if (*parent < first_camera_) {
        world_from_camera = world_from_object_[*parent] * world_from_camera;
        break;
      }
      const size_t next = *parent - first_camera_;
      world_from_camera = cameras_[next].parent_from_camera * world_from_camera;
      parent = camera_parents_[next];
    }
    world_from_object_[first_camera_ + i] = world_from_camera;
  }
}

// Converts poses for publishing. A body with a non-finite pose keeps its last one.
void Session::gather_poses() {
  for (size_t object = 0; object < objects_.size(); ++object) {
    const auto node = nodes_.node_of(object);
    if (!node || to_pose(world_from_object_[object], &poses_[*node * 12]) || sent_of_[object]->pose_refused)
      continue;
    sent_of_[object]->pose_refused = true;
    log_line("'" + nodes_.names()[*node] + "' has a pose that is not finite; its last pose is used");
  }
}

void Session::publish(double sim_time_s, int64_t now_ns) {
  if (nodes_.size() == 0) return;
  place_cameras();
  gather_poses();
  links_.publish(sim_time_s, poses_, jumped_.exchange(false) ? FIRE3DV_FRAME_DISCONTINUITY : 0);
  if (now_ns - polled_at_ns_ < kPollIntervalNs) return;
  polled_at_ns_ = now_ns;
  links_.poll();
  if (now_ns - reported_at_ns_ < kLogIntervalNs) return;
  reported_at_ns_ = now_ns;
  links_.log_answers();
}

void Session::jump() {
  jumped_ = true;
}

void Session::close() {
  const std::lock_guard<std::mutex> lock(turn_);
  closed_ = true;
  links_.close();
}

}  // namespace fire3dv::ambf
