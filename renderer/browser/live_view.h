// Live view in browsers (--serve), on the frame loop's side: a camera for each viewer, and its images by the
// path of image requests. A viewer has one image in flight, so nobody waits for a slow one.
// More than 60 members: each message of the page has a method, and most change several parts of a viewer.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "protocol/replay/replay_clock.h"
#include "renderer/browser/adaptive_quality.h"
#include "renderer/browser/live_inputs.h"
#include "renderer/browser/live_plots.h"
#include "renderer/browser/server/server.h"
#include "renderer/browser/viewer_replies.h"
#include "renderer/camera/camera_rig.h"
#include "renderer/editing/view_state.h"
#include "renderer/live_scene/live_scene.h"
#include "renderer/passes/path/traced_scene.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/state/pose_state.h"
#include "renderer/state/robot_pose.h"
#include "renderer/streams/stream_receiver.h"

namespace fire3dv::app {

class LiveView final : public ImageReplies {
 public:
  struct Borrowed {
    serve::Server& server;
    ViewerReplies& replies;
    StreamReceiver& receiver;
    const state::PoseState& poses;
    ImageRequestQueue& requests;
    LiveScene& scene;
    DocumentState& document;  // of the window and all viewers
    std::optional<state::RobotPose>& robot;
    passes::SceneRenderer& renderer;
    // Puts a renderer with these settings at the address of `renderer`, if there are no requests of images.
    // Empty: raster or paths stay, as at the start.
    std::function<Result<void>(const settings::DrawSettings&)> replace_renderer = {};
  };
  // camera: where new viewers begin. title: of the page.
  LiveView(const Borrowed& borrowed, const CameraRig& camera, std::string title);
  ~LiveView() override;
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  // Applies messages of viewers, and requests the images that are due. Call once a turn of the frame loop.
  // timeline: null without a replay.
  void poll(replay::TimelineControl* timeline);
  // True while a viewer waits for an image or has just moved: turns must be frequent.
  bool is_busy() const;
  // True if a viewer has changed what a window shows, since the last call.
  bool take_change() { return std::exchange(has_changed_, false); }
  bool has_viewers() const { return !viewers_.empty(); }
  size_t count_viewers(serve::Access access) const;
  const serve::Server& server() const { return borrowed_.server; }

  // ImageReplies of viewers.
  std::optional<Shown> shown(state::RequesterId requester) const override;
  void refuse_image(state::RequesterId requester, const wire::ImageRefused& refused, bool is_logged) override;
  bool send_image(state::RequesterId requester, const wire::ImageFrame& frame,
                  const transport::ListenerLink::FillPixels& fill) override;
  void set_samples(state::RequesterId requester, uint64_t request, uint32_t samples) override;

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr uint64_t kEpoch = 1, kSequence = 1;  // viewers have no stream of frames
  static constexpr uint32_t kImagePlace = 0, kPickPlace = 1;
  static constexpr auto kRefineAfter = std::chrono::milliseconds(200);
  struct Flight {
    uint64_t request = 0;
    Clock::time_point begun;
    AdaptiveQuality::Step step{};
    bool is_refined = false;
    uint32_t number = 0;   // 0: not rendered yet
    uint32_t samples = 0;  // paths: of each pixel
  };
  struct Viewer {
    serve::Access access{};
    CameraRig camera;
    uint64_t listed_number = 0;      // from 1; free again when the viewer leaves
    uint32_t width = 0, height = 0;  // of the canvas; 0: unknown
    float aspect() const { return static_cast<float>(width) / static_cast<float>(height); }
    ImageReplies::Appearance appearance = {};
    AdaptiveQuality quality = {};
    std::optional<Flight> flight = {};
    std::optional<std::array<uint64_t, 2>> drawn = {};  // revisions of the last requested image
    scene::Camera drawn_camera = {};                    // of that image
    bool has_moved = true;                              // the camera or the canvas, since then
    bool decodes_h264 = false, decodes_vp8 = false, needs_key = true;
    bool is_refined = false;  // the last requested image
    bool can_refine = true;   // no image of full size was refused for this canvas
    // Paths.
    uint32_t samples = 0;         // of the last refined image
    bool is_in_turn = false;      // its view refines; see take_turn()
    bool is_retouched = false;    // other tone mapping: the image is due again with the same samples
    std::string paths_text = {};  // as sent
    Clock::time_point paths_sent = {};
    std::optional<uint32_t> camera_node = {};             // as reported to the page
    std::optional<uint64_t> pick = {};                    // request
    std::optional<std::optional<uint32_t>> framing = {};  // wanted: of a node, or of the scene
    Clock::time_point framed = {};
    std::optional<std::optional<CameraRig::FreeView>> view = {};  // as reported to the page
    PlotFeed plots = {};
    uint64_t last_request = 0;
    uint32_t images = 0;  // sent
    Clock::time_point inspected = {};
    Clock::time_point changed = {};  // last message or requested image of a change
  };

