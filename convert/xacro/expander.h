// Expansion of the elements of a xacro document: properties, macros, blocks, includes and conditions.
#pragma once

#include "convert/xacro/document.h"
#include "convert/xacro/expression/budget.h"
#include "convert/xacro/substitution.h"

namespace fire3dv::convert::xacro {

// Throws Failure with the location of the element at fault.
Element expand(const Element& root, Substitution& substitution, Budget& budget);

}  // namespace fire3dv::convert::xacro
