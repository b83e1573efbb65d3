// Hash-flooding node names: their std::hash values collide in libstdc++. Its string hash has a fixed seed, so
// collisions are computed by inversion instead of search.
#pragma once

#include <string>
#include <vector>

namespace fire3dv::test {

// Returns distinct names of 16 printable ASCII characters with one common hash. Empty if std::hash is another
// function.
std::vector<std::string> colliding_names(size_t count);

}  // namespace fire3dv::test
