// NumPy files of live runs and of fire3dv render (--outputs): their provenance is in frames.jsonl beside
// them, or in manifest.json, and they are drawn again as an output of one camera.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "renderer/offline/image_set.h"
#include "renderer/verify/image_check.h"

namespace fire3dv::verify {

// Reads a NumPy file and the line of frames.jsonl that names it. Both are untrusted. The error names the
// file.
struct ArrayFile {
  StoredArray array;
  sinks::FrameImage image;  // frame_index, shown and run_provenance
};
Result<ArrayFile> read_array(const std::filesystem::path& path);

// One camera, and this output beside the colours.
class ArrayOutputs final : public offline::ImageSet {
 public:
  explicit ArrayOutputs(wire::ImageOutput output) : outputs_(wire::kColorSrgb8) { outputs_.add(output); }
  wire::ImageOutputs outputs() const override { return outputs_; }
  const std::vector<std::string>& cameras() const override { return cameras_; }
  Result<std::shared_ptr<offline::FrameFormat>> open_format(const scene::Scene&, const std::filesystem::path&,
                                                            Settings&) override {
    return std::shared_ptr<offline::FrameFormat>();
  }
  Result<void> check_camera(size_t, const app::CameraRig::Placed&) const override { return {}; }
  void add_poses(uint64_t, const app::CameraRig::Placed&, const app::CameraRig::Placed*,
                 const state::PoseState&) override {}

 private:
  wire::ImageOutputs outputs_;
  const std::vector<std::string> cameras_;
};

}  // namespace fire3dv::verify
