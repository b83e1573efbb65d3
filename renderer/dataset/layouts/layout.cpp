#include "renderer/dataset/layouts/layout.h"

#include <cstdio>

#include "base/files.h"
#include "renderer/dataset/layouts/bop.h"
#include "renderer/dataset/layouts/coco.h"
#include "renderer/dataset/layouts/sequence.h"
#include "renderer/dataset/layouts/yolo.h"

namespace fire3dv::dataset {

std::unique_ptr<Layout> make_layout(const std::string& format) {
  if (format == "bop") return std::make_unique<BopLayout>();
  if (format == "coco") return std::make_unique<CocoLayout>();
  if (format == "yolo") return std::make_unique<YoloLayout>();
  if (format == "c3vd") return std::make_unique<C3vdLayout>();
  if (format == "folder") return std::make_unique<FolderLayout>();
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
