// Plan of an import: fixed frame, nodes with their frames, and the frames whose times count.
#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "base/error.h"
#include "protocol/import/import.h"
#include "protocol/import/link_poses.h"
#include "protocol/import/survey.h"
#include "protocol/wire/affine.h"

namespace fire3dv::imported {

struct Plan {
  std::string fixed_frame;
  wire::Affine3x4d world_from_stream;
  bool uses_joints = false;
  std::set<std::string, std::less<>> links;  // frames that joints move; their transforms are not used
  std::vector<SceneNode> nodes;
  std::vector<std::string> frame_of_node;
  std::vector<SeenFrame> frames;  // all that are children, each with its first transform
  // Frames that nodes depend on, and those of them whose times make frames of the recording.
  std::set<std::string, std::less<>> relevant, moving;
  int64_t first_ns = 0;  // of those times; if nothing moves, the newest
  std::vector<std::string> notes, warnings;
};

// links: of the scene's robot; null: none. Adds its links to the survey, if joint states move them.
// file: for messages.
Result<Plan> make_plan(const std::string& file, Survey& survey, LinkPoses* links,
                       const ImportOptions& options);

}  // namespace fire3dv::imported
