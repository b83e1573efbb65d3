// Upload of scenes to the devices that draw them: what the live scene needs of a renderer.
#pragma once

#include <cstdint>
#include <vector>

#include "base/error.h"
#include "renderer/scene/derived/loaded_scene.h"
#include "renderer/scene/model/scene_edits.h"
#include "renderer/state/marker_registry.h"

namespace fire3dv::app {

class SceneUploader {
 public:
  virtual ~SceneUploader() = default;
  // Returns an error if a device lacks the memory for this scene beside the displayed one.
  virtual Result<void> check_memory(const scene::LoadedScene& next) const = 0;
  // Draws this scene from the next frame on; it must outlive that use. After an error the previous one stays.
  virtual Result<void> upload(const scene::LoadedScene& next) = 0;
  virtual uint32_t max_textures() const = 0;  // of a scene

  // Both are borrowed and apply to the next frames.
  virtual void set_edits(const scene::SceneEdits& edits) = 0;
  virtual void set_markers(const std::vector<state::ShownMarker>& markers) = 0;

  // What the last frame lacks since the device has no memory for it.
  virtual bool lacks_markers() const = 0;
  virtual uint32_t lights_without_shadow() const = 0;
};

}  // namespace fire3dv::app
