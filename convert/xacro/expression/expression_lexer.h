// Tokens of xacro's expressions.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "convert/xacro/expression/value.h"

namespace fire3dv::convert::xacro {

enum class TokenKind { number, string, name, symbol, end };
struct Token {
  TokenKind kind = TokenKind::end;
  std::string text;  // of a string: its value
  Value value;       // of a number
};

// Splits an expression into tokens. Fails for malformed numbers and strings.
class Lexer {
 public:
  explicit Lexer(std::string_view text) : text_(text) {}

  Token next();

 private:
  Token number();
  Token string(bool raw);

  std::string_view text_;
  size_t at_ = 0;
};

}  // namespace fire3dv::convert::xacro
