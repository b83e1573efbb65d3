// What everything that draws a scene relies on without looking again. The loader sees to it; a scene that
// comes out of a cache file is held against it before anyone follows an index.
#pragma once

#include "protocol/error.h"
#include "renderer/scene/derived.h"
#include "renderer/scene/scene.h"

namespace fire3dv::scene {

// On all cores. The error says what is wrong, without the file's name.
Result<void> check_scene(const Scene& scene);
// For a scene that is right itself.
Result<void> check_derived(const Scene& scene, const Derived& derived);

}  // namespace fire3dv::scene
