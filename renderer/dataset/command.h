// Command `fire3dv dataset`, and its part of `fire3dv join`.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "base/error.h"
#include "renderer/dataset/options.h"
#include "renderer/offline/frame_format.h"
#include "renderer/offline/image_consumer.h"

namespace fire3dv::dataset {

// Draws a data set. Returns the exit code. consumer: not null in place of the set's folder.
int run(const DatasetOptions& options, offline::ImageConsumer* consumer);
inline int run(const DatasetOptions& options) {
  return run(options, nullptr);
}

// gltf_file: of the scene, or its conversion. Checks cameras, objects, keypoints, format and the
// randomisation file against a scene, before a recording is there. Writes nothing.
Result<void> check(const DatasetOptions& options, const scene::Scene& scene,
                   const std::filesystem::path& gltf_file);

}  // namespace fire3dv::dataset
