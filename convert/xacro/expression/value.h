// Values of xacro expressions with the semantics of Python: None, bool, int (64 bits), float, str, list,
// tuple, dict, and functions of a fixed set. Text of a value is that of Python's str().
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "convert/xacro/expression/budget.h"

namespace fire3dv::convert::xacro {

class Scope;
struct Value;

struct Sequence {
  bool is_tuple = false;
  std::vector<Value> items;
  size_t depth = 1;
  bool is_set = false;  // items differ, in the order of their insertion
};

// In order of insertion, as in Python.
struct Dict {
  std::vector<std::pair<Value, Value>> items;
  std::map<std::string, size_t> index;  // by the repr() of the key
  size_t depth = 1;
};

// Built-in function or method by name.
struct Function {
  std::string name;
  std::shared_ptr<const Value> self;  // of a method
};

// "math", "python" or "xacro".
struct Module {
  std::string name;
};

struct None {};

struct Value {
  std::variant<None, bool, int64_t, double, std::string, std::shared_ptr<const Sequence>,
               std::shared_ptr<const Dict>, Function, Module, Scope*>
      data;

  Value() = default;
  Value(bool value) : data(value) {}
  Value(int64_t value) : data(value) {}
  Value(double value) : data(value) {}
  Value(std::string value) : data(std::move(value)) {}
  Value(const char* value) : data(std::string(value)) {}
  Value(Function value) : data(std::move(value)) {}
  Value(Module value) : data(std::move(value)) {}
  Value(Scope* value) : data(value) {}
  Value(std::shared_ptr<const Sequence> value) : data(std::move(value)) {}
  Value(std::shared_ptr<const Dict> value) : data(std::move(value)) {}

  template <typename T>
  const T* as() const {
    return std::get_if<T>(&data);
  }
  const Sequence* sequence() const {
    const auto* held = as<std::shared_ptr<const Sequence>>();
    return held ? held->get() : nullptr;
  }
  const Dict* dict() const {
    const auto* held = as<std::shared_ptr<const Dict>>();
    return held ? held->get() : nullptr;
  }
  bool is_none() const { return as<None>() != nullptr; }
  bool is_integer() const { return as<int64_t>() || as<bool>(); }
  bool is_number() const { return is_integer() || as<double>(); }
};

// Nesting of lists and dicts is limited, since they are destroyed recursively.
Value make_sequence(std::vector<Value> items, bool is_tuple, Budget& budget);
// Drops items that are equal to earlier ones.
Value make_set(const std::vector<Value>& items, Budget& budget);
// Later values replace earlier ones of the same key.
Value make_dict(std::vector<std::pair<Value, Value>> items, Budget& budget);
// Null if there is none.
const Value* find(const Dict& dict, const Value& key, Budget& budget);

const char* type_name(const Value& value);
bool is_true(const Value& value);
// Bool and int. Fails for other types, with the name of the operation.
int64_t integer(const Value& value, std::string_view operation);
double number(const Value& value, std::string_view operation);

std::string text_of(double value);
std::string text_of(const Value& value, Budget& budget);
std::string repr_of(const Value& value, Budget& budget);

// Values of different types are unequal, except for numbers.
bool equal(const Value& a, const Value& b, Budget& budget);
// Numbers, strings and sequences. Fails for other types, as Python does.
std::partial_ordering compare(const Value& a, const Value& b, Budget& budget);

// Conversions of literals as Python's int() and float(); surrounding white space is allowed.
bool parse_integer(std::string_view text, int64_t& value, int base = 10);
bool parse_float(std::string_view text, double& value);

// Value of a property's or parameter's text: number, boolean, or text without enclosing apostrophes.
Value literal(std::string text);

}  // namespace fire3dv::convert::xacro
