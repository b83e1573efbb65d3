// Typed access to tinygltf::Value members of extensions and extras.
#pragma once

#include <tiny_gltf.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "renderer/scene/gltf/gltf_document.h"

namespace fire3dv::scene {

inline double number_or(const tinygltf::Value& object, const char* member, double otherwise) {
  return object.Has(member) && object.Get(member).IsNumber() ? object.Get(member).GetNumberAsDouble()
                                                             : otherwise;
}

inline int index_or(const tinygltf::Value& object, const char* member, int otherwise) {
  return object.Has(member) ? object.Get(member).GetNumberAsInt() : otherwise;
}

// Clamps a factor to its range, with a warning.
inline float in_range_or_warn(double number, double low, double high, const std::string& name,
                              std::vector<std::string>& warnings) {
  const double taken = std::clamp(number, low, high);
  if (taken != number) {
    char limit[32];
    std::snprintf(limit, sizeof limit, "%g", taken);
    warnings.push_back(name + (number < low ? " is less than " : " is more than ") + limit +
                       ", which is taken in its place");
  }
  return to_float(taken);
}

}  // namespace fire3dv::scene
