// Expressions of xacro, ${...}: a subset of Python. Literals, names, arithmetic, comparisons, and/or/not,
// conditional expressions, lists and tuples, indices and slices, attributes, and calls of a fixed set of
// functions (functions.h). Lambdas, comprehensions and everything else are refused.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "convert/xacro/expression/budget.h"
#include "convert/xacro/expression/value.h"

namespace fire3dv::convert::xacro {

// What an expression may refer to. load_yaml() checks the path.
class Environment {
 public:
  virtual ~Environment() = default;
  // Value of a property; nothing if there is none. scope: null for the current scope.
  virtual std::optional<Value> property(Scope* scope, const std::string& name) = 0;
  virtual std::string argument(const std::string& name) = 0;
  virtual Value load_yaml(const std::string& path) = 0;
  virtual std::string absolute_path(const std::string& path) = 0;
  virtual void message(const std::string& level, const std::string& text) = 0;
};

struct Expression {
  enum class Kind {
    constant,
    name,         // text
    attribute,    // children[0].text
    call,         // children[0](children[1..]); keywords: names of the last arguments
    index,        // children[0][children[1]]
    slice,        // children[0][children[1]:children[2]:children[3]], each may be null
    unary,        // text: operator
    binary,       // text: operator
    comparison,   // children compared in a chain; keywords: operators
    logical_and,  // children
    logical_or,
    conditional,  // children[0] if children[1] else children[2]
    sequence,     // constant: is a tuple
  };
  Kind kind = Kind::constant;
  Value constant;
  std::string text;
  std::vector<std::string> keywords;
  std::vector<std::unique_ptr<Expression>> children;
  size_t depth = 1;
};

// Fails for text that is too long, too deeply nested, or no supported expression.
std::unique_ptr<Expression> parse_expression(std::string_view text);

Value evaluate(const Expression& expression, Environment& environment, Budget& budget);

// Applies a binary operator of arithmetic, concatenation, repetition or text formatting.
Value apply_operator(const std::string& name, const Value& a, const Value& b, Budget& budget);

// Failure for Python that is not supported.
[[noreturn]] void refuse_python(const std::string& what);

}  // namespace fire3dv::convert::xacro
