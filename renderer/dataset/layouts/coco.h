// Layout of COCO: images/ and annotations.json, with boxes, masks as compressed run lengths, and keypoints.
#pragma once

#include <string>
#include <vector>

#include "renderer/dataset/layouts/layout.h"

namespace fire3dv::dataset {

class CocoLayout final : public Layout {
 public:
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
