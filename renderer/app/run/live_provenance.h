// Provenance of the images that a live run writes (--out).
#pragma once

#include <memory>
#include <string>

#include "base/error.h"
#include "renderer/app/options/options.h"
#include "renderer/editing/edit_document.h"
#include "renderer/gpu/device/device_report.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::app {

// JSON of sinks::encode_provenance(). Reads the environment map, the overlay file and its assets once. edits:
// of the overlay. Null: it would be too long, which is logged.
Result<std::shared_ptr<const std::string>> describe_live_run(const Options& options,
                                                             const scene::Scene& scene,
                                                             const state::EditDocument& edits,
                                                             const gpu::DeviceReport& device);

}  // namespace fire3dv::app
