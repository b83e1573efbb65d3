// Layout of YOLO detection: images/train, labels/train with one text file an image, data.yaml.
#pragma once

#include <string>
#include <vector>

#include "renderer/dataset/layouts/layout.h"

namespace fire3dv::dataset {

class YoloLayout final : public Layout {
 public:
  wire::ImageOutputs further_outputs() const override { return wire::ImageOutputs(0); }
  std::vector<std::string> folders(const Description& description) const override;
  std::string color_name(const Description& description, uint64_t image) const override;
  std::vector<std::string> file_names(const Description& description, uint64_t image,
                                      size_t instances) const override;
  Result<std::vector<std::vector<uint8_t>>> encode(const Description& description,
                                                   const sinks::FrameImage& image, const ImageLabels& labels,
                                                   std::vector<uint8_t> color) const override;
  Result<void> complete(const std::filesystem::path& folder, const Description& description,
                        const offline::FrameLines& lines) const override;
  std::string conventions(const Description& description) const override;
};

}  // namespace fire3dv::dataset