  void apply(serve::ViewerId number, Viewer& viewer, const serve::ClientMessage& message,
             replay::TimelineControl* timeline);
  bool apply_view(Viewer& viewer, const serve::ClientMessage& message);
  void apply_shared(serve::ViewerId number, const serve::ClientMessage& message,
                    replay::TimelineControl* timeline);
  void apply_timeline(const serve::ClientMessage& message, replay::TimelineControl& timeline) const;
  void apply_joints(const serve::ClientMessage& message);
  void apply_input(serve::ViewerId number, const serve::ClientMessage& message);
  void apply_setting(serve::ViewerId number, const serve::ClientMessage& message);
  void replace_renderer(serve::ViewerId number, const settings::DrawSettings& wanted);
  bool can_draw(settings::DrawSettings wanted) const;
  void frame_one();
  void join(serve::ViewerId number, serve::Access access);
  CameraRig::Placed place(Viewer& viewer) const;
  void request_image(serve::ViewerId number, Viewer& viewer, Clock::time_point now);
  void note_moment();
  bool take_turn(Viewer& viewer, Clock::time_point now);
  bool lacks_samples(const Viewer& viewer) const;
  void withdraw_refinement(serve::ViewerId number, Viewer& viewer);
  void withdraw_refinements(Clock::time_point now);
  void send_path_progress(serve::ViewerId number, Viewer& viewer, Clock::time_point now);
  void request_pick(serve::ViewerId number, Viewer& viewer, double x, double y);
  void send_inspected(serve::ViewerId number, Viewer& viewer, uint32_t node, Clock::time_point now);
  void send_picked(serve::ViewerId number, uint32_t instance);
  void on_scene_replaced(const scene::Scene& after);
  void send_to_all(const std::string& text);
  void send_if_changed(std::string& sent, std::string text);
  void send_settings(Clock::time_point now);
  void send_plots(Clock::time_point now);
  void send_inputs(Clock::time_point now);
  void send_viewers();
  void report(Clock::time_point now, replay::TimelineControl* timeline);
  Viewer* find(state::RequesterId requester);

  const Borrowed borrowed_;
  CameraRig start_;
  const std::string title_;
  std::map<serve::ViewerId, Viewer> viewers_;
  bool viewers_changed_ = false;  // since send_viewers()
  uint64_t scene_number_ = 0;     // of the node numbers in messages
  // Messages as sent to all viewers; empty: to be written.
  struct Sent {
    std::string scene, visibility, settings, joints, joint_positions;
    std::set<uint32_t> hidden;  // in visibility
    uint32_t isolated = scene::kNone;
  };
  Sent sent_;
  Clock::time_point settings_sent_{};
  ScalarList scalars_;
  InputList inputs_;
  Clock::time_point inputs_sent_{};
  bool has_changed_ = false;             // since take_change()
  std::array<uint64_t, 2> revisions_{};  // of what images show: poses and scene
  passes::TracedScene moment_;           // paths: poses and edits of revisions_
  Clock::time_point next_framing_{};     // see frame_one()
  Clock::time_point reported_{};
  std::map<uint64_t, uint64_t> frames_of_stream_;  // by epoch, at reported_
};

}  // namespace fire3dv::app
