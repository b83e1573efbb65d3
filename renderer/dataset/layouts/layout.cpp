#include "renderer/dataset/layouts/layout.h"

#include <cstdio>
#include <utility>

#include "base/files.h"
#include "renderer/dataset/layouts/layouts.h"
#include "renderer/sinks/output_text.h"
#include "renderer/sinks/png.h"

namespace fire3dv::dataset {

std::unique_ptr<Layout> make_layout(const std::string& format) {
  if (format == "bop") return make_bop_layout();
  if (format == "coco") return make_coco_layout();
  if (format == "yolo") return make_yolo_layout();
  if (format == "c3vd") return make_c3vd_layout();
  if (format == "folder") return make_folder_layout();
  if (format == "hdf5") return make_hdf5_layout();
  if (format == "webdataset") return make_webdataset_layout();
  if (format == kLerobot) return make_lerobot_layout();
  return nullptr;
}

Result<std::vector<uint8_t>> Layout::read_color(const std::filesystem::path& folder,
                                                const Description& description, uint64_t image) const {
  const std::filesystem::path path = folder / color_name(description, image);
  auto png = sinks::read_png(path);
  if (!png) return png.error();
  if (png->image.width != description.width || png->image.height != description.height)
    return Error{path.string() + " has another size than the data set"};
  return std::move(png->image.rgba8);
}

Result<std::vector<uint8_t>> Layout::read_file(const std::filesystem::path& folder, uint64_t,
                                               const std::string& name) const {
  constexpr uint64_t kMaxBytes = uint64_t{2} << 30;
  return read_whole_file(folder / name, kMaxBytes);
}

std::string camera_folder(const Description& description, uint32_t camera) {
  char number[16];
  std::snprintf(number, sizeof number, "%02u_", camera);
  return number + sinks::safe_file_name(description.cameras[camera]);
}

offline::FolderFile text_file(std::string name, const std::string& text) {
  return {std::move(name), {text.begin(), text.end()}};
}

Result<void> write_text(const std::filesystem::path& path, const std::string& text) {
  return write_whole_file(path, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

std::string six_digits(uint64_t number) {
  char text[24];
  std::snprintf(text, sizeof text, "%06llu", static_cast<unsigned long long>(number));
  return text;
}

}  // namespace fire3dv::dataset
