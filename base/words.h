// Words of text: trimming, and splitting at blanks. ASCII blanks only, whatever the locale.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace fire3dv {

constexpr std::string_view kBlanks = " \t\r\n\v\f";

// Without blanks at both ends.
constexpr std::string_view trimmed(std::string_view text, std::string_view blanks = kBlanks) {
  const size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

// Takes the next word off `text`; empty at the end.
constexpr std::string_view next_word(std::string_view& text, std::string_view blanks = kBlanks) {
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  const std::string_view word = text.substr(0, text.find_first_of(blanks));
  text.remove_prefix(word.size());
  return word;
}

constexpr size_t count_words(std::string_view text) {
  size_t count = 0;
  while (!next_word(text).empty()) ++count;
  return count;
}

}  // namespace fire3dv
