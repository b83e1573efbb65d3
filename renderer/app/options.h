// The renderer's command line.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "protocol/base/peer_limits.h"
#include "renderer/app/converted_scene.h"
#include "renderer/app/play_options.h"
#include "renderer/app/recording_options.h"
#include "renderer/passes/environment.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/sinks/window.h"

namespace fire3dv::app {

struct Options {
  std::chrono::steady_clock::time_point begun = std::chrono::steady_clock::now();
  std::filesystem::path scene;                          // empty: the one that travels in a recording
  ConvertOptions convert;                               // where the scene is a description
  std::vector<std::string> listen;                      // URIs
  bool insecure = false;                                // listen on addresses other than loopback
  std::string key_file;                                 // udp: the pre-shared key
  std::string tls_certificate, tls_key, tls_client_ca;  // tls: PEM files
  std::string metrics;                                  // HOST:PORT; empty: none are shown
  PeerLimits peer_limits;                               // of each adapter that connects
  PlayOptions play;
  RecordingOptions recording;
  bool lockstep = false;  // one image for each pose frame, acknowledged

  bool headless = false;
  bool on_request = false;  // draws nothing but images that simulators ask for
  uint32_t width = 1280, height = 720;
  bool panels = true;  // over the window's image
  sinks::Present present = sinks::Present::vsync;
  std::vector<std::string> window_cameras;  // of each window, beginning with the first; empty: one, by camera
  std::string right_camera;                 // beside camera in the same window; empty: none
  std::filesystem::path screenshots = ".";  // folder of what the user takes
  std::string camera;            // node or camera name; empty: the scene's first, or one that frames it
  uint64_t frames = 0;           // 0 = until told to stop
  bool wait_for_stream = false;  // write and count images from the first whole pose frame on
  std::chrono::duration<double> stream_timeout{0};  // 0 = none
  bool exit_when_done = false;   // end when the last stream has ended
  std::filesystem::path assets;  // folder below which streams may name assets; empty: none
  std::string animate;           // an animation's name, its index, or "all"; empty: none plays
  std::string cache = "auto";    // auto, off, beside or a folder: see cache_places.h
  std::filesystem::path out;     // folder of images; empty = none
  passes::ImageOutputs outputs;  // of each image there
  std::filesystem::path stats;   // CSV of times per frame; empty = none

  std::string device;
  std::string devices;  // that draw images for simulators, the first of them all else; empty: only `device`
  gpu::AsyncCompute async_compute = gpu::AsyncCompute::automatic;
  bool list_devices = false;
  bool validation = false;

  std::filesystem::path environment;  // Radiance picture; empty: the studio
  float environment_rotation_deg = 0;
  float environment_intensity = 1;
  passes::Background background;

  uint32_t samples = 4;
  passes::RasterPath raster = passes::RasterPath::automatic;
  passes::Cull cull = passes::Cull::automatic;
  passes::LevelsOfDetail levels_of_detail = passes::LevelsOfDetail::automatic;
  float anisotropy = 1;
  passes::ShadowSettings shadows;
  float exposure = 1;
  passes::ToneMap tone_map = passes::ToneMap::reinhard;
  bool fxaa = true;
  passes::DebugView debug_view = passes::DebugView::none;  // shown instead of light
};

// Options, or the exit code with which the program ends now (help, or a usage error that has been printed).
// needs_scene: one has to be named.
std::variant<Options, int> parse_options(int argc, char** argv, bool needs_scene = true);

}  // namespace fire3dv::app
