// Messages of viewers: camera and display of one viewer, and what all of them share.
#include "renderer/browser/live_view.h"

#include <algorithm>

#include "renderer/browser/live_joints.h"
#include "renderer/browser/live_messages.h"
#include "renderer/settings/setting_table.h"

namespace fire3dv::app {
namespace {

using Kind = serve::ClientMessage::Kind;

constexpr auto kInspectPeriod = std::chrono::milliseconds(20);

}  // namespace

void LiveView::apply(serve::ViewerId number, Viewer& viewer, const serve::ClientMessage& message,
                     replay::TimelineControl* timeline) {
  const state::PoseState& poses = borrowed_.poses;
  const auto x = static_cast<float>(message.x), y = static_cast<float>(message.y),
             z = static_cast<float>(message.z);
  const Clock::time_point now = Clock::now();
  if (message.kind == Kind::shown) {
    if (!viewer.flight || viewer.flight->number != message.number) return;
    if (!viewer.flight->is_refined)
      viewer.quality.on_shown(std::chrono::duration<double>(now - viewer.flight->begun).count());
    viewer.flight.reset();
    return;
  }
  if (message.kind == Kind::codec) {
    viewer.decodes_h264 = message.on;
    viewer.decodes_vp8 = message.vp8;
    viewer.needs_key = true;
    viewer.has_moved = true;
    return;
  }
  if (message.kind == Kind::quality) {
    viewer.quality.prefer_sharp(message.on);
    viewer.has_moved = true;
    return;
  }
  if (message.kind == Kind::plotted) return viewer.plots.on_plotted(message.number, now);
  if (message.kind != Kind::inspect) viewer.changed = now;
  const bool is_other_scene = message.node && message.scene != scene_number_;
  if (is_other_scene || (message.node && *message.node >= borrowed_.scene.scene().nodes.size())) return;
  if (message.kind == Kind::inspect) return send_inspected(number, viewer, *message.node, now);
  if (serve::needs_control(message.kind)) return apply_shared(number, message, timeline);
  if (message.kind == Kind::size) {
    viewer.width = message.width;
    viewer.height = message.height;
    viewer.can_refine = true;
  }
  if (apply_view(viewer, message) || viewer.width == 0) return;  // the canvas comes first
  if (message.kind == Kind::pick) return request_pick(number, viewer, message.x, message.y);
  if (message.kind == Kind::frame) {
    viewer.framing.emplace(message.node);
    return;
  }
  viewer.has_moved = true;
  switch (message.kind) {
    case Kind::orbit:
      return viewer.camera.orbit(poses, x, y);
    case Kind::pan:
      return viewer.camera.pan(poses, x, y);
    case Kind::zoom:
      return viewer.camera.zoom(poses, z, {x, y}, viewer.aspect());
    case Kind::fly:
      return viewer.camera.fly(poses, {x, y, z}, viewer.camera.scene_radius_m());
    default:
      return;
  }
}

// Framing looks at all of the scene: the newest wish of one viewer in a turn, those that wait longest first,
// and for a fifth of the time at most, so that nobody holds up the others.
void LiveView::frame_one() {
  const Clock::time_point begun = Clock::now();
  if (begun < next_framing_) return;
  Viewer* next = nullptr;
  for (auto& [number, viewer] : viewers_)
    if (viewer.framing && (!next || viewer.framed < next->framed)) next = &viewer;
  if (!next) return;
  const std::optional<uint32_t> node = *std::exchange(next->framing, std::nullopt);
  if (node)
    next->camera.frame_node(borrowed_.poses, *node, next->aspect());
  else
    next->camera.frame_all(next->aspect());
  next->framed = begun;
  next->has_moved = true;
  const Clock::time_point end = Clock::now();
  next_framing_ = end + 4 * (end - begun);
}

// A page asks about its selected node again and again; one that asks in haste gets fewer answers.
void LiveView::send_inspected(serve::ViewerId number, Viewer& viewer, uint32_t node, Clock::time_point now) {
  if (now - viewer.inspected < kInspectPeriod) return;
  viewer.inspected = now;
  borrowed_.server.send(
      number, picked_message("inspected", borrowed_.scene.scene(), borrowed_.poses, node, scene_number_));
}

// Messages that need no canvas. Returns false for others.
bool LiveView::apply_view(Viewer& viewer, const serve::ClientMessage& message) {
  if (message.kind == Kind::plot) {
    if (message.on)
      viewer.plots.open(scalars_, message.number, message.plotted);
    else
      viewer.plots.close();
    return true;
  }
  if (message.kind == Kind::camera || message.kind == Kind::view) viewer.framing.reset();
  if (message.kind == Kind::camera) {
    message.index ? viewer.camera.select(*message.index) : viewer.camera.let_go(borrowed_.poses);
    viewer.has_moved = true;
    return true;
  }
  if (message.kind != Kind::view) return false;
  const serve::ClientMessage::View& view = message.view;
  const auto& q = view.world_from_camera;
  viewer.camera.set_free_view(
      {glm::vec3(glm::dvec3(view.position_m[0], view.position_m[1], view.position_m[2])),
       glm::quat(glm::dquat(q[3], q[0], q[1], q[2])), static_cast<float>(view.focus_distance_m),
       static_cast<float>(view.vertical_fov_rad)});
  viewer.has_moved = true;
  return true;
}

void LiveView::apply_shared(serve::ViewerId number, const serve::ClientMessage& message,
                            replay::TimelineControl* timeline) {
  state::UserEdits& edits = borrowed_.document.edits;
  withdraw_refinements(Clock::now());
  switch (message.kind) {
    case Kind::hide:
      if (message.on)
        edits.hidden.insert(*message.node);
      else
        edits.hidden.erase(*message.node);
      break;
    case Kind::isolate:
      edits.isolated = message.node.value_or(scene::kNone);
      break;
    case Kind::show_all:
      edits.hidden.clear();
      edits.isolated = scene::kNone;
      break;
    case Kind::joint:
    case Kind::posture:
      return apply_joints(message);
    case Kind::render:
      return apply_render(number, message);
    default:
      if (timeline) apply_timeline(message, *timeline);
      return;
  }
  borrowed_.scene.set_user_edits(edits);
}

void LiveView::apply_timeline(const serve::ClientMessage& message, replay::TimelineControl& timeline) const {
  if (message.kind == Kind::play) message.on ? timeline.play() : timeline.pause();
  if (message.kind == Kind::step) message.on ? timeline.step() : timeline.step_back();
  if (message.kind != Kind::seek) return;
  const replay::TimelineState now = timeline.timeline();
  const double length = static_cast<double>(std::max(now.end_ns, now.start_ns) - now.start_ns);
  timeline.seek(now.start_ns + static_cast<uint64_t>(length * message.x));
}

void LiveView::apply_joints(const serve::ClientMessage& message) {
  if (!borrowed_.robot || message.scene != scene_number_) return;
  const state::RobotPose& robot = *borrowed_.robot;
  state::JointPositions& joints = borrowed_.document.edits.joints;
  has_changed_ = true;
  if (message.kind == Kind::joint) {
    (void)move_joint(robot, borrowed_.poses, *message.index, message.x, joints);
  } else if (!message.index) {
    joints.clear();
  } else if (*message.index < robot.robot().named_poses().size()) {
    joints = robot.positions_of(*message.index);
  }
}

// A renderer that has started without shadows has no passes for them.
bool LiveView::can_switch_shadows_on() const {
  settings::DrawSettings wanted = borrowed_.document.draw;
  if (wanted.shadows.method == settings::ShadowMethod::off) wanted.shadows.method = shadows_;
  wanted.max_textures = borrowed_.renderer.settings().draw().max_textures;
  return !borrowed_.renderer.needs_new_renderer(wanted);
}

// All images that viewers wait for are requested again.
void LiveView::switch_paths(serve::ViewerId number, bool on) {
  settings::DrawSettings& draw = borrowed_.document.draw;
  if (on == draw.path.has_value() || !borrowed_.replace_renderer) return;
  if (const auto open = borrowed_.requests.open(); !open.empty() && open.front().first < kFirstViewer)
    return borrowed_.server.send(
        number,
        notice_message("simulators have open requests of images: raster or paths stay until those end"));
  for (auto& [of, viewer] : viewers_) {
    borrowed_.requests.on_requester_ended(kFirstViewer + of);
    viewer.flight.reset();
    viewer.pick.reset();
    viewer.is_in_turn = viewer.is_refined = false;
    viewer.samples = 0;
    viewer.has_moved = true;
  }
  settings::DrawSettings wanted = draw;
  wanted.path.reset();
  if (on) wanted.path = borrowed_.document.paths;
  wanted.max_textures = borrowed_.renderer.settings().draw().max_textures;
  if (Result<void> replaced = borrowed_.replace_renderer(wanted); !replaced)
    return borrowed_.server.send(number, notice_message(replaced.error().message));
  draw = wanted;
}

void LiveView::apply_render(serve::ViewerId number, const serve::ClientMessage& message) {
  const settings::DrawSetting& tone_map = settings::draw_setting("tone-map");
  if (*message.index >= tone_map.names.size()) return;
  if (message.paths) switch_paths(number, *message.paths);
  settings::DrawSettings& draw = borrowed_.document.draw;
  (void)tone_map.set(tone_map.names[*message.index], draw);
  has_changed_ = true;
  if (draw.path) {  // tone mapping applies to the samples that are there; paths trace all shadows
    borrowed_.renderer.apply(draw);
    for (auto& [of, viewer] : viewers_) (viewer.is_refined ? viewer.is_retouched : viewer.has_moved) = true;
    return;
  }
  const bool has_shadows = draw.shadows.method != settings::ShadowMethod::off;
  if (has_shadows && !message.on) {
    shadows_ = draw.shadows.method;
    draw.shadows.method = settings::ShadowMethod::off;
  }
  if (!has_shadows && message.on && can_switch_shadows_on()) draw.shadows.method = shadows_;
  borrowed_.renderer.apply(draw);
  for (auto& [of, viewer] : viewers_) viewer.has_moved = true;
}

}  // namespace fire3dv::app
