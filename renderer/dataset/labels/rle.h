// Run-length encoding of masks, as COCO defines it: pixels in columns from the left, each from the top.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace fire3dv::dataset {

// Pixels of a mask: ranges [first, end) of column-major pixel numbers x * height + y, ascending and apart.
using Runs = std::vector<std::pair<uint32_t, uint32_t>>;

// Masks of all instances but 0. instances: one per pixel, rows from the top.
std::map<uint32_t, Runs> masks_of_instances(std::span<const uint32_t> instances, uint32_t width,
                                            uint32_t height);

uint64_t count_pixels(const Runs& runs);

// Lengths of runs of 0, of 1, of 0 and so on, as text: COCO's compressed form ("counts").
std::string encode_counts(const Runs& runs, uint64_t pixels);
// Inverse. Empty if the text is not of so many pixels.
Runs decode_counts(const std::string& counts, uint64_t pixels);

// Pixels of 0 and 255, rows from the top.
std::vector<uint8_t> mask_pixels(const Runs& runs, uint32_t width, uint32_t height);

}  // namespace fire3dv::dataset
