#include "tools/lab/contact_sheet/letters.h"

#include <algorithm>

namespace fire3dv::contact_sheet {
namespace {

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
