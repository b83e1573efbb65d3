#include "tools/convert/text.h"

namespace fire3dv::convert {
namespace {

// Bytes of the character at the start of text; 0: it is none that may stand in a name.
size_t character_bytes(std::string_view text) {
  const auto byte = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return first >= 0x20 && first != 0x7f ? 1 : 0;
  const size_t size = first >= 0xf0 && first < 0xf5 ? 4 : first >= 0xe0 ? 3 : first >= 0xc2 ? 2 : 0;
  if (size == 0 || first >= 0xf5 || text.size() < size) return 0;
  unsigned long code = first & (0xffu >> (size + 1));
  for (size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
    code = code << 6 | (byte(i) & 0x3f);
  }
  const bool too_long = (size == 3 && code < 0x800) || (size == 4 && (code < 0x10000 || code > 0x10ffff));
  const bool control = code < 0xa0 || (code >= 0xd800 && code < 0xe000) || code == 0x2028 || code == 0x2029 ||
                       (code >= 0x202a && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
  return too_long || control ? 0 : size;
}

}  // namespace

std::string clean_text(std::string_view text, size_t most_bytes) {
  std::string clean;
  while (!text.empty()) {
    const size_t size = character_bytes(text);
    if (clean.size() + (size ? size : 1) > most_bytes) break;
    if (size == 0)
      clean += '?';
    else
      clean += text.substr(0, size);
    text.remove_prefix(size ? size : 1);
  }
  return clean;
}

}  // namespace fire3dv::convert
