// Vectors of plain numbers: concatenation and comparison.
#pragma once

#include <cstring>
#include <vector>

namespace fire3dv {

template <typename T>
void append_all(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

// Compares the bytes of numbers without padding: a change of sign of a zero counts.
template <typename T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

}  // namespace fire3dv
