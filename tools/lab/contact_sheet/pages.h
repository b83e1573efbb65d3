// Writer of contact sheets: PNG pages of thumbnails with their names, and a text index.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/sinks/frame.h"
#include "tools/lab/contact_sheet/page_text.h"

namespace fire3dv::contact_sheet {

struct PageLayout {
  uint32_t columns = 8, rows = 6;
  uint32_t width = 160, height = 120;  // of a thumbnail, pixels
};

class Pages {
 public:
  // The folder must exist.
  Pages(std::filesystem::path folder, const PageLayout& layout)
      : folder_(std::move(folder)), layout_(layout) {}

  // image: must have the size of thumbnails. note: additional text for the index. warnings: one line each of
  // the index; the thumbnail of a file with warnings has a mark.
  Result<void> add(const std::string& name, const sinks::FrameImage& image, const std::string& note,
                   const std::vector<std::string>& warnings);
  void add_refused(const std::string& name, const std::string& reason);
  Result<void> finish();  // writes the last page and index.txt
  uint32_t page_count() const { return pages_; }

 private:
  void begin_page();
  Result<void> end_page();

  std::filesystem::path folder_;
  PageLayout layout_;
  PageText text_;
  sinks::FrameImage page_;
  uint32_t on_page_ = 0, pages_ = 0;
  std::string index_, refused_;
};

}  // namespace fire3dv::contact_sheet
