// Functions and constants of Python's module math in xacro expressions.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "convert/xacro/expression/value.h"

namespace fire3dv::convert::xacro {

bool is_math_function(const std::string& name);
std::optional<double> math_constant(const std::string& name);
Value call_math(const std::string& name, const std::vector<Value>& arguments);

// Fails for another number of arguments of the function.
void expect_count(const std::vector<Value>& arguments, size_t fewest, size_t most, const std::string& name);
// Result of floor(), ceil(), round() and int(). Fails outside of 64 bits.
Value whole_number(double value, const std::string& name);

}  // namespace fire3dv::convert::xacro
