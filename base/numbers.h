// Numbers in texts, whatever the locale.
#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

namespace fire3dv {

// The number that the whole text is; nullopt for other texts, among them those with blanks or a plus sign,
// and for numbers that the type does not hold. base: of whole numbers. Floats may be infinite or NaN.
template <typename Number, typename... Base>
std::optional<Number> parse_number(std::string_view text, Base... base) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base...);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Two numbers with this character between them, such as 1280x720.
template <typename Number>
std::optional<std::pair<Number, Number>> parse_pair(std::string_view text, char between) {
  const size_t at = text.find(between);
  if (at == std::string_view::npos) return std::nullopt;
  const std::optional<Number> first = parse_number<Number>(text.substr(0, at));
  const std::optional<Number> second = parse_number<Number>(text.substr(at + 1));
  if (!first || !second) return std::nullopt;
  return std::pair(*first, *second);
}

}  // namespace fire3dv
