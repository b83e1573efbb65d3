// Interface of a fuzz target: a source file that defines these two functions. It runs under libFuzzer, or
// under driver.cpp, which needs no special compiler, so CI and long libFuzzer runs test the same code.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace fire3dv::fuzz {

using Input = std::vector<uint8_t>;

// Returns valid inputs for the initial corpus.
std::vector<Input> seeds();

}  // namespace fire3dv::fuzz
