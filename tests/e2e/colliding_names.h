// Node names whose std::hash collides in libstdc++: its hash of strings has a fixed seed, so that equal
// hashes can be computed instead of searched.
#pragma once

#include <string>
#include <vector>

namespace fire3dv::test {

// Distinct names of 16 printable ASCII characters, all of one hash. Empty where std::hash is another
// function.
std::vector<std::string> colliding_names(size_t count);

}  // namespace fire3dv::test
