// A fuzz target is a source that defines these two. It runs under libFuzzer, or under driver.cpp, which needs
// no special compiler: what CI runs everywhere is then the same code that ran for hours elsewhere.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace fire3dv::fuzz {

using Input = std::vector<uint8_t>;

// Sound inputs to begin with.
std::vector<Input> seeds();

}  // namespace fire3dv::fuzz
