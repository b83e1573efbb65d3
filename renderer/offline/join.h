// `fire3dv join`: merges the frames of shards into one video or one folder. It fails unless each frame exists
// exactly once and all shards have the same recording and settings.
#pragma once

#include "renderer/offline/render_options.h"

namespace fire3dv::offline {

// Returns the exit code.
int join(const JoinOptions& options);

// Encodes one complete frame folder, then deletes the files that fire3dv wrote there. Returns false if the
// user stopped it.
Result<bool> encode_and_clear(const std::filesystem::path& folder, const std::filesystem::path& out,
                              const VideoOptions& video);

}  // namespace fire3dv::offline
