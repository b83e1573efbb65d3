// Switch between raster and paths by viewers of the live view.
#pragma once

#include <functional>
#include <optional>

#include "base/error.h"
#include "renderer/editing/view_state.h"
#include "renderer/gpu/device/device.h"
#include "renderer/live_scene/live_scene.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/streams/image_request_queue.h"

namespace fire3dv::app {

struct SwitchedParts {
  gpu::Device& device;
  std::optional<passes::SceneRenderer>& renderer;
  const DocumentState& document;  // with the settings of the renderer that is there
  ImageRequestQueue& requests;
  LiveScene& scene;
};

// Function that puts a renderer with other settings in the place of the one that is there, which stays after
// an error. parts: borrowed.
std::function<Result<void>(const settings::DrawSettings&)> renderer_switch(const SwitchedParts& parts);

}  // namespace fire3dv::app
