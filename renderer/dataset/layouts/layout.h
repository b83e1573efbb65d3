// Layout of a data set's format: the files of each image, and those of the whole set.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/dataset/labels/description.h"
#include "renderer/dataset/labels/labels.h"
#include "renderer/offline/frame_format.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::dataset {

// Depth image of a format, whose range 65535 units divide.
struct Depth16 {
  double unit_mm = 0.1;
  const char* beyond = "";  // value of pixels that are too far, for a warning
};

constexpr uint64_t kMaxFileBytes = uint64_t{2} << 30;  // of an image or model

// Const methods are called by several threads at once.
class Layout {
 public:
  virtual ~Layout() = default;

  // Before all others; the description outlives the layout.
  virtual void prepare(const Description&) {}
  // Error for a set that the format, or this build, cannot hold. Before anything is written.
  virtual Result<void> check(const Description&) const { return {}; }
  // nullopt: the format has none.
  virtual std::optional<Depth16> depth16(const Description&) const { return {}; }
  // Outputs beside colours, depth and instances.
  virtual wire::ImageOutputs further_outputs() const { return wire::ImageOutputs(wire::kAmodal); }
  // False: images have flow to the earlier one alone.
  virtual bool has_flow_forward() const { return true; }
  // Sub-folders, relative to the set's.
  virtual std::vector<std::string> folders(const Description& description) const = 0;
  // Files of the whole set that begin() writes beside the description, such as models.
  virtual std::vector<std::string> static_names(const Description&) const { return {}; }
  // File of the colours.
  virtual std::string color_name(const Description& description, uint64_t image) const = 0;
  // Pixels of the colours, four bytes each.
  virtual Result<std::vector<uint8_t>> read_color(const std::filesystem::path& folder,
                                                  const Description& description, uint64_t image) const;
  // Files of an image with so many instances, the colours first; in the order of encode().
  virtual std::vector<std::string> file_names(const Description& description, uint64_t image,
                                              size_t instances) const = 0;
  // Bytes of one of those files, also from the files of the whole set.
  virtual Result<std::vector<uint8_t>> read_file(const std::filesystem::path& folder, uint64_t image,
                                                 const std::string& name) const;
  // color: the PNG.
  virtual Result<std::vector<std::vector<uint8_t>>> encode(const Description& description,
                                                           const sinks::FrameImage& image,
                                                           const ImageLabels& labels,
                                                           std::vector<uint8_t> color) const = 0;
  // Files of the whole set that follow from the lines of all images, such as lists of labels. Throws
  // nlohmann::json::exception for lines that encode() does not write.
  virtual Result<std::vector<offline::FolderFile>> list_files(const Description& description,
                                                              const offline::FrameLines& lines) const = 0;
  // Writes the images' own files into files of the whole set, before those of list_files().
  virtual Result<void> pack(const std::filesystem::path&, const Description&,
                            const offline::FrameLines&) const {
    return {};
  }
  // Names of what pack() writes and no check makes again.
  virtual std::vector<std::string> unlisted_names() const { return {}; }
  // True if the files of the whole set hold all images, whose own files may be gone: pack() and
  // remove_loose() have ended, or only pack() has.
  virtual bool is_packed(const std::filesystem::path&) const { return false; }
  // Removes the images' own files, if the files of the whole set hold them.
  virtual void remove_loose(const std::filesystem::path&, const Description&,
                            const offline::FrameLines&) const {}
  // Files, units and conventions, as Markdown for the README.
  virtual std::string conventions(const Description& description) const = 0;
};

constexpr const char* kFormats = "bop|coco|yolo|c3vd|folder|hdf5|webdataset|lerobot";
constexpr const char* kLerobot = "lerobot";
// Null: there is no such format.
std::unique_ptr<Layout> make_layout(const std::string& format);

offline::FolderFile text_file(std::string name, const std::string& text);
// Writes a text file atomically.
Result<void> write_text(const std::filesystem::path& path, const std::string& text);
// Folder of a camera: its index and name.
std::string camera_folder(const Description& description, uint32_t camera);
// "000123"
std::string six_digits(uint64_t number);

}  // namespace fire3dv::dataset
