#include "convert/xacro/expression/expression_lexer.h"

#include <cstdint>
#include <utility>

#include "convert/xacro/expression/budget.h"
#include "convert/xacro/expression/expression.h"

namespace fire3dv::convert::xacro {
namespace {

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' ||
         static_cast<unsigned char>(c) >= 0x80;
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

}  // namespace

Token Lexer::next() {
  while (at_ < text_.size() &&
         (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n' || text_[at_] == '\r'))
    ++at_;
  if (at_ == text_.size()) return {};
  const char c = text_[at_];
  if (is_digit(c) || (c == '.' && at_ + 1 < text_.size() && is_digit(text_[at_ + 1]))) return number();
  if (c == '\'' || c == '"') return string(false);
  if (is_letter(c)) {
    const size_t begin = at_;
    while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
    const std::string name(text_.substr(begin, at_ - begin));
    const bool quote_follows = at_ < text_.size() && (text_[at_] == '\'' || text_[at_] == '"');
    if (quote_follows && (name == "u" || name == "r" || name == "R")) return string(name != "u");
    if (quote_follows) refuse_python("a string with the prefix " + name);
    return {TokenKind::name, name, {}};
  }
  for (const std::string_view symbol : {"**", "//", "<=", ">=", "==", "!=", "<<", ">>"})
    if (text_.substr(at_).starts_with(symbol)) {
      at_ += 2;
      return {TokenKind::symbol, std::string(symbol), {}};
    }
  ++at_;
  return {TokenKind::symbol, std::string(1, c), {}};
}

Token Lexer::number() {
  const size_t begin = at_;
  const auto digits = [&] {
    while (at_ < text_.size() && (is_digit(text_[at_]) || text_[at_] == '_')) ++at_;
  };
  if (text_[at_] == '0' && at_ + 1 < text_.size() &&
      std::string_view("xXbBoO").find(text_[at_ + 1]) != std::string_view::npos) {
    const char kind = static_cast<char>(text_[at_ + 1] | 0x20);
    at_ += 2;
    const size_t first = at_;
    while (at_ < text_.size() && (is_digit(text_[at_]) || is_letter(text_[at_]))) ++at_;
    int64_t value = 0;
    if (!parse_integer(text_.substr(first, at_ - first), value, kind == 'x' ? 16 : kind == 'o' ? 8 : 2))
      throw Failure(std::string(text_.substr(begin, at_ - begin)) + " is not a number of 64 bits");
    return {TokenKind::number, {}, value};
  }
  digits();
  bool real = false;
  if (at_ < text_.size() && text_[at_] == '.') {
    real = true;
    ++at_;
    digits();
  }
  if (at_ < text_.size() && (text_[at_] == 'e' || text_[at_] == 'E')) {
    const size_t sign = at_ + 1 < text_.size() && (text_[at_ + 1] == '+' || text_[at_ + 1] == '-') ? 1 : 0;
    if (at_ + 1 + sign < text_.size() && is_digit(text_[at_ + 1 + sign])) {
      real = true;
      at_ += 1 + sign;
      digits();
    }
  }
  std::string digits_only(text_.substr(begin, at_ - begin));
  if (at_ < text_.size() && is_letter(text_[at_]))
    throw Failure(digits_only + " is followed by a letter: is a multiplication sign missing?");
  std::erase(digits_only, '_');
  int64_t whole = 0;
  double value = 0;
  const bool leading_zero = digits_only.size() > 1 && digits_only[0] == '0' && !real &&
                            digits_only.find_first_not_of('0') != std::string::npos;
  if (leading_zero) throw Failure(digits_only + " has a leading zero, which Python refuses");
  if (!real && parse_integer(digits_only, whole)) return {TokenKind::number, {}, whole};
  if (!real) throw Failure(digits_only + " has more than 64 bits");
  if (!parse_float(digits_only, value)) throw Failure(digits_only + " is not a number");
  return {TokenKind::number, {}, value};
}

Token Lexer::string(bool raw) {
  const char mark = text_[at_++];
  if (text_.substr(at_).starts_with(std::string(2, mark))) refuse_python("a string with three quotes");
  std::string value;
  while (at_ < text_.size() && text_[at_] != mark) {
    char c = text_[at_++];
    if (c == '\\' && at_ < text_.size()) {
      const char escaped = text_[at_++];
      constexpr std::string_view kFrom = "ntr\\'\"", kTo = "\n\t\r\\'\"";
      const size_t known = kFrom.find(escaped);
      if (!raw && known != std::string_view::npos) {
        value += kTo[known];
        continue;
      }
      value += c;
      c = escaped;
    }
    value += c;
  }
  if (at_ == text_.size()) throw Failure("a string has no closing quote");
  ++at_;
  return {TokenKind::string, std::move(value), {}};
}

}  // namespace fire3dv::convert::xacro
