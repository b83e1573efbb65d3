// Text of mesh files: UTF-16 to UTF-8, and numbers as exporters write them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace fire3dv::convert {

// UTF-8 of UTF-16 text of either byte order, with a byte order mark or without. Nothing for other text.
std::optional<std::string> utf8_of_utf16(std::string_view bytes);

// Without a byte order mark of UTF-8.
std::string_view without_mark(std::string_view text);

// Number of a whole word: also ".5", "+1", and Fortran's "1d0". Too small ones are 0, too large ones
// infinite. NaN and infinity also as "-nan(ind)" and "1.#QNAN".
std::optional<double> number_of(std::string_view word);

// True for a number such as "0,5".
bool has_decimal_comma(std::string_view word);

// Why a word is no number, for messages: names decimal commas.
std::string not_a_number(std::string_view word);

}  // namespace fire3dv::convert
