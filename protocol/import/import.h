// Import of recordings of other programs: transforms and joint states become a recording of one stream, whose
// nodes are those of a scene.
//
// Time: the stamps of the messages; the log times of topics without stamps. A frame is written for each
// stamp of a coordinate frame that moves and that a node depends on. At such a time all other frames are
// interpolated, or held where they are silent for more than a second. Before its first transform a frame has
// this one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "protocol/import/files/message_source.h"
#include "protocol/record/mcap/file.h"
#include "protocol/robot/robot.h"
#include "protocol/wire/affine.h"

namespace fire3dv::imported {

// Node of the scene that a coordinate frame moves.
struct SceneNode {
  uint32_t index = 0;                                                          // identity
  std::string name;                                                            // unique name for streams
  wire::Affine3x4 body_from_node;                                              // its scale at rest
  std::array<double, 12> world_from_body{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};  // at rest, rigid
};

struct ImportOptions {
  std::string frame_prefix;  // stripped from names of frames; frames without it are no nodes
  std::string fixed_frame;   // origin of the scene; empty: map, odom, world, or the root with most nodes
  bool is_z_up = true;       // of the fixed frame; the scene has Y up
  // Node by name or path; nothing for names that the scene lacks or has twice.
  std::function<std::optional<SceneNode>(std::string_view name)> find_node;
  robot::Robot* robot = nullptr;  // of the scene, for joint states; its positions change
  bool is_in_degrees = false;     // joint states of joints that turn
  // Called with the progress, 0 to 1. false: stop.
  std::function<bool(double)> on_progress;
};

struct ImportReport {
  std::vector<std::string> notes;     // one sentence each
  std::vector<std::string> warnings;  // one sentence each
  std::vector<SceneNode> nodes;
  std::string fixed_frame;
  uint64_t frames = 0;
  int64_t first_ns = 0, last_ns = 0;  // stamps
};

// Reads the messages twice and writes the recording. Equal inputs give equal bytes. The sink is finished on
// success only.
Result<ImportReport> import_states(MessageSource& source, const ImportOptions& options,
                                   std::unique_ptr<record::Sink> sink);

}  // namespace fire3dv::imported
