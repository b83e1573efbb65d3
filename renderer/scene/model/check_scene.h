// Validation of a scene that was read from a cache file: all indices, ranges and values. The glTF loader
// establishes the same invariants, and renderers rely on them without further checks.
#pragma once

#include "protocol/base/error.h"
#include "renderer/scene/edits/derived.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// Runs on all cores. The error names the array, not the file.
Result<void> check_scene(const Scene& scene);
// Precondition: check_scene() succeeded.
Result<void> check_derived(const Scene& scene, const Derived& derived);

}  // namespace fire3dv::scene
