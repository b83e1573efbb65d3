// Methods of strings, lists and dicts in xacro expressions, and formatting of text.
#pragma once

#include <string>
#include <vector>

#include "convert/xacro/expression/value.h"

namespace fire3dv::convert::xacro {

Value call_method(const Value& object, const std::string& name, const std::vector<Value>& arguments,
                  Budget& budget);

// xacro.tokenize(text, separators, skip_empty).
Value tokenized(const std::vector<Value>& arguments, Budget& budget);

}  // namespace fire3dv::convert::xacro
