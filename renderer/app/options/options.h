// Command line of the renderer.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/peer_budget.h"
#include "protocol/transport/http/access_rules.h"
#include "protocol/wire/image_outputs.h"
#include "renderer/app/options/recording_options.h"
#include "renderer/camera/default_look.h"
#include "renderer/editing/view_state.h"
#include "renderer/gpu/device/async_compute.h"
#include "renderer/loading/converted_scene.h"
#include "renderer/settings/debug_view.h"
#include "renderer/settings/draw_settings.h"
#include "renderer/settings/setting_table.h"
#include "renderer/streams/playout_options.h"
#include "renderer/window/present.h"

namespace fire3dv::app {

struct Options {
  std::chrono::steady_clock::time_point begun = std::chrono::steady_clock::now();
  std::filesystem::path scene;                          // empty: the scene attached to the recording
  ConvertOptions convert;                               // if the scene is a description file
  std::vector<std::string> listen;                      // URIs
  bool insecure = false;                                // allow listening on addresses other than loopback
  std::string key_file;                                 // udp: the pre-shared key
  std::string tls_certificate, tls_key, tls_client_ca;  // tls: PEM files
  std::string metrics;                                  // HOST:PORT; empty: no metrics
  std::string serve;                                    // HOST:PORT of the live view; empty: none
  std::filesystem::path serve_tokens;                   // file of its tokens; empty: new ones in each run
  transport::http::AllowedSites sites;                  // that --serve and --metrics answer
  PeerLimits peer_limits;                               // of each connected adapter
  double draw_time_factor = 2;                          // see state::DrawTimeSettings
  PlayOptions play;
  RecordingOptions recording;
  bool lockstep = false;              // one image per pose frame, acknowledged
  bool markers = true;                // of streams, in images of the window and of the program itself
  bool markers_in_data_sets = false;  // in the colours of images with other outputs, too

  bool headless = false;
  bool on_request = false;          // renders image requests only
  std::filesystem::path instances;  // list of instance numbers and names, kept up to date; empty: none
  uint32_t width = 1280, height = 720;
  bool panels = true;                // shown over the window's image
  std::optional<bool> light_panels;  // theme; nullopt: as in the last window
  sinks::Present present = sinks::Present::vsync;
  // One per window, the first window first; empty: one, with `camera`.
  std::vector<std::string> window_cameras;
  std::string right_camera;                 // second view in the first window; empty: none
  std::filesystem::path screenshots = ".";  // folder of screenshots and videos
  ScreenshotSize screenshot_size;
  std::string camera;      // node or camera name, or "auto"; empty: the scene's first, or one that frames it
  bool frame_all = false;  // moves the camera so that it shows the whole scene
  uint64_t frames = 0;     // 0 = unlimited
  bool wait_for_stream = false;  // write and count images from the first whole pose frame on
  std::chrono::duration<double> stream_timeout{0};  // 0 = none
  bool exit_when_done = false;                      // end when the last stream has ended
  std::filesystem::path assets;                     // root folder of assets added by streams; empty: none
  std::string animate;                              // an animation's name, its index, or "all"; empty: none
  std::filesystem::path overlay;                    // file of the user's edits; empty: none
  std::string variant;                              // material variant of the scene; empty: default materials
  bool watch = true;                                // reload the scene when its file changes
  std::string cache = "auto";                       // auto, off, beside or a folder: see disk_caches.h
  std::filesystem::path out;                        // folder of images; empty = none
  wire::ImageOutputs outputs;                       // outputs of each image in `out`
  std::filesystem::path stats;                      // CSV of times per frame; empty = none

  std::string device;
  // Devices for image requests, the first one also for everything else; empty: only `device`.
  std::string devices;
  bool require_gpu = false;  // see gpu/selection/required_gpu.h
  gpu::AsyncCompute async_compute = gpu::AsyncCompute::automatic;
  bool list_devices = false;
  bool validation = false;

  std::filesystem::path environment;  // Radiance HDR or OpenEXR image; empty: studio environment
  GroundMode ground = GroundMode::automatic;
  float ground_height_m = 0;  // GroundMode::height: world y
  KeyLight key_light = KeyLight::automatic;

  settings::DrawSettings draw = settings::default_settings();  // without the environment image
  double checkpoint_interval_s = 60;  // of path-traced images without a window; 0: no checkpoints
  settings::DebugView debug_view = settings::DebugView::none;  // displayed instead of lighting
};

ViewDefaults view_defaults(const Options& options);
// True if the user chose light beside that of the scene: an environment map, or lamps beside the lens.
bool lights_by_choice(const Options& options);

// Returns the options, or the exit code for a program that ends now (help, or a printed usage error).
// needs_scene: a scene is required; then the configuration file counts, too (config_options.h).
std::variant<Options, int> parse_options(int argc, char** argv, bool needs_scene = true);

}  // namespace fire3dv::app
