#include "convert/mesh/text/mesh_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <system_error>

#include "base/text.h"

namespace fire3dv::convert {
namespace {

constexpr uint32_t kReplacement = 0xFFFD;

void append_utf8(std::string& text, uint32_t character) {
  const auto add = [&](uint32_t byte) { text += static_cast<char>(byte); };
  if (character < 0x80) {
    add(character);
  } else if (character < 0x800) {
    add(0xC0 | character >> 6);
    add(0x80 | (character & 0x3F));
  } else if (character < 0x10000) {
    add(0xE0 | character >> 12);
    add(0x80 | (character >> 6 & 0x3F));
    add(0x80 | (character & 0x3F));
  } else {
    add(0xF0 | character >> 18);
    add(0x80 | (character >> 12 & 0x3F));
    add(0x80 | (character >> 6 & 0x3F));
    add(0x80 | (character & 0x3F));
  }
}

}  // namespace

std::optional<std::string> utf8_of_utf16(std::string_view bytes) {
  if (bytes.size() < 4) return std::nullopt;
  const bool has_mark = bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF");
  const bool is_little = has_mark ? bytes[0] == '\xFF' : bytes[1] == '\0';
  const size_t low = is_little ? 0 : 1;
  if (!has_mark &&
      (bytes[0] == bytes[1] || bytes[1 - low] != '\0' || bytes[3 - low] != '\0' || bytes[2 + low] == '\0'))
    return std::nullopt;
  const auto unit = [&](size_t at) {
    return static_cast<uint32_t>(static_cast<uint8_t>(bytes[at + low]) |
                                 static_cast<uint8_t>(bytes[at + 1 - low]) << 8);
  };
  std::string text;
  text.reserve(bytes.size() / 2);
  for (size_t at = has_mark ? 2 : 0; at + 1 < bytes.size(); at += 2) {
    uint32_t character = unit(at);
    if (character >= 0xD800 && character < 0xE000) {
      const bool is_pair =
          character < 0xDC00 && at + 3 < bytes.size() && unit(at + 2) >= 0xDC00 && unit(at + 2) < 0xE000;
      character = is_pair ? 0x10000 + ((character - 0xD800) << 10) + (unit(at + 2) - 0xDC00) : kReplacement;
      if (is_pair) at += 2;
    }
    append_utf8(text, character);
  }
  return text;
}

std::string_view without_mark(std::string_view text) {
  return text.starts_with("\xEF\xBB\xBF") ? text.substr(3) : text;
}

std::optional<double> number_of(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  double value = 0;
  const char* const last = word.data() + word.size();
  auto [end, error] = std::from_chars(word.data(), last, value);
  if (end < last && (*end == 'd' || *end == 'D') && error == std::errc()) {
    std::string fortran(word);
    fortran[static_cast<size_t>(end - word.data())] = 'e';
    const auto whole = std::from_chars(fortran.data(), fortran.data() + fortran.size(), value);
    if (whole.ptr != fortran.data() + fortran.size() || whole.ec != std::errc()) return std::nullopt;
    return value;
  }
  if (end != last && end > word.data() && *end == '#') {  // as old programs for Windows write them
    const std::string_view kind = std::string_view(end, last).substr(1, 3);
    if (kind == "INF") return std::copysign(std::numeric_limits<double>::infinity(), value);
    if (kind == "IND" || kind == "QNA" || kind == "SNA") return std::numeric_limits<double>::quiet_NaN();
  }
  if (end != last || word.empty()) return std::nullopt;
  if (error == std::errc::result_out_of_range) {
    // The exponent's sign tells too small numbers from too large ones; long fractions are too small.
    const size_t exponent = word.find_first_of("eE");
    const bool is_large = exponent == std::string_view::npos ? !word.starts_with("0.") && word[0] != '.'
                                                             : word.substr(exponent + 1, 1) != "-";
    return is_large ? std::numeric_limits<double>::infinity() : 0;
  }
  if (error != std::errc()) return std::nullopt;
  return value;
}

bool has_decimal_comma(std::string_view word) {
  std::string with_point(word);
  std::replace(with_point.begin(), with_point.end(), ',', '.');
  return with_point != word && number_of(with_point);
}

std::string not_a_number(std::string_view word) {
  if (word.empty()) return "a number is missing";
  return quote(word) + (number_of(word)           ? " is not finite"
                        : has_decimal_comma(word) ? " has a decimal comma; export it with decimal points"
                                                  : " is no number");
}

}  // namespace fire3dv::convert
