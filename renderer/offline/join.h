// `fire3dv join`: the frames of shards as one video or one folder, after a check that each frame is there
// exactly once and that all are of one recording, drawn in one way.
#pragma once

#include "renderer/offline/render_options.h"

namespace fire3dv::offline {

// The exit code.
int join(const JoinOptions& options);

// The video of one whole folder of frames; then what fire3dv wrote into the folder is removed. False: asked
// to stop.
Result<bool> encode_and_clear(const std::filesystem::path& folder, const std::filesystem::path& out,
                              const VideoOptions& video);

}  // namespace fire3dv::offline
