// Functions and constants of xacro expressions: Python's that xacro exposes, those of math, and xacro's own.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "convert/xacro/expression/expression.h"

namespace fire3dv::convert::xacro {

// Functions, constants and modules that need no prefix.
std::optional<Value> global_value(const std::string& name);
// module: math, python or xacro.
std::optional<Value> module_value(const std::string& module, const std::string& name);
bool is_method(const Value& object, const std::string& name);

// keywords: names of the last arguments.
Value call_function(const Function& function, std::vector<Value> arguments,
                    const std::vector<std::string>& keywords, Environment& environment, Budget& budget);

// Python's text % values: %s %r %d %i %f %e %g %x %% with flags, width and precision.
std::string formatted(const std::string& text, const Value& values, Budget& budget);

}  // namespace fire3dv::convert::xacro
