// `fire3dv render`: renders a recording to a video or to a frame folder.
#pragma once

#include "renderer/offline/render_options.h"

namespace fire3dv::offline {

// Returns the exit code.
int render(const RenderOptions& options);

}  // namespace fire3dv::offline
