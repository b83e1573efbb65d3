#include "renderer/passes/path/traced_scene.h"

#include "base/vectors.h"

namespace fire3dv::passes {
namespace {

// Compared by bytes.
static_assert(sizeof(state::NodeDrive) == 2 * sizeof(uint32_t) + sizeof(wire::Affine3x4));

// Cameras move by the view.
scene::EditRevisions without_cameras(scene::EditRevisions edits) {
  edits.camera = 0;
  return edits;
}

}  // namespace

void TracedScene::set(const state::PoseState& poses, const scene::EditRevisions& edits) {
  revision_ = poses.revision();
  edits_ = without_cameras(edits);
  drives_ = poses.node_drives();
  morph_weights_ = poses.morph_weights();
  stream_poses_.resize(poses.streams().size());
  for (size_t s = 0; s < stream_poses_.size(); ++s) stream_poses_[s] = poses.streams()[s].poses;
}

bool TracedScene::equals(const state::PoseState& poses, const scene::EditRevisions& edits) {
  if (edits_ != without_cameras(edits)) return false;
  if (revision_ == poses.revision()) return true;
  const std::vector<state::Stream>& streams = poses.streams();
  bool equal = stream_poses_.size() == streams.size() && same_bytes(drives_, poses.node_drives()) &&
               same_bytes(morph_weights_, poses.morph_weights());
  for (size_t s = 0; equal && s < streams.size(); ++s) equal = same_bytes(stream_poses_[s], streams[s].poses);
  if (equal) revision_ = poses.revision();
  return equal;
}

}  // namespace fire3dv::passes
