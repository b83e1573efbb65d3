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
  if (message.kind == Kind::input) return apply_input(number, message);
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

// Rate limit: one answer per kInspectPeriod.
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
    case Kind::setting:
      return apply_setting(number, message);
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

// Of an earlier list: the input may be another one meanwhile.
void LiveView::apply_input(serve::ViewerId number, const serve::ClientMessage& message) {
  const InputList::Entry* const entry = inputs_.find(message.number, *message.index);
  if (!entry) return;
  wire::InputEvent event;
  event.input = entry->name;
  event.action = message.action;
  event.value = message.x;
  event.text = message.value;
  (void)borrowed_.receiver.inputs().act(entry->epoch, input_viewer(number), std::move(event));
}

bool LiveView::can_draw(settings::DrawSettings wanted) const {
  wanted.max_textures = borrowed_.renderer.settings().draw().max_textures;
  return borrowed_.replace_renderer || !borrowed_.renderer.needs_new_renderer(wanted);
}

// All images that viewers wait for are requested again.
void LiveView::replace_renderer(serve::ViewerId number, const settings::DrawSettings& wanted) {
  if (const auto open = borrowed_.requests.open(); !open.empty() && open.front().first < kFirstViewer)
    return borrowed_.server.send(
        number,
        notice_message("simulators have open requests of images: the renderer stays until those end"));
  for (auto& [of, viewer] : viewers_) {
    borrowed_.requests.on_requester_ended(kFirstViewer + of);
    viewer.flight.reset();
    viewer.pick.reset();
    viewer.is_in_turn = viewer.is_refined = false;
    viewer.samples = 0;
    viewer.has_moved = true;
  }
  if (Result<void> replaced = borrowed_.replace_renderer(wanted); !replaced)
    return borrowed_.server.send(number, notice_message(replaced.error().message));
  borrowed_.document.draw = wanted;
}

void LiveView::apply_setting(serve::ViewerId number, const serve::ClientMessage& message) {
  const auto& table = settings::draw_setting_table();
  const auto row = std::ranges::find(table, message.setting, &settings::DrawSetting::name);
  settings::DrawSettings& draw = borrowed_.document.draw;
  if (row == table.end() || !(row->users & settings::kByBrowser) || *message.index >= row->controls.size() ||
      !is_enabled(*row, draw))
    return;
  settings::DrawSettings wanted = draw;
  const settings::SettingControl& control = row->controls[*message.index];
  if (const std::string wrong = control.set(message.value, wanted); !wrong.empty() || !can_draw(wanted))
    return;
  has_changed_ = true;
  settings::keep_path_settings(draw.path.has_value(), wanted, borrowed_.document.paths);
  wanted.max_textures = borrowed_.renderer.settings().draw().max_textures;
  if (borrowed_.renderer.needs_new_renderer(wanted)) return replace_renderer(number, wanted);
  // Samples of paths that are there get other tone mapping.
  const bool keeps_samples = draw.path && compare(draw, wanted) <= settings::Invalidates::post;
  draw = wanted;
  borrowed_.renderer.apply(draw);
  for (auto& [of, viewer] : viewers_)
    (keeps_samples && viewer.is_refined ? viewer.is_retouched : viewer.has_moved) = true;
}

}  // namespace fire3dv::app
