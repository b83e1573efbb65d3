// What panels tell: numbers that the program knows of itself, gathered once a frame. Plain data.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/peer_limits.h"
#include "renderer/state/liveness.h"

namespace fire3dv::gui {

struct PassFact {
  std::string name;
  double ms = 0;
  bool aside = false;  // on the side queue, beside others
};

struct FrameFacts {
  uint64_t images = 0;     // drawn so far; where it has not risen, nothing here is news
  double interval_ms = 0;  // from the last image to this one
  double cpu_ms = 0;       // of recording and submitting
  double gpu_ms = 0;       // of the newest frame that is finished
  std::optional<double> pose_age_ms;
  std::vector<PassFact> passes;  // of that frame, in its order
  glm::uvec2 extent_px{0};
  // Of the scene as it is shown, each as often as it is drawn.
  uint64_t triangles = 0;
  uint64_t clusters = 0;
  std::optional<uint64_t> clusters_drawn;  // after culling; none where the raster path does not count them
  uint64_t late_clusters = 0;              // of them those that were hidden in the frame before
  uint64_t shadow_rays = 0;
  uint64_t gpu_bytes = 0;  // that this program has asked for
  uint64_t resident_bytes = 0;
  std::string device, raster, shadows;  // in words
  uint32_t samples = 0;
};

// Use of one resource by a stream's peer.
struct UseFact {
  Resource resource{};
  uint64_t used = 0, limit = 0, refused = 0;
};

struct StreamFact {
  uint64_t epoch = 0;
  std::string name, listener, clock;
  state::Condition condition = state::Condition::live;
  bool interpolated = false;
  int64_t delay_ns = 0;          // with which it is shown, where interpolated
  double rate_hz = 0;            // whole frames a second
  std::optional<double> age_ms;  // since the shown frame was published
  uint64_t sequence = 0;
  int64_t sim_time_ns = 0;
  uint32_t poses = 0, unmatched = 0, conflicting = 0;
  uint64_t shown = 0;  // frames
  // Frames and messages that were not shown, by cause.
  uint64_t incomplete = 0, stale = 0, refused = 0, baseless = 0, overtaken = 0;
  uint64_t edits = 0, edits_refused = 0;
  std::vector<UseFact> uses;   // above 1 % of the limit, or with refusals
  std::vector<float> gaps_ms;  // between the newest frames that came, the oldest first
};

struct LinkFact {
  std::string uri;
  uint32_t peers = 0;
  uint64_t received_bytes = 0, poses_dropped = 0, frames_dropped = 0, rejected = 0;
};

struct LogLine {
  double time_s = 0;  // since the program's begin
  std::string text;
};

struct Facts {
  FrameFacts frame;
  std::vector<StreamFact> streams;
  std::vector<LinkFact> links;
  std::vector<LogLine> log;      // the newest ones, the oldest first
  uint64_t log_lines = 0;        // ever: what stands before `log` is gone
  std::optional<size_t> camera;  // of the scene, in its order; none: the free one
  bool recording_video = false;
  // One sentence for each that cannot be had with this device and scene; empty: it can.
  std::string why_no_debug_views;
};

}  // namespace fire3dv::gui
