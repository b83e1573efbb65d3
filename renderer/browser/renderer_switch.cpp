#include "renderer/browser/renderer_switch.h"

#include <string>

#include "base/log.h"
#include "renderer/images/image_batch_renderer.h"
#include "renderer/passes/path/path_pass.h"

namespace fire3dv::app {

std::function<Result<void>(const settings::DrawSettings&)> renderer_switch(const SwitchedParts& parts) {
  return [parts](const settings::DrawSettings& settings) -> Result<void> {
    FIRE3DV_ASSERT(parts.requests.count() == 0);
    settings::DrawSettings before = parts.document.draw;
    before.max_textures = parts.renderer->settings().draw().max_textures;
    // Waits for the GPU: a viewer has asked for it.
    const auto replace = [&](const settings::DrawSettings& with) {
      parts.device.wait(parts.device.last_submitted());
      parts.renderer.reset();
      parts.device.retire_all_now();
      parts.renderer.emplace(parts.device, with);
      parts.renderer->set_edits(parts.scene.edits());
      parts.renderer->set_scene(parts.scene.scene(), parts.scene.loaded().derived);
      parts.renderer->apply(with);
    };
    Result<void> result;
    try {
      replace(settings);
    } catch (const gpu::VulkanFailure& failure) {
      if (!gpu::is_out_of_memory(failure)) throw;
      result = Error{"the device has no memory for another renderer: the settings stay"};
      replace(before);
    }
    parts.requests.set_abilities(image_abilities(*parts.renderer, true));
    if (result && settings.path) {
      for (const std::string& limit : passes::path_tracing_limits(parts.scene.scene()))
        log_message(warning(limit));
    }
    return result;
  };
}

}  // namespace fire3dv::app
