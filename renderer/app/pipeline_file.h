// Compiled pipelines from one run to the next. The driver says what they are and whether it takes them back;
// a file of another device, driver or build, or a damaged one, never reaches it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "renderer/app/kept_file.h"
#include "renderer/gpu/device.h"

namespace fire3dv::app {

// What a file of pipelines is for: this device and driver, and the shaders of this build.
scene::Digest pipeline_kind(const VkPhysicalDeviceProperties& device);

extern const KeptFileType kPipelineFiles;

// One run's use of the folder. Without a folder it keeps nothing, but for the run.
class PipelineFile {
 public:
  // Before the device makes any. A sentence where a file was there and is of no use.
  PipelineFile(gpu::Device& device, const std::optional<std::filesystem::path>& folder);
  const std::optional<std::string>& note() const { return note_; }

  // After the last one was made.
  Result<void> keep() const;

 private:
  gpu::Device& device_;
  scene::Digest kind_{};
  std::filesystem::path folder_;  // empty: none
  std::vector<std::byte> known_;
  std::optional<std::string> note_;
};

}  // namespace fire3dv::app
