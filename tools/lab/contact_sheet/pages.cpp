#include "tools/lab/contact_sheet/pages.h"

#include <algorithm>
#include <cstdio>

#include "protocol/base/file_io.h"
#include "renderer/sinks/png.h"
#include "renderer/sinks/text.h"

namespace fire3dv::contact_sheet {
namespace {

constexpr uint32_t kGap = 6;
constexpr uint32_t kLabelLines = 2;
constexpr uint32_t kLabelHeight = kLabelLines * kLineHeight + kDot;
constexpr uint8_t kPaper = 24;
constexpr std::array<uint8_t, 3> kInk{225, 225, 225};

std::string page_name(uint32_t number) {
  char name[32];
  std::snprintf(name, sizeof name, "page_%03u.png", number);
  return name;
}

// Sanitises untrusted names to one line of the index.
std::string one_line(const std::string& text) {
  constexpr size_t kLongest = 1000;
  return sinks::printable_utf8(text, kLongest);
}

// Bitmap letter: five rows from the top; each digit holds three pixels, the left one worth 4.
struct Letter {
  char character;
  std::string_view rows;
};
constexpr Letter kLetters[] = {
    {'A', "25755"}, {'B', "65656"}, {'C', "34443"}, {'D', "65556"}, {'E', "74647"}, {'F', "74644"},
    {'G', "34553"}, {'H', "55755"}, {'I', "72227"}, {'J', "11152"}, {'K', "55655"}, {'L', "44447"},
    {'M', "57755"}, {'N', "65555"}, {'O', "25552"}, {'P', "65644"}, {'Q', "25573"}, {'R', "65655"},
    {'S', "34216"}, {'T', "72222"}, {'U', "55557"}, {'V', "55552"}, {'W', "55775"}, {'X', "55255"},
    {'Y', "55222"}, {'Z', "71247"}, {'0', "75557"}, {'1', "26227"}, {'2', "61247"}, {'3', "61216"},
    {'4', "55711"}, {'5', "74616"}, {'6', "34652"}, {'7', "71122"}, {'8', "25252"}, {'9', "25316"},
    {'.', "00002"}, {'_', "00007"}, {'-', "00700"}, {'/', "11244"}, {'+', "02720"}, {'(', "12221"},
    {')', "42224"}, {',', "00024"}, {':', "02020"}, {' ', "00000"}, {'?', "61202"}};

std::string_view rows_of(char character) {
  if (character >= 'a' && character <= 'z') character = static_cast<char>(character - 'a' + 'A');
  const auto* found = std::find_if(std::begin(kLetters), std::end(kLetters),
                                   [&](const Letter& letter) { return letter.character == character; });
  return found == std::end(kLetters) ? kLetters[std::size(kLetters) - 1].rows : found->rows;
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

Result<void> Pages::add(const std::string& name, const sinks::FrameImage& image, const std::string& note) {
  FIRE3DV_ASSERT(image.width == layout_.width && image.height == layout_.height);
  if (on_page_ == 0) begin_page();
  const uint32_t column = on_page_ % layout_.columns, row = on_page_ / layout_.columns;
  const uint32_t left = kGap + column * (layout_.width + kGap);
  const uint32_t top = kGap + row * (layout_.height + kLabelHeight + kGap);
  for (uint32_t y = 0; y < image.height; ++y) {
    std::copy_n(image.rgba8.begin() + size_t{4} * y * image.width, size_t{4} * image.width,
                page_.rgba8.begin() + 4 * (size_t{top + y} * page_.width + left));
  }
  // The end of a name distinguishes files better than its start.
  const size_t letters = std::max(layout_.width / kLetterWidth, 1u);
  const std::string label =
      name.size() > kLabelLines * letters ? name.substr(name.size() - kLabelLines * letters) : name;
  for (uint32_t line = 0; line < kLabelLines && line * letters < label.size(); ++line) {
    write_text(page_, left, top + layout_.height + kDot + line * kLineHeight,
               label.substr(line * letters, letters), kInk);
  }
  index_ += page_name(pages_) + " row " + std::to_string(row + 1) + " column " + std::to_string(column + 1) +
            ": " + one_line(name) + ": " + one_line(note) + '\n';
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

void write_text(sinks::FrameImage& image, uint32_t x, uint32_t y, std::string_view text,
                std::array<uint8_t, 3> color) {
  for (const char character : text) {
    const std::string_view rows = rows_of(character);
    for (uint32_t i = 0; i < 5 * kDot * 3 * kDot; ++i) {
      const uint32_t dx = i % (3 * kDot), dy = i / (3 * kDot);
      if (!((rows[dy / kDot] - '0') >> (2 - dx / kDot) & 1)) continue;
      if (x + dx >= image.width || y + dy >= image.height) continue;
      std::copy(color.begin(), color.end(),
                image.rgba8.begin() + 4 * (size_t{y + dy} * image.width + x + dx));
    }
    x += kLetterWidth;
  }
}

}  // namespace fire3dv::contact_sheet
