// Writer of contact sheets: PNG pages of thumbnails with names in 3x5 pixel letters, and a text index.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "renderer/sinks/frame.h"

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

  // image: must have the size of thumbnails. note: additional text for the index.
  Result<void> add(const std::string& name, const sinks::FrameImage& image, const std::string& note);
  void add_refused(const std::string& name, const std::string& reason);
  Result<void> finish();  // writes the last page and index.txt
  uint32_t page_count() const { return pages_; }

 private:
  void begin_page();
  Result<void> end_page();

  std::filesystem::path folder_;
  PageLayout layout_;
  sinks::FrameImage page_;
  uint32_t on_page_ = 0, pages_ = 0;
  std::string index_, refused_;
};

constexpr uint32_t kDot = 2;                 // pixels
constexpr uint32_t kLetterWidth = 4 * kDot;  // includes the gap
constexpr uint32_t kLineHeight = 7 * kDot;

// Draws from the top left corner, clipped to the image. Lower case is drawn as upper case, unknown characters
// as question marks.
void write_text(sinks::FrameImage& image, uint32_t x, uint32_t y, std::string_view text,
                std::array<uint8_t, 3> color);

}  // namespace fire3dv::contact_sheet
