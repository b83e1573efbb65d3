// UTF-8 decoding and sanitising of untrusted text for terminals and logs. Used by the wire format validation
// and by every message that quotes a name from a peer or a file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace fire3dv {

// ASCII letters only, whatever the locale.
inline std::string lower_case(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + ('a' - 'A'));
  }
  return text;
}

constexpr uint32_t kInvalidCharacter = UINT32_MAX;

// Decodes the character at `at` and advances `at` past it. Invalid UTF-8 yields kInvalidCharacter and
// advances `at` by one byte.
inline uint32_t next_character(std::string_view text, size_t& at) {
  const auto byte = [&](size_t i) { return static_cast<uint8_t>(text[i]); };
  const uint8_t lead = byte(at++);
  if (lead < 0x80) return lead;
  const uint32_t more = lead >= 0xF0 ? 3 : lead >= 0xE0 ? 2 : 1;
  if (lead < 0xC2 || lead > 0xF4 || text.size() - at < more) return kInvalidCharacter;
  uint32_t character = lead & (0x3Fu >> more);
  for (uint32_t i = 0; i < more; ++i) {
    if ((byte(at + i) & 0xC0) != 0x80) return kInvalidCharacter;
    character = character << 6 | (byte(at + i) & 0x3F);
  }
  constexpr uint32_t kSmallestOfLength[] = {0, 0x80, 0x800, 0x10000};
  const bool surrogate = character >= 0xD800 && character <= 0xDFFF;
  if (character < kSmallestOfLength[more] || character > 0x10FFFF || surrogate) return kInvalidCharacter;
  at += more;
  return character;
}

// True for control characters (C0, DEL, C1), line and paragraph separators, and bidirectional controls. A
// name that contains them could overwrite or reorder the surrounding text.
inline bool is_control(uint32_t character) {
  return character < 0x20 || (character >= 0x7F && character < 0xA0) || character == 0x2028 ||
         character == 0x2029 || (character >= 0x202A && character <= 0x202E) ||
         (character >= 0x2066 && character <= 0x2069);
}

// Converts arbitrary bytes to printable UTF-8. Invalid bytes and control characters become '?'. The text is
// truncated at a character boundary to at most max_bytes.
inline std::string printable_text(std::string_view text, size_t max_bytes) {
  std::string result;
  for (size_t at = 0; at < text.size();) {
    const size_t start = at;
    const uint32_t character = next_character(text, at);
    const bool bad = character == kInvalidCharacter || is_control(character);
    const std::string_view piece = bad ? std::string_view("?") : text.substr(start, at - start);
    if (result.size() + piece.size() > max_bytes) break;
    result += piece;
  }
  return result;
}

// Same as printable_text() for multi-line terminal messages: preserves newlines and tabs.
inline std::string terminal_text(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (size_t at = 0; at < text.size();) {
    const size_t start = at;
    const uint32_t character = next_character(text, at);
    const bool layout = character == '\n' || character == '\t';
    const bool bad = !layout && (character == kInvalidCharacter || is_control(character));
    result += bad ? std::string_view("?") : text.substr(start, at - start);
  }
  return result;
}

// Name of a node as a part of a path such as "arm/hand": "/" becomes "~1" and "~" becomes "~0", as in JSON
// pointers (RFC 6901; SPEC.md section 7).
inline std::string path_part(std::string_view name) {
  std::string part;
  part.reserve(name.size());
  for (const char c : name) {
    if (c == '~' || c == '/') {
      part += c == '~' ? "~0" : "~1";
    } else {
      part += c;
    }
  }
  return part;
}

// Text from a file or a peer in quotation marks, for messages: printable and cut after 120 characters.
inline std::string quote(std::string_view text) {
  constexpr size_t kMaxCharacters = 120;
  return "\"" + printable_text(text, kMaxCharacters) + (text.size() > kMaxCharacters ? "...\"" : "\"");
}

}  // namespace fire3dv
