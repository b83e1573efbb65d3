// `fire3dv render`: a recording as a video, or as a folder of frames.
#pragma once

#include "renderer/offline/render_options.h"

namespace fire3dv::offline {

// The exit code.
int render(const RenderOptions& options);

}  // namespace fire3dv::offline
