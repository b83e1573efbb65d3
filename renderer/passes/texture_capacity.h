// Texture capacity of a renderer: its array of textures has a fixed size.
#pragma once

#include <optional>

#include "base/error.h"
#include "renderer/passes/scene_renderer.h"

namespace fire3dv::passes {

// Fails if the device cannot bind the textures of the scene.
Result<void> check_texture_count(const gpu::Device& device, const scene::Scene& scene);

// Replaces the renderer if the scene has more textures than it supports (rare). settings: of the renderer.
Result<void> ensure_texture_capacity(gpu::Device& device, settings::DrawSettings settings,
                                     const scene::Scene& scene, std::optional<SceneRenderer>& renderer);

}  // namespace fire3dv::passes
