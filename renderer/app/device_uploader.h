// Scene uploader of a renderer, which also counts the memory of the secondary devices.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "base/error.h"
#include "renderer/gpu/device/device.h"
#include "renderer/live_scene/scene_uploader.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/scene/derived/loaded_scene.h"
#include "renderer/scene/model/scene_edits.h"
#include "renderer/state/marker_registry.h"

namespace fire3dv::app {

class DeviceUploader final : public SceneUploader {
 public:
  // Borrows all arguments. secondary: devices that draw the same scene and load it by themselves.
  explicit DeviceUploader(passes::SceneRenderer& renderer, std::vector<const gpu::Device*> secondary = {})
      : renderer_(renderer), secondary_(std::move(secondary)) {}

  Result<void> check_memory(const scene::LoadedScene& next) const override;
  Result<void> upload(const scene::LoadedScene& next) override;
  uint32_t max_textures() const override { return renderer_.settings().draw().max_textures; }
  void set_edits(const scene::SceneEdits& edits) override { renderer_.set_edits(edits); }
  void set_markers(const std::vector<state::ShownMarker>& markers) override {
    renderer_.set_markers(markers);
    for (passes::SceneRenderer* const each : with_markers_) each->set_markers(markers);
  }
  // Renderers of secondary devices that draw markers, too.
  void share_markers(std::vector<passes::SceneRenderer*> renderers) { with_markers_ = std::move(renderers); }
  bool lacks_markers() const override { return renderer_.counts().markers_lack_memory; }
  uint32_t lights_without_shadow() const override { return renderer_.counts().lights_without_shadow; }

 private:
  passes::SceneRenderer& renderer_;
  const std::vector<const gpu::Device*> secondary_;
  std::vector<passes::SceneRenderer*> with_markers_;
};

}  // namespace fire3dv::app
