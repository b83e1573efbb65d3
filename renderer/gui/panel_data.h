// Numbers that panels display, gathered once per frame. Plain structs, main thread only; independent of
// window and panels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/peer_budget.h"
#include "renderer/settings/path_settings.h"
#include "renderer/state/stream_timing.h"

namespace fire3dv::gui {

struct PassFact {
  std::string name;
  double ms = 0;
  bool is_async = false;  // on the async compute queue
};

struct FrameFacts {
  uint64_t images = 0;     // drawn so far; if unchanged, all values here are unchanged
  double interval_ms = 0;  // since the previous image
  double cpu_ms = 0;       // recording and submission
  double gpu_ms = 0;       // newest finished frame
  std::optional<double> pose_age_ms;
  std::vector<PassFact> passes;  // of that frame, in execution order
  glm::uvec2 extent_px{0};
  // Counts of the displayed scene, with instancing.
  uint64_t triangles = 0;
  uint64_t clusters = 0;
  std::optional<uint64_t> clusters_drawn;  // after culling; empty if the raster path does not count them
  uint64_t late_clusters = 0;              // the part drawn by the second (disocclusion) pass
  uint64_t shadow_rays = 0;
  uint64_t gpu_bytes = 0;  // allocated by this program
  uint64_t resident_bytes = 0;
  std::string device, raster, shadows;  // display texts
  uint32_t samples = 0;
  std::optional<settings::PathProgress> paths;  // of a path-traced image; empty: raster
};

constexpr size_t kMaxMarkerNamespaces = 32;

// Use of one resource by a stream's peer.
struct UseFact {
  Resource resource{};
  uint64_t used = 0, limit = 0, refused = 0;
};

struct MarkerFact {
  std::string name;  // of a namespace
  uint64_t markers = 0;
};

struct StreamFact {
  uint64_t epoch = 0;
  std::string name, listener, clock;
  state::Condition condition = state::Condition::live;
  bool interpolated = false;
  int64_t delay_ns = 0;          // playout delay, if interpolated
  double rate_hz = 0;            // whole frames per second
  std::optional<double> age_ms;  // age of the displayed frame since its publication
  uint64_t sequence = 0;
  int64_t sim_time_ns = 0;
  uint32_t poses = 0, unmatched = 0, conflicting = 0;
  uint64_t shown = 0;  // displayed frames
  // Frames and messages that were not displayed, by cause.
  uint64_t incomplete = 0, stale = 0, refused = 0, baseless = 0, overtaken = 0;
  uint64_t edits = 0, edits_refused = 0;
  std::vector<MarkerFact> marker_namespaces;  // at most kMaxMarkerNamespaces, by name
  uint64_t more_marker_namespaces = 0;        // beyond these
  PeerBudget::DrawCost draw_cost;
  std::vector<UseFact> uses;   // above 1 % of the limit, or with refusals
  std::vector<float> gaps_ms;  // intervals between the newest frames, oldest first
};

struct LinkFact {
  std::string uri;
  uint32_t peers = 0;
  uint64_t received_bytes = 0, poses_dropped = 0, frames_dropped = 0, rejected = 0;
};

struct LogLine {
  double time_s = 0;  // since program start
  std::string text;
};

struct Facts {
  FrameFacts frame;
  std::vector<StreamFact> streams;
  std::vector<LinkFact> links;
  std::vector<LogLine> log;      // newest lines, oldest first
  uint64_t log_lines = 0;        // total; lines before `log` are dropped
  std::optional<size_t> camera;  // index of the scene's camera; empty: free camera
  bool recording_video = false;
  // Reasons for features that this device or scene does not support; empty: supported.
  std::string why_no_debug_views;
};

}  // namespace fire3dv::gui
