#include "tools/lab/contact_sheet/pages.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "base/files.h"
#include "base/text.h"
#include "renderer/sinks/png.h"

namespace fire3dv::contact_sheet {
namespace {

constexpr uint32_t kGap = 6;  // pixels
constexpr uint32_t kLabelLines = 2;
constexpr uint32_t kLabelHeight = kLabelLines * PageText::kLineHeight + 2;
constexpr uint8_t kPaper = 24;
constexpr std::array<uint8_t, 3> kInk{225, 225, 225}, kWarningInk{255, 196, 64};
constexpr size_t kMaxWarnings = 20;  // of a file, in the index

std::string page_name(uint32_t number) {
  char name[32];
  std::snprintf(name, sizeof name, "page_%03u.png", number);
  return name;
}

// Sanitises untrusted text to one line of the index.
std::string one_line(const std::string& text) {
  constexpr size_t kLongest = 1000;
  return printable_text(text, kLongest);
}

}  // namespace

void Pages::begin_page() {
  page_.width = kGap + layout_.columns * (layout_.width + kGap);
  page_.height = kGap + layout_.rows * (layout_.height + kLabelHeight + kGap);
  page_.rgba8.assign(size_t{4} * page_.width * page_.height, kPaper);
  for (size_t alpha = 3; alpha < page_.rgba8.size(); alpha += 4) page_.rgba8[alpha] = 255;
  on_page_ = 0;
  ++pages_;
}

Result<void> Pages::end_page() {
  on_page_ = 0;
  return sinks::write_png(folder_ / page_name(pages_), page_);
}

Result<void> Pages::add(const std::string& name, const sinks::FrameImage& image, const std::string& note,
                        const std::vector<std::string>& warnings) {
  FIRE3DV_ASSERT(image.width == layout_.width && image.height == layout_.height);
  if (on_page_ == 0) begin_page();
  const uint32_t column = on_page_ % layout_.columns, row = on_page_ / layout_.columns;
  const uint32_t left = kGap + column * (layout_.width + kGap);
  const uint32_t top = kGap + row * (layout_.height + kLabelHeight + kGap);
  for (uint32_t y = 0; y < image.height; ++y) {
    std::copy_n(image.rgba8.begin() + size_t{4} * y * image.width, size_t{4} * image.width,
                page_.rgba8.begin() + 4 * (size_t{top + y} * page_.width + left));
  }
  const std::string shown = one_line(name);
  // The file's name, and above it the end of its folder: those distinguish files better than a start.
  const size_t slash = shown.rfind('/');
  const std::string folder = slash == std::string::npos ? "" : shown.substr(0, slash + 1);
  const std::string file = slash == std::string::npos ? shown : shown.substr(slash + 1);
  const std::array<uint8_t, 3>& ink = warnings.empty() ? kInk : kWarningInk;
  text_.draw(page_, left, top + layout_.height + 2, layout_.width, file, ink);
  text_.draw(page_, left, top + layout_.height + 2 + PageText::kLineHeight, layout_.width, folder, ink);
  index_ += page_name(pages_) + " row " + std::to_string(row + 1) + " column " + std::to_string(column + 1) +
            ": " + shown + ": " + one_line(note) + '\n';
  for (size_t i = 0; i < std::min(warnings.size(), kMaxWarnings); ++i)
    index_ += "  warning: " + one_line(warnings[i]) + '\n';
  if (warnings.size() > kMaxWarnings)
    index_ += "  " + std::to_string(warnings.size() - kMaxWarnings) + " more warnings\n";
  if (++on_page_ < layout_.columns * layout_.rows) return {};
  return end_page();
}

void Pages::add_refused(const std::string& name, const std::string& reason) {
  refused_ += "refused: " + one_line(name) + ": " + one_line(reason) + '\n';
}

Result<void> Pages::finish() {
  if (on_page_ > 0) {
    if (Result<void> written = end_page(); !written) return written;
  }
  const std::string text = index_ + refused_;
  return fire3dv::write_whole_file(folder_ / "index.txt",
                                   {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

}  // namespace fire3dv::contact_sheet
