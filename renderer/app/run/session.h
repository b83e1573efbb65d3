// Session of one document: its scene on the device, its links, views and frame loop. Another document gets
// another session.
#pragma once

#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/process/stop_deadline.h"
#include "renderer/app/device_uploader.h"
#include "renderer/app/document.h"
#include "renderer/app/loop/frame_loop.h"
#include "renderer/app/options/options.h"
#include "renderer/app/recording.h"
#include "renderer/app/run/application.h"
#include "renderer/app/start.h"
#include "renderer/browser/live_view.h"
#include "renderer/browser/viewer_replies.h"
#include "renderer/camera/camera_rig.h"
#include "renderer/editing/edit_session.h"
#include "renderer/live_scene/live_scene.h"
#include "renderer/loading/scene_reload.h"
#include "renderer/sinks/file_sink.h"
#include "renderer/sinks/frame.h"
#include "renderer/state/pose_state.h"
#include "renderer/streams/stream_receiver.h"
#include "renderer/window/window_view.h"

namespace fire3dv::app {

class Session {
 public:
  // Waits for the scene, opens links and files, uploads the scene and applies the overlay. Null: the user has
  // closed the window meanwhile. Borrows both. notice: shown to the user; empty: none.
  static Result<std::unique_ptr<Session>> open(Application& application, Document& document,
                                               const std::string& notice);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  // Runs the frame loop until it ends.
  Result<void> loop() { return loop_->run(); }
  // Completes files and reports of the run. looped: result of loop(), whose error is returned. Else returns
  // the next document that the user opened, or null.
  Result<std::unique_ptr<Document>> close(const Result<void>& looped);

 private:
  Session(Application& application, Document& document);
  Result<bool> wait_for_scene();  // false: the user has closed the window
  Result<void> choose_camera();
  Result<void> open_links(const std::string& notice);
  Result<void> upload();
  void create_scene();
  void watch_file();
  void show_reloaded(std::unique_ptr<SceneLoad> load);
  Result<void> apply_overlay();
  Result<void> create_views();
  Result<void> create_loop();
  int finish_recording();
  const scene::Scene& scene() const { return loaded_->scene; }  // as loaded
  std::vector<uint32_t> playing() const {
    return animations_ ? animations_->chosen : std::vector<uint32_t>();
  }
  const state::RobotPose* robot() const { return robot_ ? &*robot_ : nullptr; }

  // Detaches the windows from the device at the end.
  struct AttachedWindows {
    explicit AttachedWindows(const Windows& borrowed) : windows(borrowed) {}
    ~AttachedWindows() {
      for (const OpenWindow& open : windows) open.window->detach();
    }
    const Windows& windows;
  };

  Application& application_;
  Document& document_;
  SceneLoad& load_;  // of the document at the start; a reload adds another one
  Options options_;
  sinks::Window* const window_;  // the first one; null: headless
  const scene::LoadedScene* loaded_ = nullptr;
  std::optional<Playing> animations_;
  OverlayFile overlay_file_;  // before the overlay is read
  state::EditDocument overlay_;
  std::optional<CameraRig> camera_;
  std::unique_ptr<Recording> recording_;  // outlives the listeners, whose threads record
  std::optional<state::PoseState> poses_;
  std::optional<StreamReceiver> receiver_;
  std::optional<ViewerReplies> replies_;
  std::optional<ImageRequestQueue> requests_;
  std::optional<DocumentLoader> next_;
  replay::ReplayLink* timeline_ = nullptr;  // owned by the receiver; null: no replay
  std::unique_ptr<sinks::FileSink> image_folder_;
  sinks::NullSink no_files_;
  std::optional<AttachedWindows> attached_;
  std::optional<state::RobotPose> robot_;  // with a window, viewers or an overlay
  bool moves_robot_ = false;
  std::optional<DeviceUploader> uploader_;
  std::optional<LiveScene> live_;
  std::optional<EditSession> editor_;
  std::optional<SceneReload> reload_;
  std::unique_ptr<WindowView> view_;
  std::optional<LiveView> live_view_;
  std::optional<FrameLoop> loop_;
  // Last: they use the files above.
  std::optional<ExitTask> recording_end_;
  std::list<ExitTask> exit_tasks_;
};

}  // namespace fire3dv::app
