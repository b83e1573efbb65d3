// Format of the folder of a data set: labels of each image, its files by the layout, README.md and
// index.html.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "renderer/dataset/labels/description.h"
#include "renderer/dataset/labels/labels.h"
#include "renderer/dataset/layouts/layout.h"
#include "renderer/offline/frame_format.h"

namespace fire3dv::dataset {

class DatasetFormat final : public offline::FrameFormat {
 public:
  // static_files: of the whole set, such as models; names relative to the folder.
  DatasetFormat(Description description, std::unique_ptr<Layout> layout,
                std::vector<offline::FolderFile> static_files);
  // Of the parts of a data set, for fire3dv join. Null: the first folder holds none.
  static Result<std::shared_ptr<offline::FrameFormat>> find(
      const std::vector<std::filesystem::path>& folders);

  const Description& description() const { return description_; }
  // Poses of an image that is drawn now; on one thread, before its pixels are encoded.
  void add_poses(uint64_t image, ImagePoses poses);

  Result<offline::EncodedFrame> encode(const sinks::FrameImage& image) override;
  bool is_packed(const std::filesystem::path& folder) const override;
  bool is_complete(const std::filesystem::path& folder, uint64_t image, const nlohmann::json& line,
                   bool is_packed) const override;
  Result<offline::EncodedFrame> load(const std::filesystem::path& folder, uint64_t image,
                                     const std::string& line,
                                     const offline::Manifest& manifest) const override;
  Result<std::vector<uint8_t>> read_file(const std::filesystem::path& folder, uint64_t image,
                                         const std::string& name) const override {
    return layout_->read_file(folder, image, name);
  }
  bool needs_empty_folder() const override { return true; }
  Result<void> begin(const std::filesystem::path& folder) override;
  Result<void> complete(const std::filesystem::path& folder, const offline::FrameLines& lines) override;
  std::vector<offline::FolderFile> first_files() const override;
  Result<std::vector<offline::FolderFile>> last_files(const offline::FrameLines& lines) const override;
  std::vector<std::string> page_names() const override;
  Result<std::vector<uint8_t>> read_run_file(const std::filesystem::path& folder,
                                             const std::string& name) const override;

 private:
  Result<void> write_final_files(const std::filesystem::path& folder, const offline::FrameLines& lines) const;

  const Description description_;
  const std::unique_ptr<Layout> layout_;
  std::vector<offline::FolderFile> static_files_;  // empty after begin()

  std::mutex mutex_;
  std::map<uint64_t, ImagePoses> poses_;  // of images that are not encoded yet
};

}  // namespace fire3dv::dataset
