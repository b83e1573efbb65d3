// Layouts with a folder for each camera: that of C3VD, and the plain one of NumPy arrays.
#pragma once

#include <string>
#include <vector>

#include "renderer/dataset/layouts/layout.h"

namespace fire3dv::dataset {

// Folder of a camera: its index and name.
std::string camera_folder(const Description& description, uint32_t camera);

// C3VD's files: 0_color.png, 0000_depth.tiff, 0000_normals.tiff, pose.txt.
class C3vdLayout final : public Layout {
 public:
  wire::ImageOutputs further_outputs() const override { return wire::ImageOutputs(wire::kNormal); }
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

// 000000.png, 000000.depth.npy and so on, 000000.json.
class FolderLayout final : public Layout {
 public:
  wire::ImageOutputs further_outputs() const override {
    return wire::ImageOutputs(wire::kNormal | wire::kSemanticU32 | wire::kAmodal);
  }
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
