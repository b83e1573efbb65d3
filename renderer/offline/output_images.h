// Images of one camera with the outputs of fire3dv render --outputs.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "renderer/offline/image_set.h"
#include "renderer/offline/output_frames.h"

namespace fire3dv::offline {

class OutputImages final : public ImageSet {
 public:
  explicit OutputImages(wire::ImageOutputs outputs) : outputs_(outputs) {}

  wire::ImageOutputs outputs() const override { return outputs_; }
  const std::vector<std::string>& cameras() const override { return cameras_; }
  // Motion and occlusion are those since the image before.
  uint32_t flow_frames() const override { return outputs_.needs_last_image() ? 1 : 0; }
  bool has_flow_forward() const override { return false; }
  bool has_motion_planes() const override { return true; }
  Result<std::shared_ptr<FrameFormat>> open_format(const scene::Scene&, Settings& settings) override {
    settings.emplace_back(kOutputsSetting, outputs_text(outputs_));
    return std::shared_ptr<FrameFormat>(std::make_shared<OutputFrames>(outputs_));
  }
  Result<void> check_camera(size_t, const app::CameraRig::Placed&) const override { return {}; }
  void add_poses(uint64_t, const app::CameraRig::Placed&, const app::CameraRig::Placed*,
                 const state::PoseState&) override {}

 private:
  const wire::ImageOutputs outputs_;
  const std::vector<std::string> cameras_;  // none: that of the drawing options
};

}  // namespace fire3dv::offline
