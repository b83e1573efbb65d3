#include "renderer/dataset/layouts/layout.h"

#include <cstdio>

#include "base/files.h"
#include "renderer/dataset/layouts/layouts.h"

namespace fire3dv::dataset {

std::unique_ptr<Layout> make_layout(const std::string& format) {
  if (format == "bop") return make_bop_layout();
  if (format == "coco") return make_coco_layout();
  if (format == "yolo") return make_yolo_layout();
  if (format == "c3vd") return make_c3vd_layout();
  if (format == "folder") return make_folder_layout();
  return nullptr;
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
